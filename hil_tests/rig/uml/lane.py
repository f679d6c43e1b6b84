"""Lane vcan: the tests marked `vcan` are collected here, run in one guest, and reported here one by one.

Each guest test counts as a test of this session: the guest's pytest writes its reports to a host file, they are replayed
under the same test ids.  A guest that dies fails every test it did not report.
"""

import os
import pathlib
import shutil
import signal
import subprocess
import sys

import pytest

from hil_tests import lanes, reports

REPORTS = "AXISGATE_GUEST_REPORTS"  # set inside the guest: file for the reports
LIMIT = "AXISGATE_GUEST_LIMIT"  # seconds for the whole lane


def inside() -> bool:
    return REPORTS in os.environ


class GuestLane:
    """On the host: boots the guest with all selected vcan tests at the first of them and tells the results.

    Nothing runs beside it: the guest is one program of the host, and a cycle whose processor is taken away is spoilt.  So the order
    of a run is pure, vcan, rig.
    """

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._folder = config.rootpath / "build" / "uml" / f"lane-{os.getpid()}"  # several sessions may run at once
        self._process: subprocess.Popen[bytes] | None = None
        self._results: reports.Reports | None = None
        self._died = ""

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items.sort(key=turn)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        if item.get_closest_marker("vcan") is None or lanes.missing("vcan") is not None:
            return None
        if self._results is None:
            reports.no_time_out()
            self._results = self._run([other.nodeid for other in item.session.items if other.get_closest_marker("vcan")])
        reports.replay(item, nextitem, self._results, f"the guest did not report the end of this test; {self._died}")
        return True

    def pytest_sessionfinish(self) -> None:
        """An interrupted session takes its guest along."""
        if self._process is not None and self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
            self._process.wait()

    def _run(self, ids: list[str]) -> reports.Reports:
        forget_the_dead(self._folder.parent)
        self._folder.mkdir(parents=True, exist_ok=True)
        root = self._config.rootpath
        options = ["-p", "no:cacheprovider", "-q", "--color=no", f"--rootdir={root}", f"--junitxml={self._folder / 'junit.xml'}"]
        limit = os.environ.get(LIMIT, "900")
        boot = [sys.executable, "-m", "hil_tests.rig.uml.guest", "--folder", str(self._folder), "--limit", limit, "--serial-pair"]
        told = [f"{name}={value}" for name, value in self._environment(self._folder / "reports.jsonl").items()]
        with self._output.open("wb") as log:
            command = [*boot, "env", *told, sys.executable, "-m", "pytest", *options, *ids]
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT)
            self._process.wait()
        last = self._output.read_text(encoding="utf-8", errors="replace").splitlines()[-25:]
        self._died = "\n".join([f"see {self._output}; its last lines:", *last])
        return reports.read(self._config, self._folder / "reports.jsonl")

    @property
    def _output(self) -> pathlib.Path:
        return self._folder / "pytest.log"

    def _environment(self, reports: pathlib.Path) -> dict[str, str]:
        kept = {name: value for name, value in os.environ.items() if name == "CI" or name.startswith("AXISGATE_")}
        return {**kept, "AXISGATE_RUNTIME": "/run/axisgate", REPORTS: str(reports), "PYTHONUNBUFFERED": "1"}


def turn(item: pytest.Item) -> int:
    """Pure tests, those of the guest, then all that want a quiet machine; each kind in the order collected."""
    lane = lanes.lane_of(item.nodeid, item.keywords)
    return {"pure": 0, "vcan": 1}.get(lane, 2)


def forget_the_dead(parent: pathlib.Path) -> None:
    """Removes what earlier sessions left; the last one's logs stay until the next run."""
    for old in parent.glob("lane-*"):
        if not pathlib.Path("/proc", old.name.removeprefix("lane-")).exists():
            shutil.rmtree(old, ignore_errors=True)
