"""Reports of tests that ran in another process, passed on one by one under the same test ids."""

import contextlib
import json
import os
import pathlib
import signal
from collections.abc import Mapping, Sequence

import pytest

Reports = Mapping[str, Sequence[pytest.TestReport]]  # by test id


class Reporter:
    """In the other process: write each report as a line of JSON to a file."""

    def __init__(self, config: pytest.Config, path: pathlib.Path, *, dies: bool = False) -> None:
        """`dies`: this process can end with its guest, so that each line is synchronised to the disk."""
        self._config, self._path, self._dies = config, path, dies

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        data = self._config.hook.pytest_report_to_serializable(config=self._config, report=report)
        with self._path.open("a", encoding="utf-8") as file:
            print(json.dumps(data), file=file, flush=True)
            if self._dies:
                os.fsync(file.fileno())  # nothing is lost when the guest ends without warning


class Incoming:
    """In this process: read the reports of the other process while it runs."""

    def __init__(self, config: pytest.Config, path: pathlib.Path) -> None:
        self._config, self._path, self._read = config, path, 0
        self._results: dict[str, list[pytest.TestReport]] = {}

    def take(self) -> Reports:
        """Return all reports so far.  Reads complete lines only: the last one may be half written, or of a process that died."""
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
    """Convert a report to the form pytest needs: place and reason of a skipped test are a tuple there and a list in JSON."""
    report: pytest.TestReport = config.hook.pytest_report_from_serializable(config=config, data=data)
    if isinstance(report.longrepr, list):
        file, line, reason = report.longrepr
        report.longrepr = (file, line, reason)
    return report


def read(config: pytest.Config, path: pathlib.Path) -> Reports:
    """Return all reports of a process that has ended; none if it never began."""
    results: dict[str, list[pytest.TestReport]] = {}
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        with contextlib.suppress(json.JSONDecodeError):  # half a line of a process that died
            report = report_of(config, json.loads(line))
            results.setdefault(report.nodeid, []).append(report)
    return results


def all_passed(ids: Sequence[str], reports: Reports) -> bool:
    """Return whether each of these tests ended and none failed."""
    found = [reports.get(name, ()) for name in ids]
    return all(any(report.when == "teardown" for report in each) and not any(report.failed for report in each) for each in found)


def ended(ids: Sequence[str], reports: Reports) -> bool:
    return all(any(report.when == "teardown" for report in reports.get(name, ())) for name in ids)


def replay(item: pytest.Item, nextitem: pytest.Item | None, reports: Reports, why: str) -> None:
    """Report the results of this test; one that did not end has failed with the text `why`."""
    pass_on(item, reports, why)
    item.session._setupstate.teardown_exact(nextitem)  # this item's packages were never set up here


def pass_on(item: pytest.Item, reports: Reports, why: str) -> None:
    """As `replay`, for a test whose packages are torn down already."""
    found = reports.get(item.nodeid, ())
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in found:
        item.ihook.pytest_runtest_logreport(report=report)
    if not any(report.when == "teardown" for report in found):
        failed = pytest.TestReport(item.nodeid, item.location, dict.fromkeys(item.keywords, 1), "failed", why, "call")
        item.ihook.pytest_runtest_logreport(report=failed)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)


def no_time_out() -> None:
    """Stop pytest-timeout's clock: it is for one test, and the other process runs each of its tests under a limit of its own."""
    signal.setitimer(signal.ITIMER_REAL, 0)
