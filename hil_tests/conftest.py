"""What every test run of axisgate has: lanes, the purity guard, requirement marks, the guest for vcan."""

import os
import pathlib
import shutil
import tempfile

import pytest

from hil_tests.lanes import Lanes
from hil_tests.matrix.marks import Marks
from hil_tests.purity import Purity
from hil_tests.rig.uml.lane import GuestLane, Reporter, inside

RUNTIME = "AXISGATE_RUNTIME"
MINE = pytest.StashKey[pathlib.Path]()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--matrix", metavar="FILE", help="write ids, tests and verdicts of the requirement marks here")


def pytest_configure(config: pytest.Config) -> None:
    if RUNTIME not in os.environ:  # two test runs on one machine must not meet in one folder of sockets
        config.stash[MINE] = pathlib.Path(tempfile.mkdtemp(prefix="axg-"))  # short: a socket's path has 107 bytes
        os.environ[RUNTIME] = str(config.stash[MINE])
    plugins = config.pluginmanager
    plugins.register(Lanes(), "axisgate-lanes")
    plugins.register(Purity(), "axisgate-purity")
    plugins.register(Marks(config.getoption("--matrix")), "axisgate-marks")
    plugins.register(Reporter(config) if inside() else GuestLane(config), "axisgate-guest")


def pytest_unconfigure(config: pytest.Config) -> None:
    if MINE in config.stash:
        del os.environ[RUNTIME]
        shutil.rmtree(config.stash[MINE], ignore_errors=True)
