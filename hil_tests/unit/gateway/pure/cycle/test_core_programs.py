"""The core with a planner: pieces of a program in, done when nothing more comes, and what follows a planner's death.

A program is ordered by a command source (office), its order reaches the cycle, and only then pieces of it are taken (AX-322).
"""

from dataclasses import replace
from itertools import pairwise

import pytest

from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.cycle.enabling_inputs import AS_SHIPPED, free_outputs
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import Motion, Order, OrderRecord, get_bit
from gateway.pure.image.records.planner import AHEAD, Part, PieceRecord, ProgramOrder, run_record
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.cycle_view import CycleView
from gateway.pure.planning.planner import Programs
from hil_tests.lab.virtual.cell_bench import ALL
from hil_tests.lab.virtual.program_bench import LIMITS, WithPlanner, joints
from motion.execution.timed import encode_timed
from motion.kinematics.identity import Identity
from motion.planner.robot import Machine


@pytest.fixture
def both() -> WithPlanner:
    return WithPlanner()


def test_a_program_runs_through_the_core_and_is_done_when_the_axes_are_there(both: WithPlanner) -> None:
    job = both.order(f"ptp joints {joints(5)} blend=joint leave=1 reach=1", f"ptp joints {joints(8)}")
    both.cell.run(0.2)
    assert both.cell.core.state.motion is Motion.RUNNING and both.cell.core.state.piece > 0
    assert job.state is CommandState.RUNNING
    assert both.finished(job).state is CommandState.DONE and both.cell.core.state.failed_job != job.id
    assert both.at(8.0)


def test_a_program_at_half_speed_takes_longer(both: WithPlanner) -> None:
    took = []
    for target, velocity in ((30, 1.0), (4, 1.0), (30, 0.1)):
        begin = both.cell.now
        assert both.finished(both.order(f"ptp joints {joints(target)}", velocity=velocity)).state is CommandState.DONE
        took.append(both.cell.now - begin)
    assert took[2] > 1.5 * took[0]


def test_a_planner_that_dies_leaves_the_axes_at_rest_and_the_job_aborted(both: WithPlanner) -> None:
    job = both.order(f"ptp joints {joints(5)}", f"ptp joints {joints(90)}")
    both.cell.run(0.15)
    assert both.cell.core.state.motion is Motion.RUNNING
    both.planner.alive = False
    both.planner.held.clear()
    both.cell.core.planner_lost()
    both.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.PLANNER_LOST)
    assert both.still(), "nothing goes on by itself"


def test_a_planner_that_dies_before_the_first_piece_moves_nothing(both: WithPlanner) -> None:
    both.planner.alive = False
    job = both.order(f"ptp joints {joints(5)}")
    assert both.still(0.2) and job.state is CommandState.ACCEPTED
    both.cell.core.planner_lost()
    both.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.PLANNER_LOST)
    both.planner.alive = True
    assert both.still(), "a planner that comes too late"


def test_pieces_nobody_ordered_are_dropped(both: WithPlanner) -> None:
    both.program(f"ptp joints {joints(5)}")
    both.planner.alive = False
    both.cell.dispatcher.command(1, Command(Code.PROGRAM, 1), both.cell.now)
    orders = both.cell.dispatcher.take_orders()  # lost on their way to the cycle
    assert [order.order for order in orders] == [Order.PROGRAM]
    both.cell.core.state.taken = orders[0].job  # as if a later one had been taken
    both.planner.alive = True
    assert both.still() and both.programs.state.handed > 0
    assert both.cell.core.state.failed_job != orders[0].job


def test_pieces_for_axes_that_are_off_are_refused_and_nothing_moves(both: WithPlanner) -> None:
    both.planner.alive = False
    job = both.order(f"ptp joints {joints(5)}")
    both.cell.run(0.1)
    both.cell.core._off(Reason.DRIVES_OFF)
    both.planner.alive = True
    both.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.DRIVES_OFF)
    assert both.cell.core.state.motion is Motion.IDLE


def test_an_order_for_axes_that_are_off_fails_in_the_cycle_too(both: WithPlanner) -> None:
    both.cell.core._off(Reason.DRIVES_OFF)
    both.cell.run(0.1)
    both.cell.core.lanes[0].mover.order_program(OrderRecord(Order.PROGRAM, 900, 1, ALL))
    assert (both.cell.core.state.failed_job, both.cell.core.state.failed_reason) == (900, Reason.NOT_READY)
    assert not both.cell.core.starved


