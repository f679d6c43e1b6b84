"""A whole simulated run with belts: a PLC orders programs, a portal works on belts of all three types, their encoders on the drive bus.

Set values and the belt's counter are read from one snapshot of the cycle each; the bus log is the witness of set values and counts.
rho 3 Releases part 1, TO04 sections 14-16; AX-390, AX-543..545.
"""

import os
import signal
import time
from collections.abc import Iterator

import numpy as np
import pytest

from gateway.pure.reasons import Reason
from gateway.pure.records import Motion
from hil_tests.lab.belt_run import FIRST_ID, INCREMENT, SPEED, BeltRun, belt_run
from hil_tests.lab.buslog import Logged
from hil_tests.lab.plc2 import ABORTED, DONE, REFUSED, STOP
from hil_tests.lab.program_run import PROGRAM
from motion.sync.cam import cam

HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\n"
PROGRAMS = {
    1: HEAD + "ptp joints 100 100 50 0\n",
    2: HEAD + "synchron B1 at=60mm\nlinear pose 150 150 50 0 0 0 belt=60mm\nlinear pose 150 150 90 0 0 0 belt=60mm path=60\nsynchron_end\n"
    "linear pose 100 100 50 0 0 0\n",
    3: HEAD + "synchron B2 at=60mm\nlinear pose 200 150 50 0 0 0 belt=160mm pathaccel=3000\nsynchron_end\nptp joints 100 100 50 0\n",
    4: HEAD + "synchron B3 at=60mm\nlinear pose 200 150 50 0 0 0 belt=160mm camin=30mm camout=50mm\n",
    5: HEAD + "synchron B2 at=4000mm\nlinear pose 200 150 50 0 0 0 belt=4100mm\n",
    6: HEAD + "set path=20\nsynchron B1\n" + "linear pose 100 110 50 0 0 0\nlinear pose 100 100 50 0 0 0\n" * 20,
    11: HEAD + "ptp joints 110 100 50 0\nsynchron B2 at=60mm\nptp joints 200 100 50 0 belt=160mm\n",
    12: HEAD + "synchron B3 at=60mm\nlinear pose 200 100 50 0 0 0 belt=160mm\nlinear pose 250 100 50 0 0 0 belt=160mm\n",
    13: HEAD + "synchron B3 at=60mm\ncircular via pose 150 150 50 0 0 0 to pose 200 100 50 0 0 0 belt=160mm\n",
    14: HEAD + "synchron nobody\nlinear pose 200 100 50 0 0 0\n",
    15: HEAD + "synchron B2 at=60mm\nlinear pose 200 100 50 0 0 0 belt=160mm\nlinear pose 250 100 50 0 0 0 belt=100mm\n",
    16: HEAD + "synchron B2 at=60mm\nlinear pose 2000 100 50 0 0 0 belt=160mm\n",
}
SAYS = {
    11: "line 7: block 2: PTP not allowed for belt synchronous or sensor movement, belt B2 (rho 3 23)",
    12: "line 7: block 2: kinematic 1: beltdistance is zero, belt B3 (rho 3 89)",
    13: "line 6: block 1: kinematic 1: Belt-sync. n.possible, belt B3 (rho 3 20)",
    14: "line 6: block 1: belt nobody: Inadmiss. Belt-No; this cell has B1, B2, B3 (rho 3 93)",
    15: "line 7: block 2: kinematic 1: wrong belt direction, belt B2 (rho 3 928)",
    16: "line 6: block 1, axis X: point not reachable",
}


@pytest.fixture(scope="module")
def portal(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BeltRun]:
    with belt_run(tmp_path_factory.mktemp("cell"), PROGRAMS) as run:
        yield run


@pytest.fixture
def home(portal: BeltRun) -> BeltRun:
    """Drives on, the axes where programs begin, every belt at rest."""
    for kind in (1, 2, 3):
        portal.silence(kind, silent=False)
        portal.drive(kind, 0.0)
    portal.programs.ready()
    assert portal.programs.command(PROGRAM, 1).state == DONE, portal.programs.run.words()
    return portal


def started(home: BeltRun, number: int, kind: int, speed: float = SPEED) -> None:
    """The belt's counter from 0, the belt at its speed, the program ordered."""
    home.zero(kind)
    home.drive(kind, speed)
    home.programs.plc.send(PROGRAM, number)


@pytest.mark.requirement("RHO-MOT-24", by="gateway.pure.corebelts:CoreBelts._carry")
def test_a_robot_works_on_a_belt_of_type_1_and_goes_on_beside_it(home: BeltRun) -> None:
    started(home, 2, 1)
    states = home.snapshots()
    assert home.programs.plc.wait(lambda s: s.state in (DONE, ABORTED), 5).state == DONE, home.programs.run.words()
    on = [s for s in states if abs(s.axes[1].set - 0.15) < 1e-6 and 0.052 < s.axes[2].set < 0.088 and s.belt_speed > 0.1]
    assert len(on) > 20
    period = home.programs.run.p5_ms * 1e-3
    off = [s.axes[0].set - 0.150 - (s.belt + 2 * period * SPEED - 0.060) for s in on]
    assert max(map(abs, off)) < 3e-4, "a set value acts two cycles after the count it was made of, and is where the belt is then"
    assert states[-1].axes[0].set == pytest.approx(0.1, abs=1e-9) and states[-1].axes[1].set == pytest.approx(0.1, abs=1e-9)
    ids = {f.identifier for f in home.programs.run.bus() if isinstance(f, Logged)}
    assert {FIRST_ID + 1, FIRST_ID + 2, FIRST_ID + 3} <= ids, "the encoders' telegrams are on the bus"


