"""Collect the tests of the guests, run them in guests and report them one by one.

They are those marked `vcan` and, where the guest has a clock of its own, cells whose drives notice a late cycle, and lines that
wait for seconds (OWN_TIME in hil_tests/test_folders.py).
Each counts as a test of this session: the guest's pytest writes its reports to a host file, they are replayed under the same test
ids.  A guest that dies fails every test it did not report.
"""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
from collections.abc import Sequence

import pytest

from hil_tests import lanes, reports
from hil_tests.rig.uml import guest
from hil_tests.test_folders import ALONE, BESIDE, OWN_TIME, of_one, unhurried

REPORTS = "AXISGATE_GUEST_REPORTS"  # set inside the guest: file for the reports
LIMIT = "AXISGATE_GUEST_LIMIT"  # seconds for the whole lane
ON_HOST = "AXISGATE_TEST_ON_HOST"  # set by hand: only tests marked vcan go to the guest
CLAIMS = "AXISGATE_GUEST_CLAIMS"  # set inside the guest: folder where two guests share the modules (hil_tests/pair.py)
STARTING = pathlib.Path(__file__).parent / "starting"


def inside() -> bool:
    return REPORTS in os.environ


class Boot:
    """One guest with its tests; it runs in the background until its results are asked for."""

    def __init__(
        self, config: pytest.Config, folder: pathlib.Path, ids: Sequence[str], claims: pathlib.Path | None, *, starts: bool
    ) -> None:
        self._config, self._folder, self._claims, self._starts = config, folder, claims, starts
        self._results: reports.Reports | None = None
        self.died = ""
        folder.mkdir(parents=True, exist_ok=True)
        root = config.rootpath
        options = ["-p", "no:cacheprovider", "-q", "--color=no", f"--rootdir={root}", f"--junitxml={folder / 'junit.xml'}"]
        limit = os.environ.get(LIMIT, "3600")
        boot = [sys.executable, "-m", "hil_tests.rig.uml.guest", "--folder", str(folder), "--limit", limit, "--serial-pair"]
        variables = [f"{name}={value}" for name, value in self._environment().items()]
        listed = folder / "tests.txt"
        listed.write_text("\n".join(ids))
        command = [*boot, "env", *variables, sys.executable, "-m", "pytest", *options, f"@{listed}"]
        with self._output.open("wb") as log:
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT)

    def results(self) -> reports.Reports:
        """Wait for its end; return its reports."""
        if self._results is None:
            reports.no_time_out()
            self._process.wait()
            last = self._output.read_text(encoding="utf-8", errors="replace").splitlines()[-25:]
            self.died = "\n".join([f"see {self._output}; its last lines:", *last])
            self._results = reports.read(self._config, self._folder / "reports.jsonl")
        return self._results

    def end(self) -> None:
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
            self._process.wait()

    @property
    def _output(self) -> pathlib.Path:
        return self._folder / "pytest.log"

    def _environment(self) -> dict[str, str]:
        kept = {name: value for name, value in os.environ.items() if name == "CI" or name.startswith("AXISGATE_")}
        shared = {} if self._claims is None else {CLAIMS: str(self._claims)}
        ours = {"AXISGATE_RUNTIME": "/run/axisgate", REPORTS: str(self._folder / "reports.jsonl"), "PYTHONUNBUFFERED": "1"}
        starting = {"PYTHONPATH": str(STARTING)} if self._starts else {}
        return {**kept, **shared, **starting, **ours}


class Guests:
    """Two guests for two processors, which share these modules (their test ids) until they meet; one guest where it uses the host's clock.

    `starts`: delay the start of each Python program, as on the host (hil_tests/rig/uml/starting).
    """

    def __init__(self, config: pytest.Config, folder: pathlib.Path, modules: Sequence[Sequence[str]], *, starts: bool = False) -> None:
        claims = folder / "claims" if guest.own_time() and len(modules) > 1 else None
        turns = {"first": modules}
        if claims is not None:
            claims.mkdir(parents=True)
            turns["second"] = modules[::-1]
        self._boots = [
            Boot(config, folder / name, [each for ids in turn for each in ids], claims, starts=starts) for name, turn in turns.items()
        ]

    def results(self) -> reports.Reports:
        """Wait for their end; return all their reports."""
        return {name: of_test for boot in self._boots for name, of_test in boot.results().items()}

    @property
    def died(self) -> str:
        return "\n".join(boot.died for boot in self._boots)

    def end(self) -> None:
        for boot in self._boots:
            boot.end()


class GuestLane:
    """On the host: boot the guests and report their results.

    A guest on the host's clock needs the machine alone: the order of a run is pure, guest, rig.  A guest with a clock of its own runs
    at the same time as the pure tests: they cannot make it late.
    """

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._folder = folder_of(config)
        self._guests: Guests | None = None
        self._results: reports.Reports = {}

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items.sort(key=turn)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        if guest.own_time() and not self._config.option.collectonly and not session.testsfailed and any(map(of_the_guest, session.items)):
            self._guests = self._start(session)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        if not of_the_guest(item):
            return None
        if self._guests is None:
            self._guests = self._start(item.session)
        if not self._results:
            self._results = self._guests.results()
        reports.replay(item, nextitem, self._results, f"the guest did not report the end of this test; {self._guests.died}")
        return True

    def pytest_sessionfinish(self) -> None:
        """End the guests of an interrupted session."""
        if self._guests is not None:
            self._guests.end()

    def _start(self, session: pytest.Session) -> Guests:
        forget_the_dead(self._folder.parent)
        modules: dict[str, list[str]] = {}
        for item in session.items:
            if of_the_guest(item):
                modules.setdefault(str(item.path), []).append(item.nodeid)
        return Guests(self._config, self._folder, list(modules.values()))


def folder_of(config: pytest.Config) -> pathlib.Path:
    """Return the folder of this session: several sessions may run at the same time."""
    return config.rootpath / "build" / "uml" / f"lane-{os.getpid()}"


def of_the_guest(item: pytest.Item) -> bool:
    wanted = item.get_closest_marker("vcan") is not None or wants_own_time(item)
    return wanted and lanes.missing("vcan") is None


def wants_own_time(item: pytest.Item) -> bool:
    return of_one(item, OWN_TIME) and guest.own_time() and ON_HOST not in os.environ


def turn(item: pytest.Item) -> int:
    """Sort key of a run: tests that need no quiet machine, those of the guests, those that run next to both, those that need a quiet
    machine, those that need it alone; each in the order collected."""
    if of_the_guest(item):
        return 1
    return 0 if unhurried(item) else 2 if of_one(item, BESIDE) else 4 if of_one(item, ALONE) else 3


def forget_the_dead(parent: pathlib.Path) -> None:
    """Remove the folders of earlier sessions; the logs of the last one stay until the next run."""
    for old in parent.glob("lane-*"):
        if not pathlib.Path("/proc", old.name.removeprefix("lane-")).exists():
            shutil.rmtree(old, ignore_errors=True)