@pytest.mark.parametrize(("late", "reason"), [(True, Reason.PATH_LATE), (False, Reason.PATH_JOIN)])
def test_a_piece_that_cannot_be_taken_says_why(both: WithPlanner, late: bool, reason: Reason) -> None:
    job = both.order(f"ptp joints {joints(5)}")
    mover = both.cell.core.lanes[0].mover
    while not mover.stepper.within:
        both.cell.cycle(1)
    both.planner.alive = False
    first, *others = mover.stepper.ahead
    first = replace(first, new_tail=True) if late else replace(first, id=1 << 20)
    for piece in (first, *others):
        both.planner.feed(both.cell.core, PieceRecord(Part.PIECE, mover.program.job, both.cell.core.state.generation, encode_timed(piece)))
    both.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, reason)


def test_pieces_of_an_older_cycle_are_dropped(both: WithPlanner) -> None:
    job = both.order(f"ptp joints {joints(5)}")
    both.cell.cycle(1)
    both.turn()
    both.turn()
    kept = [PieceRecord(record.part, record.job, record.generation + 1, record.piece) for record in both.planner.held]
    assert kept
    both.planner.held, both.planner.alive = kept, False
    moved = both.cell.core.state.piece
    both.cell.run(0.5)
    assert both.cell.core.state.failed_job != job.id and both.cell.core.state.piece in (0, moved)


def test_a_fault_in_a_late_block_is_reported_before_anything_moves(both: WithPlanner) -> None:
    job = both.order(f"ptp joints {joints(5)}", "# a remark", f"ptp joints {joints(6)}", f"ptp joints {joints(1e5)}")
    assert both.still(0.5)
    assert (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT)
    assert both.programs.state.fault_block == 3 and both.programs.state.fault_code == 520
    assert "line 5: block 3, axis A1" in job.detail and "VAL 3 520" in job.detail
    assert both.finished(both.order(f"ptp joints {joints(6)}")).state is CommandState.DONE, "the next one runs"


def test_a_fault_of_the_text_names_its_line_and_nothing_moves(both: WithPlanner) -> None:
    job = both.order(f"ptp joints {joints(5)}", "ptp NOWHERE")
    assert both.still(0.5)
    assert (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT) and "line 3" in job.detail


def test_unknown_numbers_and_a_missing_planner_are_refused_at_once(both: WithPlanner) -> None:
    job = both.cell.dispatcher.command(1, Command(Code.PROGRAM, 7), both.cell.now)
    assert (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_UNKNOWN) and "1 there, 2 back" in job.detail
    both.cell.dispatcher.planner = None
    job = both.cell.dispatcher.order_program(1, 1, both.cell.now)
    assert (job.state, job.reason) == (CommandState.REFUSED, Reason.NOT_READY) and "planner" in job.detail
    assert both.cell.dispatcher.take_programs() == []


def test_rates_owner_and_reference_are_judged_as_for_every_move(both: WithPlanner) -> None:
    both.program(f"ptp joints {joints(5)}")
    assert both.order(velocity=0.0).reason is Reason.RATE
    assert both.order(source=2).reason is Reason.NOT_OWNER
    both.cell.core._axes[2].referenced = False
    both.cell.run(0.1)
    job = both.order()
    assert job.reason is Reason.NOT_REFERENCED and job.detail == "A3"


def test_stop_resume_and_abandon(both: WithPlanner) -> None:
    job = both.order(f"ptp joints {joints(5)} blend=joint leave=1 reach=1", f"ptp joints {joints(40)}")
    both.cell.run(0.25)
    both.cell.settle(both.cell.give(Code.STOP, source=2))
    both.cell.run(0.2)
    assert both.cell.core.state.motion is Motion.STOPPED and both.still()
    both.cell.settle(both.cell.give(Code.RESUME))
    both.finished(job)
    assert job.state is CommandState.DONE and both.at(40.0)
    job = both.order(f"ptp joints {joints(5)}")
    both.cell.run(0.25)
    both.cell.settle(both.cell.give(Code.STOP))
    both.cell.settle(both.cell.give(Code.ABANDON))
    both.cell.run(0.1)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.ABANDONED) and both.still()
    assert both.finished(both.order(f"ptp joints {joints(8)}")).state is CommandState.DONE and both.at(8.0)


