"""Common parts of every test run: lanes, the purity guard, requirement marks, guests, processes for pure tests and the rig."""

import gc
import os
import pathlib
import shutil
import signal
import sys
import tempfile
from collections.abc import Generator

import hypothesis
import pytest

from gateway.cycle.native.servo import use_servo
from hil_tests.host import CLAIMS as RIGS_CLAIMS
from hil_tests.host import REPORTS as RIGS_REPORTS
from hil_tests.host import Host
from hil_tests.lab.virtual.bench import played
from hil_tests.lanes import Lanes
from hil_tests.matrix.marks import Marks
from hil_tests.numbers import one_thread
from hil_tests.pair import CLAIMS as WORKERS_CLAIMS
from hil_tests.pair import REPORTS as MATES_REPORTS
from hil_tests.pair import RUNTIME, WORKER, Pair, Worker
from hil_tests.purity import Purity
from hil_tests.reports import Reporter
from hil_tests.rig.uml.lane import CLAIMS, REPORTS, GuestLane

os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # hundreds of processes start in a run: each would compile axisgate anew
sys.dont_write_bytecode = False
if (
    signal.getsignal(signal.SIGINT) is signal.SIG_IGN
):  # a shell starts its background jobs with SIGINT ignored, which all processes of the tests would inherit
    signal.signal(signal.SIGINT, signal.default_int_handler)
one_thread()  # before any test module loads numpy
use_servo()  # emulated axes in virtual time are half of what the pure tests compute
hypothesis.settings.register_profile("untimed", deadline=None, suppress_health_check=(hypothesis.HealthCheck.too_slow,))
hypothesis.settings.load_profile("untimed")  # a shared host may take a processor away for longer than any deadline

MINE = pytest.StashKey[pathlib.Path]()
TIME_IS_UP = pathlib.Path(__file__).resolve().parent.parent / "build" / "time-is-up"  # made by .ci/run; guests see it, too (AX-1512)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--matrix", metavar="FILE", help="write ids, tests and verdicts of the requirement marks here")
    parser.addoption("--pair", action="store_true", help="a second process takes half of the files, as in a run of all tests")


def pytest_configure(config: pytest.Config) -> None:
    if RUNTIME not in os.environ:  # two test runs on one machine must not share a folder of sockets
        config.stash[MINE] = pathlib.Path(tempfile.mkdtemp(prefix="axg-"))  # short: a socket's path has 107 bytes
        os.environ[RUNTIME] = str(config.stash[MINE])
    plugins = config.pluginmanager
    plugins.register(Lanes(), "axisgate-lanes")
    plugins.register(Purity(), "axisgate-purity")
    plugins.register(Marks(config.getoption("--matrix")), "axisgate-marks")
    if REPORTS in os.environ:  # in the guest
        plugins.register(Reporter(config, pathlib.Path(os.environ[REPORTS]), dies=True), "axisgate-reporter")
        if CLAIMS in os.environ:  # together with another guest
            plugins.register(Worker(pathlib.Path(os.environ[CLAIMS])), "axisgate-worker")
    elif WORKER in os.environ:  # the second process of the pure tests
        mine = pathlib.Path(os.environ.pop(WORKER))  # not for a test run that one of these tests starts
        plugins.register(Reporter(config, mine / MATES_REPORTS), "axisgate-reporter")
        plugins.register(Worker(mine.parent / WORKERS_CLAIMS), "axisgate-worker")
    elif RIGS_REPORTS in os.environ:  # the process of the rig's tests
        reports = os.environ.pop(RIGS_REPORTS)
        plugins.register(Reporter(config, pathlib.Path(reports)), "axisgate-reporter")
        if RIGS_CLAIMS in os.environ:  # together with others
            plugins.register(Worker(pathlib.Path(os.environ.pop(RIGS_CLAIMS))), "axisgate-worker")
    else:
        plugins.register(GuestLane(config), "axisgate-guest")
        plugins.register(Pair(config), "axisgate-pair")
        plugins.register(Host(config), "axisgate-host")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Keep the objects of thousands of collected tests out of the garbage collector: they live until the end of the run."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup() -> None:
    if TIME_IS_UP.exists():
        pytest.skip("not played: the time of this run was up (AX-1512)")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Generator[None, object, object]:
    """Fail a test whose dialogue has output or reports after its last question."""
    try:
        result = yield
        for bench in played:
            bench.heard_out()
    finally:
        played.clear()
    return result


def pytest_unconfigure(config: pytest.Config) -> None:
    if MINE in config.stash:
        del os.environ[RUNTIME]
        shutil.rmtree(config.stash[MINE], ignore_errors=True)
