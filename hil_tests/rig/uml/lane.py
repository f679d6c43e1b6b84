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
import subprocess
import sys
from collections.abc import Iterator

import pytest

from hil_tests import lanes

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
    """On the host: boots the guest with all selected vcan tests before the first test and tells their results where they stand.

    Meanwhile the pure tests run: they need one processor and no quiet, the guest is a program of the highest niceness.  The rig
    tests, which measure times, come when the guest has ended.
    """

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._folder = config.rootpath / "build" / "uml" / f"lane-{os.getpid()}"  # several sessions may run at once
        self._process: subprocess.Popen[bytes] | None = None
        self._results: dict[str, list[pytest.TestReport]] | None = None
        self._died = ""

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items.sort(key=turn)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        ids = [item.nodeid for item in session.items if item.get_closest_marker("vcan")]
        if ids and lanes.missing("vcan") is None and not session.config.option.collectonly:
            self._process = self._boot(ids)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        if item.get_closest_marker("vcan") is None or self._process is None:
            return None
        if self._results is None:
            signal.setitimer(signal.ITIMER_REAL, 0)  # pytest-timeout's clock is for one test; the guest runs them all under its own limit
            self._results = self._wait(self._process)
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        for report in self._told(item):
            item.ihook.pytest_runtest_logreport(report=report)
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        item.session._setupstate.teardown_exact(nextitem)  # this item's packages were never set up here
        return True

    def pytest_sessionfinish(self) -> None:
        """An interrupted session takes its guest along."""
        if self._process is not None and self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
            self._process.wait()

    def _boot(self, ids: list[str]) -> "subprocess.Popen[bytes]":
        forget_the_dead(self._folder.parent)
        self._folder.mkdir(parents=True, exist_ok=True)
        root = self._config.rootpath
        options = ["-p", "no:cacheprovider", "-q", "--color=no", f"--rootdir={root}", f"--junitxml={self._folder / 'junit.xml'}"]
        limit = os.environ.get(LIMIT, "900")
        boot = [sys.executable, "-m", "hil_tests.rig.uml.guest", "--folder", str(self._folder), "--limit", limit, "--serial-pair"]
        told = [f"{name}={value}" for name, value in self._environment(self._folder / "reports.jsonl").items()]
        with self._output.open("wb") as log:
            command = [*boot, "env", *told, sys.executable, "-m", "pytest", *options, *ids]
            return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT)

    def _wait(self, process: "subprocess.Popen[bytes]") -> dict[str, list[pytest.TestReport]]:
        process.wait()
        last = self._output.read_text(encoding="utf-8", errors="replace").splitlines()[-25:]
        self._died = "\n".join([f"see {self._output}; its last lines:", *last])
        return self._read(self._folder / "reports.jsonl")

    @property
    def _output(self) -> pathlib.Path:
        return self._folder / "pytest.log"

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


def turn(item: pytest.Item) -> int:
    """Pure tests, those of the guest, then all that want a quiet machine; each kind in the order collected."""
    lane = lanes.lane_of(item.nodeid, item.keywords)
    return {"pure": 0, "vcan": 1}.get(lane, 2)


def forget_the_dead(parent: pathlib.Path) -> None:
    """Removes what earlier sessions left; the last one's logs stay until the next run."""
    for old in parent.glob("lane-*"):
        if not pathlib.Path("/proc", old.name.removeprefix("lane-")).exists():
            shutil.rmtree(old, ignore_errors=True)
