"""The pure tests of a whole run, and the rig's that only start commands, by two processes: one takes files from the front, the other
from the back, until they meet.  A selection is shared with `--pair` (make check).

They need no quiet and no time of their own, so they may share the machine, also with a guest that has its own clock.  In a whole run
they stand behind the cells that are played beside them (`behind`): two workers do the work and this process waits, which is the parent
of those cells' tests.  In a selection this process is one of the two.
"""

import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Sequence

import pytest

from hil_tests import reports
from hil_tests.background import behind
from hil_tests.rig.uml.lane import of_the_guest
from hil_tests.test_folders import unhurried

WORKER = "AXISGATE_TEST_WORKER"  # set in a worker: its folder, beside that of the claims
CLAIMS, REPORTS = "claims", "reports.jsonl"
RUNTIME = "AXISGATE_RUNTIME"
POLL_S = 0.1


class Claims:
    """Each file of tests belongs to the process that claims it first, on the host and in guests."""

    def __init__(self, folder: pathlib.Path) -> None:
        self._folder = folder
        self._mine: dict[str, bool] = {}

    def mine(self, item: pytest.Item) -> bool:
        name = item.nodeid.partition("::")[0].replace("/", ".")
        if name not in self._mine:
            try:
                (self._folder / name).mkdir()  # a guest's file system makes nothing else in one step
                self._mine[name] = True
            except FileExistsError:
                self._mine[name] = False
        return self._mine[name]


class Worker:
    """In the worker, and in each of two guests: what the other has claimed is left alone."""

    def __init__(self, folder: pathlib.Path) -> None:
        self._claims = Claims(folder)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        if self._claims.mine(item):
            return None
        item.session._setupstate.teardown_exact(nextitem)  # the test before it left this one's folder set up
        return True


class Pair:
    """Here: starts the workers, reports their results in order.  In a whole run, and in folders or files selected with `--pair`."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._folder = config.rootpath / "build" / "pair" / str(os.getpid())
        self._claims = Claims(self._folder / CLAIMS)
        self._workers: list[subprocess.Popen[bytes]] = []
        self._told: list[reports.Coming] = []
        self._plays = False  # this process is one of the two

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        files = list(dict.fromkeys(str(item.path) for item in session.items if ours(item)))
        if len(files) > 1 and shared(self._config) and (os.cpu_count() or 1) > 1:
            forget_the_dead(self._folder.parent)
            (self._folder / CLAIMS).mkdir(parents=True)
            self._plays = not whole_run(self._config)
            turns = {"back": files[::-1]} if self._plays else {"front": files, "back": files[::-1]}
            for name, turn in turns.items():
                self._start(self._folder / name, turn)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        if not self._workers or not ours(item) or (self._plays and self._claims.mine(item)):
            return None
        reports.no_time_out()
        why = f"no second process reported the end of this test; see pytest.log in the folders of {self._folder}"
        reports.replay(item, nextitem, self._results(item.nodeid), why)
        return True

    def pytest_sessionfinish(self) -> None:
        for worker in self._workers:
            if worker.poll() is None:
                worker.terminate() if self._plays else os.killpg(worker.pid, signal.SIGTERM)
                worker.wait()

    def _results(self, name: str) -> reports.Reports:
        """Until this test has ended, or the workers have."""
        while True:
            alive = any(worker.poll() is None for worker in self._workers)  # before their last words are read
            told = {name: next((found for each in self._told if (found := each.take().get(name))), [])}
            if not alive or reports.ended([name], told):
                return told
            time.sleep(POLL_S)

    def _start(self, folder: pathlib.Path, files: Sequence[str]) -> None:
        folder.mkdir()
        listed = folder / "files.txt"
        listed.write_text("\n".join(files))
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "--color=no", f"@{listed}"]
        with (folder / "pytest.log").open("wb") as log:
            environment = surroundings(**{WORKER: str(folder)})
            alone = not self._plays  # a session of its own, which stands behind the others
            worker = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, env=environment, start_new_session=alone
            )
        if alone:
            behind(worker.pid)
        self._workers.append(worker)
        self._told.append(reports.Coming(self._config, folder / REPORTS))


def whole_run(config: pytest.Config) -> bool:
    """Every test, not a selection."""
    return config.args_source is pytest.Config.ArgsSource.TESTPATHS and whole_files(config)


def shared(config: pytest.Config) -> bool:
    """Whether a second process takes half of the files."""
    return whole_run(config) or (bool(config.getoption("--pair")) and whole_files(config))


def whole_files(config: pytest.Config) -> bool:
    """Whether no file is run in part by -k or -m: the worker would run all of it."""
    options = config.option
    return not (options.keyword or options.markexpr or options.collectonly)


def ours(item: pytest.Item) -> bool:
    return unhurried(item) and not of_the_guest(item)


def surroundings(**ours: str) -> dict[str, str]:
    """The environment of a test process of ours; it makes its own folder of sockets, so that no two play with one another's runs."""
    return {**{name: value for name, value in os.environ.items() if name != RUNTIME}, **ours}


def forget_the_dead(parent: pathlib.Path) -> None:
    """Removes what earlier sessions left; the last one's logs stay until the next run."""
    with contextlib.suppress(FileNotFoundError):
        for old in parent.iterdir():
            if not pathlib.Path("/proc", old.name).exists():
                shutil.rmtree(old, ignore_errors=True)
