"""Run the pure tests, and the tests of the rig that only start commands, in two processes: one takes files from the front, the other
from the back, until they meet.  A complete run does so, and a selection with `--pair` (make check).

These tests depend on no clock, so they may share the machine, also with a guest that has its own clock.  In a complete run they have
a lower priority than the cells that run at the same time (`to_background`): two workers do the work, and this process, the parent of
those cells' tests, waits.  In a selection this process is one of the two.
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
from hil_tests.background import to_background
from hil_tests.rig.uml.lane import of_the_guest
from hil_tests.test_folders import unhurried

WORKER = "AXISGATE_TEST_WORKER"  # set in a worker: its folder, next to that of the claims
CLAIMS, REPORTS = "claims", "reports.jsonl"
RUNTIME = "AXISGATE_RUNTIME"
POLL_S = 0.1


class Claims:
    """Assign each test file to the process that claims it first, on the host and in guests."""

    def __init__(self, folder: pathlib.Path) -> None:
        self._folder = folder
        self._mine: dict[str, bool] = {}

    def mine(self, item: pytest.Item) -> bool:
        name = item.nodeid.partition("::")[0].replace("/", ".")
        if name not in self._mine:
            try:
                (self._folder / name).mkdir()  # the only atomic step of a guest's file system
                self._mine[name] = True
            except FileExistsError:
                self._mine[name] = False
        return self._mine[name]


class Worker:
    """In the worker, and in each of two guests: skip the files that the other process has claimed."""

    def __init__(self, folder: pathlib.Path) -> None:
        self._claims = Claims(folder)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        if self._claims.mine(item):
            return None
        item.session._setupstate.teardown_exact(nextitem)  # the previous test left the folder of this one set up
        return True


class Pair:
    """In the main process: start the workers and report their results in order.  For complete runs and `--pair`."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._folder = config.rootpath / "build" / "pair" / str(os.getpid())
        self._claims = Claims(self._folder / CLAIMS)
        self._workers: list[subprocess.Popen[bytes]] = []
        self._reports: list[reports.Incoming] = []
        self._shares = False  # this process is one of the two

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        files = list(dict.fromkeys(str(item.path) for item in session.items if shareable(item)))
        if len(files) > 1 and shared(self._config) and (os.cpu_count() or 1) > 1:
            forget_the_dead(self._folder.parent)
            (self._folder / CLAIMS).mkdir(parents=True)
            self._shares = not whole_run(self._config)
            turns = {"back": files[::-1]} if self._shares else {"front": files, "back": files[::-1]}
            for name, turn in turns.items():
                self._start(self._folder / name, turn)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        if not self._workers or not shareable(item) or (self._shares and self._claims.mine(item)):
            return None
        reports.no_time_out()
        why = f"no second process reported the end of this test; see pytest.log in the folders of {self._folder}"
        reports.replay(item, nextitem, self._results(item.nodeid), why)
        return True

    def pytest_sessionfinish(self) -> None:
        for worker in self._workers:
            if worker.poll() is None:
                worker.terminate() if self._shares else os.killpg(worker.pid, signal.SIGTERM)
                worker.wait()

    def _results(self, name: str) -> reports.Reports:
        """Wait until this test has ended, or the workers have; return the reports of this test."""
        while True:
            alive = any(worker.poll() is None for worker in self._workers)  # asked before their last reports are read
            results = {name: next((found for each in self._reports if (found := each.take().get(name))), [])}
            if not alive or reports.ended([name], results):
                return results
            time.sleep(POLL_S)

    def _start(self, folder: pathlib.Path, files: Sequence[str]) -> None:
        folder.mkdir()
        listed = folder / "files.txt"
        listed.write_text("\n".join(files))
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "--color=no", f"@{listed}"]
        with (folder / "pytest.log").open("wb") as log:
            environment = environment_of_tests(**{WORKER: str(folder)})
            alone = not self._shares  # in a session of its own, at a lower priority
            worker = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, env=environment, start_new_session=alone
            )
        if alone:
            to_background(worker.pid)
        self._workers.append(worker)
        self._reports.append(reports.Incoming(self._config, folder / REPORTS))


def whole_run(config: pytest.Config) -> bool:
    """Return whether all tests run, not a selection."""
    return config.args_source is pytest.Config.ArgsSource.TESTPATHS and whole_files(config)


def shared(config: pytest.Config) -> bool:
    """Return whether a second process takes half of the files."""
    return whole_run(config) or (bool(config.getoption("--pair")) and whole_files(config))


def whole_files(config: pytest.Config) -> bool:
    """Return whether -k and -m select no part of a file: the worker would run all of it."""
    options = config.option
    return not (options.keyword or options.markexpr or options.collectonly)


def shareable(item: pytest.Item) -> bool:
    """Return whether this test may run in either process."""
    return unhurried(item) and not of_the_guest(item)


def environment_of_tests(**added: str) -> dict[str, str]:
    """Return the environment of a test process.  It makes its own folder of sockets, so that two processes never share a run."""
    return {**{name: value for name, value in os.environ.items() if name != RUNTIME}, **added}


def forget_the_dead(parent: pathlib.Path) -> None:
    """Remove the folders of earlier sessions; the logs of the last one stay until the next run."""
    with contextlib.suppress(FileNotFoundError):
        for old in parent.iterdir():
            if not pathlib.Path("/proc", old.name).exists():
                shutil.rmtree(old, ignore_errors=True)