def test_a_stop_while_the_program_is_prepared_keeps_it_from_beginning(both: WithPlanner) -> None:
    both.planner.alive = False
    job = both.order(f"ptp joints {joints(5)}")
    both.cell.run(0.05)
    both.cell.settle(both.cell.give(Code.STOP, source=2))
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.STOPPED_BY_SOURCE)
    both.planner.alive = True
    assert both.still()


def test_a_stop_while_more_has_to_come_keeps_it_from_going_on(both: WithPlanner) -> None:
    job = both.order(f"ptp joints {joints(5)}", f"ptp joints {joints(40)}")
    both.cell.run(0.05)
    later = [record for record in both.planner.held if record.part]
    both.planner.alive = False
    both.planner.held.clear()
    for _ in range(400):
        both.cell.cycle()
        if both.cell.core.starved:
            break
    assert both.cell.core.starved and later
    both.cell.settle(both.cell.give(Code.STOP))
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.STOPPED_BY_SOURCE)
    both.planner.alive = True
    assert both.still()


def test_a_planner_that_comes_late_lets_the_axes_rest_and_they_go_on_where_they_stand(both: WithPlanner) -> None:
    job = both.order(*(f"ptp joints {joints(10 * (n % 2))} speed=10" for n in range(1, 12)))
    both.cell.run(0.3)
    both.planner.alive = False
    for _ in range(4000):
        both.cell.cycle()
        if both.cell.core.starved:
            break
    assert both.cell.core.starved and not both.planner.held and both.still(0.2)
    assert job.state is CommandState.RUNNING
    both.planner.alive = True
    assert both.finished(job).state is CommandState.DONE and both.at(10.0)


def test_what_lies_ahead_stays_small_also_after_the_axes_ran_out(both: WithPlanner) -> None:
    both.order(*(f"ptp joints {joints(10 * (n % 2))} speed=10" for n in range(1, 60)))
    both.cell.run(0.1)
    said, standing = both.programs, [axis.set for axis in both.cell.core.state.axes[: len(LIMITS)]]
    ahead: list[PieceRecord] = []
    for piece in (said._chain.last_id, *[0] * 150):  # on its last piece, and then at rest without taking anything
        ahead += said.turn([], CycleView(1, piece, standing, moving=True))
    assert AHEAD < len(ahead) < 3 * AHEAD, "once for either, and a law more"


def test_outputs_of_a_program_switch_where_the_set_values_pass_their_places(both: WithPlanner) -> None:
    outputs = both.cell.core.outputs
    job = both.order(f"ptp joints {joints(20)} out=400:1", f"ptp joints {joints(60)} out=400:0,401:1")
    seen: list[tuple[float, bool, bool]] = []
    each = both.cell.each

    def look() -> None:
        seen.append((both.places()[0], get_bit(outputs, 400), get_bit(outputs, 401)))
        each()

    both.cell.each = look
    both.cell.run(0.4)
    both.cell.settle(both.cell.give(Code.STOP))
    both.cell.settle(both.cell.give(Code.RESUME))
    assert both.finished(job).state is CommandState.DONE
    assert all(on is (place >= 20.0 - 1e-9) for place, on, _ in seen if place < 60.0 - 1e-9), "at the end of the first block"
    assert seen[-1][1:] == (False, True) and all(not after for place, _, after in seen if place < 60.0 - 1e-9)


@pytest.mark.parametrize(("key", "words"), [("out=66:1", "output 66"), ("out=400:2", "output 400"), ("until=1024", "until=1024")])
def test_what_the_cell_cannot_do_for_a_program_is_refused_before_anything_moves(both: WithPlanner, key: str, words: str) -> None:
    job = both.order(f"ptp joints {joints(20)} {key}")
    assert both.still(0.2) and (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT) and words in job.detail


def test_outputs_of_a_program_that_was_abandoned_do_not_switch_later(both: WithPlanner) -> None:
    job = both.order(f"ptp joints {joints(60)} out=400:1")
    both.cell.run(0.25)
    both.cell.settle(both.cell.give(Code.STOP))
    both.cell.settle(both.cell.give(Code.ABANDON))
    assert both.finished(both.order(f"ptp joints {joints(60)}")).state is CommandState.DONE
    assert job.reason is Reason.ABANDONED and not get_bit(both.cell.core.outputs, 400)


PROBE = 300  # an RC input


