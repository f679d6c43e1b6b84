"""The pure tests of a whole run, and the rig's that only start commands, by two processes: ours takes files from the front, its mate
from the back, until they meet.  A selection is shared with `--pair` (make check).

They need no quiet and no time of their own, so they may share the machine, also with a guest that has its own clock.
"""

import contextlib
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

from hil_tests import reports
from hil_tests.rig.uml.lane import of_the_guest
from hil_tests.test_folders import unhurried

MATE = "AXISGATE_TEST_MATE"  # set in the mate: folder of claims and reports
REPORTS = "reports.jsonl"
RUNTIME = "AXISGATE_RUNTIME"


class Claims:
    """Each file of tests belongs to whoever asked first, on the host and in guests."""

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


class Mate:
    """In the mate, and in each of two guests: what the other has claimed is left alone."""

    def __init__(self, folder: pathlib.Path) -> None:
        self._claims = Claims(folder)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> bool | None:
        return None if self._claims.mine(item) else True


class Pair:
    """Here: starts the mate, tells its results where they stand.  In a whole run, and in folders or files selected with `--pair`."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._folder = config.rootpath / "build" / "pair" / str(os.getpid())
        self._claims = Claims(self._folder)
        self._mate: subprocess.Popen[bytes] | None = None
        self._results: reports.Reports | None = None

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        files = list(dict.fromkeys(str(item.path) for item in session.items if ours(item)))
        if len(files) > 1 and shared(self._config) and (os.cpu_count() or 1) > 1:
            self._start(files)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
        if self._mate is None or not ours(item) or self._claims.mine(item):
            return None
        if self._results is None:
            reports.no_time_out()
            self._mate.wait()
            self._results = reports.read(self._config, self._folder / REPORTS)
        reports.replay(item, nextitem, self._results, f"the second process did not report the end of this test; see {self._log}")
        return True

    def pytest_sessionfinish(self) -> None:
        if self._mate is not None and self._mate.poll() is None:
            self._mate.terminate()
            self._mate.wait()

    def _start(self, files: list[str]) -> None:
        forget_the_dead(self._folder.parent)
        self._folder.mkdir(parents=True)
        listed = self._folder / "files.txt"
        listed.write_text("\n".join(reversed(files)))
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "--color=no", f"@{listed}"]
        with self._log.open("wb") as log:
            environment = surroundings(**{MATE: str(self._folder)})
            self._mate = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT, env=environment)

    @property
    def _log(self) -> pathlib.Path:
        return self._folder / "pytest.log"


def whole_run(config: pytest.Config) -> bool:
    """Every test, not a selection."""
    return config.args_source is pytest.Config.ArgsSource.TESTPATHS and whole_files(config)


def shared(config: pytest.Config) -> bool:
    """Whether a second process takes half of the files."""
    return whole_run(config) or (bool(config.getoption("--pair")) and whole_files(config))


def whole_files(config: pytest.Config) -> bool:
    """Whether no file is run in part by -k or -m: the mate would run all of it."""
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
