"""Tests that ran in another process, reported here one by one, under the same test ids."""

import contextlib
import json
import os
import pathlib
import signal
from collections.abc import Mapping, Sequence

import pytest

Reports = Mapping[str, Sequence[pytest.TestReport]]  # by test id


class Reporter:
    """There: every report becomes a line of JSON in a file."""

    def __init__(self, config: pytest.Config, path: pathlib.Path, *, dies: bool = False) -> None:
        """`dies`: with a guest, whose files are written when it likes."""
        self._config, self._path, self._dies = config, path, dies

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        data = self._config.hook.pytest_report_to_serializable(config=self._config, report=report)
        with self._path.open("a", encoding="utf-8") as file:
            print(json.dumps(data), file=file, flush=True)
            if self._dies:
                os.fsync(file.fileno())  # a guest that dies has reported everything


class Coming:
    """Here: what such a process has reported until now, read as it comes."""

    def __init__(self, config: pytest.Config, path: pathlib.Path) -> None:
        self._config, self._path, self._read = config, path, 0
        self._results: dict[str, list[pytest.TestReport]] = {}

    def take(self) -> Reports:
        """Whole lines only: the last one may be half written, or of a process that died."""
        if not self._path.exists():
            return self._results
        with self._path.open("rb") as file:
            file.seek(self._read)
            data = file.read()
        lines = data[: data.rfind(b"\n") + 1]
        self._read += len(lines)
        for line in lines.splitlines():
            report = report_of(self._config, json.loads(line))
            self._results.setdefault(report.nodeid, []).append(report)
        return self._results


def report_of(config: pytest.Config, data: object) -> pytest.TestReport:
    """A report as pytest needs it: where and why a test was skipped is a tuple there and a list in JSON."""
    report: pytest.TestReport = config.hook.pytest_report_from_serializable(config=config, data=data)
    if isinstance(report.longrepr, list):
        file, line, reason = report.longrepr
        report.longrepr = (file, line, reason)
    return report


def read(config: pytest.Config, path: pathlib.Path) -> Reports:
    """What the other process has reported; nothing if it never began."""
    results: dict[str, list[pytest.TestReport]] = {}
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        with contextlib.suppress(json.JSONDecodeError):  # the half line of a process that died
            report = report_of(config, json.loads(line))
            results.setdefault(report.nodeid, []).append(report)
    return results


def all_well(ids: Sequence[str], reports: Reports) -> bool:
    """Whether each of these tests ended, and none failed."""
    told = [reports.get(name, ()) for name in ids]
    return all(any(report.when == "teardown" for report in each) and not any(report.failed for report in each) for each in told)


def ended(ids: Sequence[str], reports: Reports) -> bool:
    return all(any(report.when == "teardown" for report in reports.get(name, ())) for name in ids)


def replay(item: pytest.Item, nextitem: pytest.Item | None, reports: Reports, why: str) -> None:
    """Reports the results of this test; one that did not end has failed, and `why` gives what is known."""
    tell(item, reports, why)
    item.session._setupstate.teardown_exact(nextitem)  # this item's packages were never set up here


def tell(item: pytest.Item, reports: Reports, why: str) -> None:
    told = reports.get(item.nodeid, ())
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in told:
        item.ihook.pytest_runtest_logreport(report=report)
    if not any(report.when == "teardown" for report in told):
        failed = pytest.TestReport(item.nodeid, item.location, dict.fromkeys(item.keywords, 1), "failed", why, "call")
        item.ihook.pytest_runtest_logreport(report=failed)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)


def no_time_out() -> None:
    """pytest-timeout's clock is for one test; the other process runs all of its tests under its own limit."""
    signal.setitimer(signal.ITIMER_REAL, 0)