def test_a_block_ends_when_its_input_comes_and_the_next_begins_where_the_axes_stand(both: WithPlanner) -> None:
    both.cell.permit(PROBE, value=False)
    seen: list[float] = []
    each = both.cell.each

    def look() -> None:
        seen.append(both.places()[0])
        each()

    both.cell.each = look
    job = both.order(f"ptp joints {joints(6)}", f"ptp joints {joints(90)} until={PROBE}", f"ptp joints {joints(10)} out=400:1")
    for _ in range(2000):
        both.cell.cycle()
        if both.places()[0] > 15.0:
            break
    both.cell.permit(PROBE)
    assert both.finished(job).state is CommandState.DONE and both.at(10.0) and get_bit(both.cell.core.outputs, 400)
    assert 15.0 < max(seen) < 85.0, "it stopped on its way"
    assert max(abs(b - a) for a, b in pairwise(seen)) < 1.0, "without a jump"


def test_an_input_that_never_comes_lets_the_block_reach_its_target(both: WithPlanner) -> None:
    both.cell.permit(PROBE, value=False)
    job = both.order(f"ptp joints {joints(20)} until={PROBE} out=400:1", f"ptp joints {joints(30)} until={PROBE}")
    assert both.finished(job).state is CommandState.DONE and both.at(30.0) and get_bit(both.cell.core.outputs, 400)


def test_an_input_that_is_set_already_lets_nothing_move(both: WithPlanner) -> None:
    both.cell.permit(PROBE, value=False)
    before = both.places()
    job = both.order(f"ptp joints {joints(60)} until=!{PROBE} out=400:1")
    assert both.finished(job).state is CommandState.DONE and both.places() == before
    assert not get_bit(both.cell.core.outputs, 400), "its end was not reached"


def test_an_input_nobody_writes_has_no_value(both: WithPlanner) -> None:
    assert both.finished(both.order(f"ptp joints {joints(8)} until=!{PROBE}")).state is CommandState.DONE and both.at(8.0)


def test_blocks_behind_one_that_ends_with_an_input_are_tried_before_anything_moves(both: WithPlanner) -> None:
    both.cell.permit(PROBE, value=False)
    job = both.order(f"ptp joints {joints(20)}", f"ptp joints {joints(30)} until={PROBE}", "# far", f"ptp joints {joints(1e5)}")
    assert both.still(0.3) and (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT)
    assert "line 5: block 3, axis A1" in job.detail


def test_no_move_begins_beside_a_program_that_is_prepared(both: WithPlanner) -> None:
    both.planner.alive = False
    both.order(f"ptp joints {joints(5)}")
    both.cell.run(0.05)
    assert both.cell.give(Code.PTP_ABSOLUTE, targets=(30.0,), mask=1).reason is Reason.BUSY
    assert both.order(f"ptp joints {joints(6)}").reason is Reason.BUSY


def test_a_program_without_moves_is_done_at_once(both: WithPlanner) -> None:
    assert both.finished(both.order("# nothing")).state is CommandState.DONE


def test_a_new_cycle_knows_nothing_of_the_program(both: WithPlanner) -> None:
    job = both.order(f"ptp joints {joints(40)}")
    both.cell.run(0.2)
    both.cell.restart_cycle()
    both.cell.run(0.1)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.CYCLE_RESTARTED)
    assert both.still() and both.programs.state.job == 0


def test_a_fault_found_before_the_cycle_took_the_order_waits_for_it() -> None:
    """The planner may be quicker than the cycle, which drops what belongs to a job it has not heard of: the job would never end."""
    programs = Programs(
        CellPrograms(lambda *_: Machine(Identity(LIMITS), LIMITS), lambda _: ALL, lambda _: "nonsense", free_outputs(AS_SHIPPED, 6))
    )
    order = [run_record(ProgramOrder(7, 1, 1.0, 1.0))]
    assert programs.turn(order, CycleView(1, 0, [0.0] * 6, moving=False, taken=6)) == []
    programs.prepare([0.0] * 6)
    assert programs.turn([], CycleView(1, 0, [0.0] * 6, moving=False, taken=6)) == [] and programs.state.failed_job == 7
    said = programs.turn([], CycleView(1, 0, [0.0] * 6, moving=False, taken=7))
    assert [(record.part, record.job) for record in said] == [(Part.FAULT, 7)]
    assert programs.turn([], CycleView(1, 0, [0.0] * 6, moving=False, taken=7)) == []
