"""Feed hold, feed allow and override of one kinematic: the other goes on (rho 3 L2842-2910; AX-1787)."""

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import Motion, Permit, Quality, pack_cell_state, unpack_cell_state
from hil_tests.lab.cells.arm_and_scara import cell_text
from hil_tests.lab.cells.carried_cell import ARM as FILE
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.lanes_bench import Lanes
from hil_tests.unit.gateway.pure.cycle.test_lanes import ARM, KINEMATICS, SCARA, TEXTS

CELL_RUN, ALLOW, RUN = 27, 145, 161  # of the cell; of kinematic 2, the SCARA
WIRED = 'wired = ["KIN_2_FEED_ALLOW_RCI", "KIN_2_FEED_HOLD_N_RCI"]\n'


@pytest.fixture
def lanes() -> Lanes:
    """Command source 1 has the arm, 2 the SCARA; all inputs are set."""
    text = cell_text().replace("[rc_inputs]\n", f"[rc_inputs]\n{WIRED}", 1)
    made = Lanes(Cell402Bench(8, cell=load_cell(str(FILE), text)), TEXTS, KINEMATICS)
    made.bench.permit(ALLOW, RUN)
    made.ready(1, ARM)
    made.ready(2, SCARA)
    return made


def still(lanes: Lanes) -> tuple[bool, bool]:
    """Whether arm and SCARA rest."""
    before = lanes.sets()
    lanes.bench.run(0.1)
    moved = [now != was for now, was in zip(lanes.sets(), before, strict=True)]
    return not any(moved[:6]), not any(moved[6:])


@pytest.mark.parametrize("bit", [ALLOW, RUN])
def test_an_input_of_kinematic_2_holds_it_and_leaves_kinematic_1_running(lanes: Lanes, bit: int) -> None:
    first, second = lanes.order(1, 1), lanes.order(2, 2)
    lanes.bench.run(0.4)
    lanes.bench.permit(bit, value=False)
    lanes.bench.run(0.4)
    assert still(lanes) == (False, True)
    assert (lanes.lane(0).withheld, lanes.lane(1).withheld) == (0, Permit.FEED if bit == ALLOW else Permit.RUN)
    assert unpack_cell_state(pack_cell_state(lanes.bench.core.state)).lanes[1].withheld == lanes.lane(1).withheld, "as readers see it"
    assert lanes.bench.core.state.permits & Permit.FEED, "the input of the cell is set all the while"
    lanes.bench.permit(bit)
    assert lanes.bench.settle(second).state is CommandState.DONE, "it goes on by itself, as after a feed hold of the cell"
    assert lanes.bench.settle(first).state is CommandState.DONE


def test_the_feed_hold_of_the_cell_holds_both(lanes: Lanes) -> None:
    lanes.order(1, 1)
    lanes.order(2, 2)
    lanes.bench.run(0.4)
    lanes.bench.permit(CELL_RUN, value=False)
    lanes.bench.run(0.8)
    assert still(lanes) == (True, True)


def test_without_its_feed_allow_a_kinematic_takes_no_move_and_the_other_does(lanes: Lanes) -> None:
    lanes.bench.permit(ALLOW, value=False)
    lanes.bench.run(0.1)
    refused = lanes.order(2, 2)
    assert (refused.state, refused.reason, refused.detail) == (CommandState.REFUSED, Reason.FEED_NOT_ALLOWED, "S1, S2, S3, S4")
    assert lanes.bench.settle(lanes.order(1, 1)).state is CommandState.DONE


def test_an_input_that_is_lost_stops_its_kinematic_and_only_a_resume_moves_it_again(lanes: Lanes) -> None:
    first, second = lanes.order(1, 1), lanes.order(2, 2)
    lanes.bench.run(0.4)
    lanes.bench.inputs.quality[RUN >> 3] = Quality.BAD
    lanes.bench.run(0.5)
    assert still(lanes) == (False, True)
    assert (lanes.lane(1).motion, lanes.lane(1).stop_cause, lanes.lane(0).stop_cause) == (Motion.STOPPED, Reason.INPUT_LOST, Reason.NONE)
    lanes.bench.permit(RUN)
    lanes.bench.run(0.3)
    assert still(lanes)[1], "nothing moves without a fresh command"
    lanes.give(2, Code.RESUME)
    assert lanes.bench.settle(second).state is CommandState.DONE
    assert lanes.bench.settle(first).state is CommandState.DONE


def test_a_program_of_both_waits_for_the_one_that_is_held(lanes: Lanes) -> None:
    lanes.done(2, Code.RELEASE_CONTROL, SCARA)
    lanes.done(1, Code.REQUEST_CONTROL, ARM | SCARA)
    lanes.bench.permit(RUN, value=False)
    both = lanes.order(1, 3)
    lanes.bench.run(0.8)
    assert both.open and still(lanes) == (True, True)
    lanes.bench.permit(RUN)
    assert lanes.bench.settle(both).state is CommandState.DONE


def test_the_override_of_named_axes_is_that_of_their_kinematic(lanes: Lanes) -> None:
    lanes.done(2, Code.RELEASE_CONTROL, SCARA)
    lanes.done(1, Code.REQUEST_CONTROL, ARM | SCARA)
    lanes.done(1, Code.OVERRIDE, velocity=0.8)
    lanes.done(1, Code.AXES_OVERRIDE, 1 << 7, velocity=0.3)
    assert (lanes.lane(0).override, lanes.lane(1).override) == (0.8, 0.3)
    lanes.done(1, Code.OVERRIDE)
    assert (lanes.lane(0).override, lanes.lane(1).override) == (1.0, 1.0), "that of all is of all"
    nothing = lanes.give(1, Code.AXES_OVERRIDE, 0, velocity=0.3)
    assert (nothing.state, nothing.reason) == (CommandState.REFUSED, Reason.MASK)


def test_the_override_of_another_command_source_s_kinematic_is_not_its_business(lanes: Lanes) -> None:
    refused = lanes.give(1, Code.AXES_OVERRIDE, SCARA, velocity=0.3)
    assert (refused.state, refused.reason) == (CommandState.REFUSED, Reason.NOT_OWNER)
    assert lanes.lane(1).override == 1.0
