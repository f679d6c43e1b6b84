"""An arm and a SCARA of one cell, each ordered by a command source of its own: what one does is no matter to the other (AX-920)."""

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.cells.arm_and_scara import CELL, SHIPPED
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.lanes_bench import Lanes

ARM, SCARA = 0b111111, 0b1111 << 6
LONG = "robot tx60-like\naxes deg deg deg deg deg deg\nstart 0 30 90 0 60 0\n" + 3 * (
    "ptp joints 90 30 90 0 60 0\nptp joints -60 30 90 0 60 0\n"
)
SHORT = "robot sr60-like\naxes deg deg mm deg\nstart 0 90 -200 0\n" + 2 * "ptp joints 90 90 -200 0\nptp joints 0 60 -200 0\n"
FAULTY = "robot sr60-like\naxes deg deg mm deg\nstart 0 90 -200 0\nptp joints 400 90 -200 0\n"
TEXTS = {1: LONG, 2: SHORT, 3: SHIPPED, 4: FAULTY}
KINEMATICS = {1: "arm", 2: "scara", 4: "scara"}


@pytest.fixture
def lanes() -> Lanes:
    """Command source 1 has the arm, 2 the SCARA."""
    made = Lanes(Cell402Bench(8, cell=CELL), TEXTS, KINEMATICS)
    made.ready(1, ARM)
    made.ready(2, SCARA)
    return made


def test_two_command_sources_move_two_kinematics_at_once(lanes: Lanes) -> None:
    first, second = lanes.order(1, 1), lanes.order(2, 2)
    lanes.bench.run(0.6)
    assert (first.state, second.state) == (CommandState.RUNNING, CommandState.RUNNING)
    before = lanes.sets()
    lanes.bench.run(0.1)
    moved = [abs(now - was) > 0.5 for now, was in zip(lanes.sets(), before, strict=True)]
    assert moved[0] and moved[6], "both move"
    lanes.bench.settle(second)
    assert second.state is CommandState.DONE and first.open, "each ends for itself"
    third = lanes.order(2, 2)
    lanes.bench.settle(third)
    lanes.bench.settle(first)
    assert (first.state, third.state) == (CommandState.DONE, CommandState.DONE)
    assert lanes.sets()[0] == pytest.approx(-60.0, abs=1e-3) and lanes.sets()[6] == pytest.approx(0.0, abs=1e-3)


def test_a_single_move_of_one_goes_beside_a_program_of_the_other(lanes: Lanes) -> None:
    program = lanes.order(1, 1)
    lanes.bench.run(0.3)
    move = lanes.give(2, Code.PTP_ABSOLUTE, 1 << 6, targets=[0.0] * 6 + [20.0])
    assert move.open
    lanes.bench.settle(move)
    assert move.state is CommandState.DONE and program.open


def test_a_lane_is_busy_for_its_own_orders_alone_and_its_owner_is_named(lanes: Lanes) -> None:
    lanes.order(1, 1)
    lanes.bench.run(0.3)
    again = lanes.order(1, 1)
    assert again.reason is Reason.BUSY and again.detail.endswith(": program 1 1 of command source 1 is under way"), again.detail
    assert again.detail.startswith(", ".join(axis.name for axis in lanes.cell.axis[:6])), "the axes that both would move"
    other = lanes.order(2, 1)
    assert (other.reason, other.detail) == (Reason.NOT_OWNER, "command source 1 has it")
    whole = lanes.give(3, Code.REQUEST_CONTROL)
    assert (whole.state, whole.reason) == (CommandState.REFUSED, Reason.NOT_OWNER)


def test_override_and_resume_act_on_the_lanes_of_their_command_source(lanes: Lanes) -> None:
    first, second = lanes.order(1, 1), lanes.order(2, 2)
    lanes.bench.run(0.4)
    lanes.done(1, Code.OVERRIDE, velocity=0.0)
    lanes.bench.run(0.4)
    held = lanes.sets()
    lanes.bench.run(0.1)
    assert lanes.sets()[:6] == held[:6] and lanes.sets()[6] != held[6], "the arm is held, the SCARA moves"
    assert (lanes.lane(0).override, lanes.lane(1).override) == (0.0, 1.0)
    lanes.done(1, Code.OVERRIDE)
    lanes.bench.run(0.2)
    lanes.done(2, Code.STOP)
    assert (lanes.lane(0).motion, lanes.lane(1).motion) == (Motion.STOPPED, Motion.STOPPED), "a stop acts on all"
    resumed = lanes.give(2, Code.RESUME)
    lanes.bench.settle(second)
    assert (second.state, resumed.state) == (CommandState.DONE, CommandState.DONE)
    assert lanes.lane(0).motion is Motion.STOPPED and first.open
    lanes.give(1, Code.RESUME)
    assert lanes.bench.settle(first).state is CommandState.DONE


def test_a_fault_of_one_lane_ends_its_move_and_no_other(lanes: Lanes) -> None:
    first, second = lanes.order(1, 1), lanes.order(2, 2)
    lanes.bench.run(0.4)
    lanes.bench.core._axes[7].tracking.lag._trip = 1e-9
    lanes.bench.settle(second)
    assert (second.state, second.reason) == (CommandState.ABORTED, Reason.FOLLOWING_ERROR)
    lanes.bench.run(0.3)
    assert lanes.dispatcher.enabled_mask() == ARM
    assert lanes.bench.settle(first).state is CommandState.DONE


def test_a_program_that_is_refused_leaves_the_other_lane_alone(lanes: Lanes) -> None:
    first, wrong = lanes.order(1, 1), lanes.order(2, 4)
    lanes.bench.settle(wrong)
    assert (wrong.state, wrong.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT) and "S1" in wrong.detail
    assert wrong.detail.startswith("scara: "), "the lane, and then the block"
    assert lanes.bench.settle(first).state is CommandState.DONE


def test_an_emergency_stop_ends_the_moves_of_all(lanes: Lanes) -> None:
    jobs = [lanes.order(1, 1), lanes.order(2, 2)]
    lanes.bench.run(0.4)
    lanes.dispatcher.open_ready()
    for job in jobs:
        lanes.bench.settle(job)
        assert (job.state, job.reason) == (CommandState.ABORTED, Reason.EMERGENCY_STOP)
    lanes.bench.run(0.3)
    assert lanes.dispatcher.enabled_mask() == 0


def test_a_coupled_move_takes_the_lanes_and_gives_them_back() -> None:
    lanes = Lanes(Cell402Bench(8, cell=CELL), TEXTS, KINEMATICS)
    lanes.ready(1, ARM | SCARA)
    both = lanes.order(1, 3)
    lanes.bench.run(0.3)
    assert (lanes.lane(0).holds, lanes.lane(1).holds) == (ARM | SCARA, 0)
    assert lanes.order(1, 2).reason is Reason.BUSY, "its axes are another lane's now"
    assert lanes.bench.settle(both, 60.0).state is CommandState.DONE
    lanes.bench.cycle(2)
    assert (lanes.lane(0).holds, lanes.lane(1).holds) == (ARM, SCARA)
    after = lanes.order(1, 2)
    assert lanes.bench.settle(after).state is CommandState.DONE


def test_a_coupled_move_is_refused_while_one_of_its_lanes_moves_or_belongs_to_another(lanes: Lanes) -> None:
    assert lanes.order(1, 3).reason is Reason.NOT_OWNER
    lanes.done(2, Code.RELEASE_CONTROL)
    lanes.done(1, Code.REQUEST_CONTROL, SCARA)
    lanes.order(1, 2)
    lanes.bench.run(0.2)
    assert lanes.order(1, 3).reason is Reason.BUSY
