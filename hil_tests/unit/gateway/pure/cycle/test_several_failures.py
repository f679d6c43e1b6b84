"""Several orders that fail in one cycle all tell it, and a program that failed is never done; AX-514.

A program may also end before the end of its first path came: nothing of that path stays for the next one.
"""

from dataclasses import replace

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import CellState, Order, OrderRecord, pack_cell_state, unpack_cell_state
from gateway.pure.image.records.planner import Part, PieceRecord, run_record
from gateway.pure.planning.turn import follow, positions
from hil_tests.lab.virtual.cell_bench import ALL
from hil_tests.lab.virtual.program_bench import LIMITS, WithPlanner, joints
from motion.execution.timed import TimedPiece, decode_any, encode_timed

LAST_AXIS = 1 << 5


@pytest.fixture
def both() -> WithPlanner:
    return WithPlanner()


def test_a_move_and_an_enabling_that_end_by_one_emergency_both_say_so(both: WithPlanner) -> None:
    cell = both.cell
    assert cell.settle(cell.give(Code.DISABLE, mask=LAST_AXIS)).state is CommandState.DONE
    move = cell.give(Code.PTP_ABSOLUTE, mask=ALL & ~LAST_AXIS, targets=(90.0,) * 6)
    cell.run(0.1)
    enabling = cell.give(Code.ENABLE, mask=LAST_AXIS)
    cell.cycle(2)
    assert move.open and enabling.open
    cell.permit(24, value=False)
    cell.cycle(3)
    assert [(job.state, job.reason) for job in (move, enabling)] == [(CommandState.ABORTED, Reason.EMERGENCY_STOP)] * 2


def test_two_enablings_that_wait_both_end_by_one_emergency(both: WithPlanner) -> None:
    cell = both.cell
    cell.settle(cell.give(Code.DISABLE))
    first, second = cell.give(Code.ENABLE, mask=1), cell.give(Code.ENABLE, mask=2)
    cell.cycle(2)
    assert first.open and second.open
    cell.permit(24, value=False)
    cell.cycle(3)
    assert [(job.state, job.reason) for job in (first, second)] == [(CommandState.ABORTED, Reason.EMERGENCY_STOP)] * 2


def test_a_program_that_failed_is_not_done_at_its_end_whatever_fails_meanwhile(both: WithPlanner) -> None:
    job = both.order(f"ptp joints {joints(5)}", f"ptp joints {joints(90)}")
    both.cell.run(0.15)
    both.planner.alive = False
    both.planner.held.clear()
    core = both.cell.core
    core.planner_lost()
    for other in range(900, 906):
        core.lanes[0].mover.order_program(OrderRecord(Order.PROGRAM, other, 1, ALL))
    both.cell.run(2.0)
    assert core.state.done_job != job.id and not core.lanes[0].mover.busy


def test_four_failures_are_known_the_newest_reason_counts_and_the_region_carries_them() -> None:
    state = CellState()
    for job, reason in ((1, 11), (2, 12), (3, 13), (4, 14), (5, 15), (5, 16), (0, 17)):
        state.fail(job, reason)
    assert (state.failed_job, state.failed_reason) == (5, 16)
    seen = unpack_cell_state(pack_cell_state(state))
    assert [seen.failure(job) for job in range(7)] == [0, 0, 12, 13, 14, 16, 0]


def test_a_path_whose_end_never_came_is_gone_with_its_program(both: WithPlanner) -> None:
    core, planner = both.cell.core, both.planner
    planner.alive = False
    job = both.order(f"ptp joints {joints(5)}")
    both.cell.cycle(2)
    said = [run_record(order) for order in both.cell.dispatcher.take_programs()]
    made = follow(both.programs, said, core.state, len(LIMITS))
    while both.programs.preparing:
        both.programs.prepare(positions(core.state, len(LIMITS)))
    while not any(record.part is Part.PIECE for record in made):
        made = follow(both.programs, [], core.state, len(LIMITS))
    piece = next(record for record in made if record.part is Part.PIECE)
    cut = decode_any(piece.piece)
    assert isinstance(cut, TimedPiece)
    moving = replace(cut, times=cut.times[:4], nodes=cut.nodes[:4], ends_at_rest=False)
    core.feed(replace(piece, piece=encode_timed(moving)))
    assert core.lanes[0].mover.stepper.ahead and both.still(0.1), "it waits for its end"
    core.feed(PieceRecord(Part.FAULT, job.id, core.state.generation))
    assert not core.lanes[0].mover.stepper.ahead
    both.finished(job)
    assert job.reason is Reason.PROGRAM_FAULT
    planner.alive = True
    assert both.finished(both.order(f"ptp joints {joints(3)}")).state is CommandState.DONE and both.at(3.0)
