"""What begins or ends with a block that has no way is done all the same: where the next one begins, else where the last one ended."""

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.cycle.path_outputs import CoreOutputs
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import get_bit
from hil_tests.lab.virtual.probing import FAST, Probing
from hil_tests.lab.virtual.program_bench import LIMITS, WithPlanner, joints
from hil_tests.unit.gateway.pure.cycle.test_functions_in_programs import IOL, PLACES, bench, both, seen
from hil_tests.unit.motion.program.test_points_in_programs import Portal, cell
from motion.kinematics.portal import Portal as Portals

__all__ = ["bench", "both", "cell"]

OUT, STARTS = 700, 900
HERE = "ptp rel joints 0 0 0 0 0 0"  # the manual's dummy block


@pytest.mark.parametrize("corner", ["", " blend=joint leave=2 reach=2"])
def test_a_function_of_a_dummy_block_is_called_where_the_next_one_begins(both: WithPlanner, corner: str) -> None:
    lines = (f"ptp joints {joints(10)}{corner}", "iol -2 1 1 0 1 0", HERE + corner, f"ptp joints {joints(20)}")
    first = next(x for x, on in seen(both, *lines) if on)
    assert 9.0 < first < 11.5


def test_behind_everything_it_is_called_where_the_last_one_ends(both: WithPlanner) -> None:
    rows = seen(both, f"ptp joints {joints(10)}", "iol -2 1 1 0 1 0", HERE)
    assert [on for x, on in rows if x < 9.9].count(True) == 0 and get_bit(both.cell.core.outputs, IOL)


def test_an_output_at_its_end_is_switched_there(both: WithPlanner) -> None:
    assert both.finished(both.order(f"ptp joints {joints(3)} out={OUT}:0", f"ptp joints {joints(2)}")).state is CommandState.DONE
    job, rows = both.order(f"ptp joints {joints(10)}", f"{HERE} out={OUT}:1", f"ptp joints {joints(20)}"), []
    while job.open:
        both.cell.cycle()
        rows.append((both.places()[0], get_bit(both.cell.core.outputs, OUT)))
    assert job.state is CommandState.DONE and 9.9 < next(x for x, on in rows if on) < 10.5


@pytest.mark.parametrize(
    ("lines", "block"), [(("iol -2 1 1 0 1 0", HERE), 1), ((f"ptp joints {joints(10)} until=900", "iol -2 1 1 0 1 0", HERE), 2)]
)
def test_where_no_way_is_left_it_is_reported_before_anything_moves(both: WithPlanner, lines: tuple[str, ...], block: int) -> None:
    job = both.order(*lines)
    assert both.still(0.2) and (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT)
    assert f"block {block}: this action needs a motion to attach to" in job.detail, job.detail


def test_it_is_called_in_the_next_part_where_its_own_has_no_way(both: WithPlanner) -> None:
    lines = (f"ptp joints {joints(10)} until=900", "iol -2 1 1 0 1 0", HERE, f"ptp joints {joints(20)} until=900")
    assert 9.9 < next(x for x, on in seen(both, *lines) if on) < 10.5


def test_what_begins_with_a_block_to_an_entry_is_done_once(cell: Portal) -> None:
    assert cell.run("record_on 1 10mm", "linear pose 150 100 50 0 0 0 path=40") is CommandState.DONE
    there = ("record_on 1 1mm", "linear recorded 3 path=40", "linear rel pose 2 0 0 0 0 0 path=40 until=900", "linear recorded 15")
    assert cell.run(*there) is CommandState.DONE, "its own way is recorded, and not that of the block behind alone"


def test_a_reference_path_ends_there(cell: Portal) -> None:
    assert (
        cell.run("record_on 1 10mm", "linear pose 150 100 50 0 0 0 path=40", "record_off", "linear rel pose 0 0 0 0 0 0")
        is CommandState.DONE
    )
    assert cell.run("linear pose 300 100 50 0 0 0", "ptp recorded 1") is CommandState.DONE
    assert cell.bench.set()[0] < 150.5, "the latest entry is that of the path before"


@pytest.fixture(scope="module")
def probing() -> Probing:
    made = Probing()
    made.programs.cell.functions = PLACES
    made.cell.core.lanes[0].mover.functions = CoreOutputs(PLACES, {1: Portals("xyz", LIMITS[:3])}, made.cell.period_ns / 1e9)
    return made


