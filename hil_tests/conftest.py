"""What every test run of axisgate has: lanes, the purity guard, requirement marks, the guest for vcan."""

import pytest

from hil_tests.lanes import Lanes
from hil_tests.matrix.marks import Marks
from hil_tests.purity import Purity
from hil_tests.rig.uml.lane import GuestLane, Reporter, inside


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--matrix", metavar="FILE", help="write ids, tests and verdicts of the requirement marks here")


def pytest_configure(config: pytest.Config) -> None:
    plugins = config.pluginmanager
    plugins.register(Lanes(), "axisgate-lanes")
    plugins.register(Purity(), "axisgate-purity")
    plugins.register(Marks(config.getoption("--matrix")), "axisgate-marks")
    plugins.register(Reporter(config) if inside() else GuestLane(config), "axisgate-guest")
