"""Lane vcan: the tests marked `vcan` are collected here, run in one guest, and reported here one by one.

Each guest test counts as a test of this session: the guest's pytest writes its reports to a host file, they are replayed
under the same test ids.  A guest that dies fails every test it did not report.
"""

import contextlib
import json
import os
import pathlib
import shutil
import signal
import sys
from collections.abc import Iterator

import pytest

from hil_tests import lanes
from hil_tests.rig.uml.guest import Guest, GuestError

REPORTS = "AXISGATE_GUEST_REPORTS"  # set inside the guest: file for the reports
LIMIT = "AXISGATE_GUEST_LIMIT"  # seconds for the whole lane


def inside() -> bool:
    return REPORTS in os.environ


class Reporter:
    """Inside the guest: every report becomes a line of JSON in a host file."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._path = pathlib.Path(os.environ[REPORTS])

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        data = self._config.hook.pytest_report_to_serializable(config=self._config, report=report)
        with self._path.open("a", encoding="utf-8") as file:
            print(json.dumps(data), file=file, flush=True)
            os.fsync(file.fileno())  # through to the host: a guest that dies has told all it knew


class GuestLane:
    """On the host: runs all selected vcan tests at the first of them, then tells their results in turn."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._results: dict[str, list[pytest.TestReport]] | None = None
        self._died = ""

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        if item.get_closest_marker("vcan") is None or lanes.missing("vcan") is not None:
            return None
        if self._results is None:
            signal.setitimer(signal.ITIMER_REAL, 0)  # pytest-timeout's clock is for one test; the guest runs them all under its own limit
            self._results = self._boot([other.nodeid for other in item.session.items if other.get_closest_marker("vcan")])
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        for report in self._told(item):
            item.ihook.pytest_runtest_logreport(report=report)
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        item.session._setupstate.teardown_exact(nextitem)  # this item's packages were never set up here
        return True

    def _boot(self, ids: list[str]) -> dict[str, list[pytest.TestReport]]:
        folder = self._config.rootpath / "build" / "uml" / f"lane-{os.getpid()}"  # several sessions may run at once
        forget_the_dead(folder.parent)
        folder.mkdir(parents=True, exist_ok=True)
        reports, output = folder / "reports.jsonl", folder / "pytest.log"
        options = ["-p", "no:cacheprovider", "-q", "--color=no", f"--rootdir={self._config.rootpath}", f"--junitxml={folder / 'junit.xml'}"]
        guest = Guest(folder, float(os.environ.get(LIMIT, "900")), serial_pair=True, environment=self._environment(reports))
        with output.open("w", encoding="utf-8") as log:
            try:
                guest.run([sys.executable, "-m", "pytest", *options, *ids], lambda line: print(line, file=log, flush=True))
            except GuestError as error:
                self._died = str(error)
        self._died = self._died or f"see {output.relative_to(self._config.rootpath)}"
        return self._read(reports)

    def _environment(self, reports: pathlib.Path) -> dict[str, str]:
        kept = {name: value for name, value in os.environ.items() if name == "CI" or name.startswith("AXISGATE_")}
        return {**kept, "AXISGATE_RUNTIME": "/run/axisgate", REPORTS: str(reports), "PYTHONUNBUFFERED": "1"}

    def _read(self, path: pathlib.Path) -> dict[str, list[pytest.TestReport]]:
        results: dict[str, list[pytest.TestReport]] = {}
        for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
            with contextlib.suppress(json.JSONDecodeError):  # the half line of a guest that died
                report = self._config.hook.pytest_report_from_serializable(config=self._config, data=json.loads(line))
                results.setdefault(report.nodeid, []).append(report)
        return results

    def _told(self, item: pytest.Item) -> Iterator[pytest.TestReport]:
        reports = (self._results or {}).get(item.nodeid, [])
        yield from reports
        if not any(report.when == "teardown" for report in reports):
            yield self._not_reported(item)

    def _not_reported(self, item: pytest.Item) -> pytest.TestReport:
        text = f"the guest did not report the end of this test; {self._died}"
        return pytest.TestReport(item.nodeid, item.location, dict.fromkeys(item.keywords, 1), "failed", text, "call")


def forget_the_dead(parent: pathlib.Path) -> None:
    """Removes what earlier sessions left; the last one's logs stay until the next run."""
    for old in parent.glob("lane-*"):
        if not pathlib.Path("/proc", old.name.removeprefix("lane-")).exists():
            shutil.rmtree(old, ignore_errors=True)