BEHIND = [(), (f"ptp joints {joints(30)} until=900",), ("mach_pos joints " + joints(3),)]


@pytest.mark.parametrize("behind", BEHIND, ids=["the end", "an input", "mach_pos"])
def test_it_is_done_at_rest_where_a_part_to_mpos_has_no_way_because_the_axes_stand_there(probing: Probing, behind: tuple[str, ...]) -> None:
    probing.cell.permit(FAST, value=False)
    before = ["iol -2 1 1 0 0 0", f"ptp joints {joints(1)} out={OUT}:0", f"ptp joints {joints(2)}"]
    assert probing.finished(probing.order(*before)).state is CommandState.DONE
    job = probing.order(f"ptp joints {joints(90)} until=ch611", "ptp mpos", "iol -2 1 1 0 1 0", f"ptp mpos out={OUT}:1", *behind)
    probing.edge_at(20.0, FAST)
    while job.open and not get_bit(probing.cell.core.outputs, OUT):
        probing.cell.cycle()
    assert get_bit(probing.cell.core.outputs, IOL) and get_bit(probing.cell.core.outputs, OUT)
    assert probing.places()[0] == pytest.approx(probing.measured / probing.cell.dispatcher.axes[0].si, abs=1e-9), "there, not behind it"
    assert probing.finished(job).state is CommandState.DONE


def test_it_is_done_at_rest_where_an_input_let_nothing_move_at_all(probing: Probing) -> None:
    probing.cell.permit(FAST, value=False)
    before = ["iol -2 1 1 0 0 0", f"ptp joints {joints(1)}", f"ptp joints {joints(2)}"]
    assert probing.finished(probing.order(*before)).state is CommandState.DONE and not get_bit(probing.cell.core.outputs, IOL)
    probing.change(FAST)
    here = " ".join(map(repr, probing.places()))
    job = probing.order(f"ptp joints {joints(10)} until=ch611 error=ON", "iol -2 1 1 0 1 0", "label ON", f"ptp joints {here}")
    assert probing.finished(job).state is CommandState.DONE and probing.at(2.0)
    assert get_bit(probing.cell.core.outputs, IOL)


@pytest.mark.parametrize("behind", BEHIND, ids=["the end", "an input", "mach_pos"])
def test_a_block_without_way_waits_for_its_input_too(probing: Probing, behind: tuple[str, ...]) -> None:
    probing.cell.permit(FAST, STARTS, value=False)
    before = ["iol -2 1 1 0 0 0", f"ptp joints {joints(1)} out={OUT}:0", f"ptp joints {joints(2)}"]
    assert probing.finished(probing.order(*before)).state is CommandState.DONE
    lines = (f"ptp joints {joints(90)} until=ch611", "ptp mpos", "iol -2 1 1 0 1 0", f"ptp mpos wait={STARTS} out={OUT}:1", *behind)
    job = probing.order(*lines)
    probing.edge_at(20.0, FAST)
    probing.cell.run(3.0)
    there = probing.places()[0]
    assert job.open and there == pytest.approx(probing.measured / probing.cell.dispatcher.axes[0].si, abs=1e-9)
    assert not get_bit(probing.cell.core.outputs, OUT)
    probing.change(STARTS)
    assert probing.finished(job).state is CommandState.DONE
    assert get_bit(probing.cell.core.outputs, OUT) and get_bit(probing.cell.core.outputs, IOL)


def test_a_stop_ends_a_program_that_waits_so(probing: Probing) -> None:
    probing.cell.permit(FAST, STARTS, value=False)
    assert probing.finished(probing.order(f"ptp joints {joints(1)} out={OUT}:0", f"ptp joints {joints(2)}")).state is CommandState.DONE
    job = probing.order(f"ptp joints {joints(90)} until=ch611", "ptp mpos", f"ptp mpos wait={STARTS} out={OUT}:1")
    probing.edge_at(20.0, FAST)
    probing.cell.run(2.0)
    assert job.open
    assert probing.cell.settle(probing.cell.give(Code.STOP)).state is CommandState.DONE
    probing.cell.run(0.5)
    probing.change(STARTS)
    assert probing.finished(job).state is CommandState.ABORTED and not get_bit(probing.cell.core.outputs, OUT)
