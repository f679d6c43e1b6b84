"""Issue 2, users (a stop over the line is not a stop): the command source in control falls silent in a move; what comes back moves
nothing."""

import pathlib
import time

import pytest

from hil_tests.lab.judges import bus_log as buslog
from hil_tests.lab.judges.judge import Judge, Move, SetPath
from hil_tests.lab.partners.plc2 import ENABLE, RESUME
from hil_tests.lab.running.cell_running import ALL, HOME, TARGET, CellRun, Disturbed, patience_s, running_cell
from hil_tests.rig.death.test_services_die import DEMO

pytestmark = pytest.mark.timeout(patience_s(15.0))
RESYNCHRONISED = 20
SPEED = 0.03  # 2.5 s
SILENCE_S = 0.5  # max_silence_ms of plc2 in the demo's cell


@pytest.fixture
def wired(tmp_path: pathlib.Path) -> str:
    """The demo's cell, but its enabling inputs do not hang on PLC 2: they are assumed, so that only the link's own rule acts."""
    text = DEMO.read_text()
    assert 'owner = { "3" = "plc2" }' in text
    assume = '["EMSTOP_OK_RCI", "CTRL_ALLOW_RCI", "FEED_ALLOW_RCI", "FEED_HOLD_N_RCI", "TRAVEL_ALLOW_RCI"]'
    path = tmp_path / "assumed.toml"
    path.write_text(text.replace('owner = { "3" = "plc2" }', f'owner = {{ "3" = "plc2" }}\nassume = {assume}'))
    return str(path)


def test_a_silent_owner_stops_the_move_on_its_path_and_resume_ends_it(wired: str) -> None:
    with running_cell(wired) as run:
        run.ready()
        run.repeat(1, lambda count: silence(run), lambda: recover(run))


def silence(run: CellRun) -> None:
    start = run.under_way(SPEED)
    silent = time.monotonic_ns()
    run.plc.polls.clear()
    time.sleep(SILENCE_S + 0.8)
    back = time.monotonic_ns()
    run.plc.polls.set()
    status = run.plc.wait(lambda s: s.reason == RESYNCHRONISED, 2)  # the old command stands and is only adopted
    if status.enabled != ALL:
        raise Disturbed("the drives did not stay on")
    time.sleep(0.5)
    now = time.monotonic_ns()
    judge = Judge(run.demo, run.record())
    rest = judge.rest_after(silent, now)
    assert rest is not None and SILENCE_S - 0.1 <= rest <= SILENCE_S + 0.5, rest
    assert judge.missed_by(Move(start, now, HOME, TARGET)) > 1000.0, "stopped on its path, long before its target"
    assert judge.moved(back - 100_000_000, now) <= 2.0
    run.command(RESUME)
    run.arrived(TARGET)
    path = SetPath(run.demo, [e for e in run.bus() if isinstance(e, buslog.Logged) and e.stamp_ns > start])
    assert path.off_line(Move(start, time.monotonic_ns(), HOME, TARGET)) <= 1.0, "increments beside the path"
    run.home_again()


def test_a_silent_source_with_the_enabling_inputs_also_takes_the_drives_off() -> None:
    """The demo's cell as it is: the enabling inputs hang on PLC 2.  Lost, they stop on the path and then switch off (AX-143)."""
    with running_cell() as run:
        run.ready()
        run.repeat(1, lambda count: silence_of_inputs(run), lambda: recover(run))


def recover(run: CellRun) -> None:
    run.ready()
    run.home_again()


def silence_of_inputs(run: CellRun) -> None:
    run.under_way(SPEED)
    silent = time.monotonic_ns()
    run.plc.polls.clear()
    time.sleep(SILENCE_S + 0.8)
    run.plc.polls.set()
    status = run.plc.wait(lambda s: s.reason == RESYNCHRONISED, 2)
    assert (status.enabled, status.fault, status.referenced) == (0, 0, ALL), status
    time.sleep(0.5)
    now = time.monotonic_ns()
    judge = Judge(run.demo, run.record())
    assert max(abs(axis.speed_rad_s) for axis in judge.at(silent).axes) > 1.0, "it was not in the middle of a move"
    assert judge.moved(silent + round((SILENCE_S + 0.6) * 1e9), now) <= 2.0
    run.command(ENABLE, ALL)
    run.home_again()