def test_a_robot_is_at_its_point_when_a_belt_of_type_2_is(home: BeltRun) -> None:
    started(home, 3, 2)
    states = home.snapshots()
    assert home.programs.plc.wait(lambda s: s.state in (DONE, ABORTED), 5).state == DONE, home.programs.run.words()
    way = [(s.belt, s.axes[0].set) for s in states if s.belt_speed > 0.1]
    assert all(x == pytest.approx(0.1, abs=1e-9) for belt, x in way if belt < 0.059)
    there = [belt for belt, x in way if x > 0.2 - 1e-6]
    tolerance = 5 * home.programs.run.p5_ms * 1e-3 * SPEED
    assert 0.160 - tolerance < there[0] < 0.160 + tolerance
    middle = [x for belt, x in way if 0.105 < belt < 0.115]
    assert middle and all(0.13 < x < 0.17 for x in middle)


def test_the_cam_of_type_3_is_exact_at_every_cycle(home: BeltRun) -> None:
    curve = cam(0.1, 0.03, 0.05)
    started(home, 4, 3)
    states = home.snapshots()
    assert home.programs.plc.wait(lambda s: s.state in (DONE, ABORTED), 5).state == DONE, home.programs.run.words()
    inside = [s for s in states if 0.061 < s.belt < 0.159 and s.axes[0].set < 0.2 - 1e-9]
    assert len(inside) > 20
    for state in inside:
        share, _ = curve.at(state.belt - 0.060)
        assert state.axes[0].set == pytest.approx(0.1 + 0.1 * share, abs=1e-9)
        assert state.axes[1].set == pytest.approx(0.1 + 0.05 * share, abs=1e-9), "all coordinates follow the same curve"


@pytest.mark.parametrize("number", SAYS)
def test_rules_of_belts_are_told_with_line_block_and_number_before_anything_moves(home: BeltRun, number: int) -> None:
    run = home.programs
    before = run.sets()
    status = run.command(PROGRAM, number)
    assert (status.state, status.reason) == (REFUSED, Reason.PROGRAM_FAULT)
    assert SAYS[number] in [entry["text"] for entry in run.run.journal("command")][-1]
    assert run.sets() == before


def test_a_belt_that_turns_round_opens_ready_and_says_928(home: BeltRun) -> None:
    run = home.programs
    started(home, 5, 2)
    run.watch("the robot waits for its belt", lambda s: s.job > 0 and s.belt > 0.02)
    assert run.output(64)
    home.drive(2, -SPEED)
    run.watch("the drives are off", lambda s: s.motion is Motion.IDLE and s.failed_reason == Reason.BELT_FAULT)
    status = run.plc.wait(lambda s: s.state in (DONE, ABORTED), 5)
    assert (status.state, status.reason) == (ABORTED, Reason.BELT_FAULT)
    assert not run.output(64) and run.output(67), "READY is open"
    said = [entry["text"] for entry in run.run.journal("command")][-1]
    assert "block 1, kinematic 1: wrong belt direction (rho 3 928)" in said


def on_belt(home: BeltRun) -> None:
    """In the middle of a slow way on a belt that runs."""
    started(home, 6, 1)
    home.programs.watch("on the belt", lambda s: s.parts > 0 and s.axes[1].set > 0.104 and abs(s.axes[0].speed) > 0.1)


def left(home: BeltRun, reason: Reason) -> None:
    """The robot comes to rest though the belt runs on; nothing goes on by itself."""
    run = home.programs
    rows = run.watch("at rest", lambda s: s.motion is Motion.IDLE and s.job == 0)
    status = run.plc.wait(lambda s: s.state in (DONE, ABORTED), 5)
    assert (status.state, status.reason) == (ABORTED, reason)
    assert run.still() and run.state().belt_speed > 0.1
    assert np.abs(np.diff(rows[:, 0])).max() < 0.05, "no step"


def test_a_stop_leaves_the_belt_and_there_is_nothing_to_resume(home: BeltRun) -> None:
    on_belt(home)
    assert home.programs.command(STOP).state == DONE
    left(home, Reason.STOPPED_BY_DOOR)


def test_a_planner_killed_on_a_belt_leaves_the_robot_at_rest_beside_it(home: BeltRun) -> None:
    on_belt(home)
    pid = home.programs.run.pid("planner")
    os.kill(pid, signal.SIGKILL)
    left(home, Reason.PLANNER_LOST)
    home.programs.run.back("planner", pid)
    home.programs.run.forgive("planner")


def test_an_encoder_that_says_nothing_ends_the_part(home: BeltRun) -> None:
    on_belt(home)
    home.silence(1, silent=True)
    run = home.programs
    run.watch("at rest", lambda s: s.motion is Motion.IDLE and s.job == 0)
    status = run.plc.wait(lambda s: s.state in (DONE, ABORTED), 5)
    assert (status.state, status.reason) == (ABORTED, Reason.BELT_FAULT) and run.still()
    assert "no telegram from the belt's encoder" in [entry["text"] for entry in run.run.journal("command")][-1]


def test_input_399_runs_every_belt_at_its_p508(home: BeltRun) -> None:
    run = home.programs
    run.coil(399, True)
    try:
        run.watch("the belt seems to run", lambda s: abs(s.belt_speed - 0.05) < 1e-9)
    finally:
        run.coil(399, False)
    run.watch("it stands again", lambda s: s.belt_speed == 0.0)
    before = run.state().belt
    time.sleep(0.1)
    assert run.state().belt == pytest.approx(before, abs=INCREMENT)
