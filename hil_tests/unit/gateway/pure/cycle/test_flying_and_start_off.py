"""Programs of a cell: a probe that measures while the axes go on (rho3 2.8), and inputs a movement waits for (rho3 1.4)."""

import itertools
import math

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.virtual.probing import CLOSE, FAST, ON_TWO, PROBE, Probing
from hil_tests.lab.virtual.program_bench import joints


@pytest.fixture(scope="module")
def bench() -> Probing:
    return Probing()


@pytest.fixture
def cell(bench: Probing) -> Probing:
    """At rest, near the beginning of the travel, both inputs 0."""
    bench.planner.alive = True
    bench.cell.permit(PROBE, FAST, value=False)
    if bench.cell.core.state.motion is Motion.STOPPED:
        bench.cell.settle(bench.cell.give(Code.ABANDON))
    if not bench.at(2.0):
        assert bench.finished(bench.order(f"ptp joints {joints(2)}")).state is CommandState.DONE
    bench.seen.clear()
    return bench


def run_to(cell: Probing, place: float) -> None:
    for _ in range(3000):
        cell.cell.cycle()
        if cell.places()[0] > place:
            return
    raise AssertionError(f"never at {place}: {cell.places()}")


# ---- flying measurement ----------------------------------------------------------------------------------------------------


def speeds(cell: Probing) -> list[float]:
    """Axis 1 from SYNC to SYNC."""
    return [b - a for (_, a), (_, b) in itertools.pairwise(cell.seen)]


def way(cell: Probing, *lines: str, edge_beyond: float = 1e9) -> tuple[list[float], int]:
    """Set values of axis 1 from their first change to the end; the input changes once, 0.37 cycles before a SYNC; its stamp."""
    job, sets, stamp = cell.order(*lines), list[float](), 0
    begin = cell.places()[0]
    while job.open:
        cell.cell.cycle()
        here = cell.places()[0]
        if here > edge_beyond and not stamp:
            assert not cell.cell.core.state.measured_mask and not cell.cell.core.lanes[0].mover.storing.flying.read(610)
            stamp = cell.change(PROBE, ago=0.37)
            cell.cell.cycle()
            cell.cell.cycle()
            assert cell.cell.core.lanes[0].mover.storing.flying.read(610) == 1, "the channel reads 1 from now on"
            sets += [math.nan, math.nan]
            here = cell.places()[0]
        if sets or here != begin:
            sets.append(here)
    assert job.state is CommandState.DONE
    return sets, stamp


@pytest.mark.requirement("RHO-MOT-16", by="gateway.pure.cycle.inputs:CoreFlying.call")
@pytest.mark.requirement("RHO-MOT-16", by="gateway.pure.cycle.inputs:CoreFlying.store")
def test_the_axes_go_on_while_the_probe_stores_where_they_were_at_its_edge() -> None:
    cell, other = Probing(), Probing()  # they have done the same until then, to the last digit
    for each in (cell, other):
        assert each.finished(each.order(f"ptp joints {joints(3)}")).state is CommandState.DONE
    sets, stamp = way(cell, "measure_on ch610", f"ptp joints {joints(50)}", edge_beyond=30.0)
    assert cell.measured == pytest.approx(cell.was(stamp), abs=CLOSE) and cell.at(50.0)
    plain, _ = way(other, f"ptp joints {joints(50)}")
    seen = [(a, b) for a, b in zip(sets, plain, strict=False) if not math.isnan(a)]
    assert len(seen) > 100 and max(abs(a - b) for a, b in seen) < 1e-9, "nothing of it is seen in the movement"


def test_only_the_asked_edge_counts_and_only_while_it_is_switched_on(cell: Probing) -> None:
    cell.change(PROBE)
    job = cell.order(
        "measure_on ch610 edge=0", f"ptp joints {joints(30)} blend=joint zone={zone()}", "measure_off ch610", f"ptp joints {joints(60)}"
    )
    run_to(cell, 10.0)
    stamp = cell.change(PROBE, value=False, ago=0.2)
    cell.cell.run(0.02)
    assert cell.measured == pytest.approx(cell.was(stamp), abs=CLOSE)
    assert cell.finished(job).state is CommandState.DONE
    assert cell.finished(cell.order(f"ptp joints {joints(2)}")).state is CommandState.DONE
    job = cell.order("measure_on ch610", f"ptp joints {joints(30)}", "measure_off ch610", f"ptp joints {joints(3)}")
    run_to(cell, 29.9999)
    cell.cell.run(0.4)
    cell.change(PROBE)
    assert cell.finished(job).state is CommandState.DONE
    assert not cell.cell.core.state.measured_mask, "switched off before its edge came"


def zone() -> str:
    return ",".join("1" for _ in joints(0).split())


def test_a_later_block_goes_back_to_where_the_probe_was_met_and_there_the_program_rests(cell: Probing) -> None:
    lines = ("measure_on ch610", f"ptp joints {joints(40)}", f"ptp joints {joints(50)}", "ptp mpos", f"ptp joints {joints(4)}")
    sets, stamp = way(cell, *lines, edge_beyond=20.0)
    measured = cell.was(stamp) / cell.cell.dispatcher.axes[0].si
    away = [abs(place - measured) for place in sets[sets.index(max(sets)) :] if not math.isnan(place)]
    assert min(away) < 5e-3 and cell.at(4.0), "gone back to there, before the last block"


def test_without_an_edge_mpos_is_not_defined_and_the_program_ends_where_it_stands(cell: Probing) -> None:
    job = cell.order("measure_on ch610", f"ptp joints {joints(9)}", "ptp mpos")
    assert cell.finished(job).state is CommandState.ABORTED
    assert "point not defined" in job.detail and "block 2, axis A1" in job.detail and cell.at(9.0)


def test_axes_of_another_board_are_not_measured_on_the_way(cell: Probing) -> None:
    job = cell.order("measure_on ch620", f"ptp joints {joints(50)}")
    cell.edge_at(20.0)
    assert cell.finished(job).state is CommandState.DONE
    assert cell.cell.core.state.measured_mask == ON_TWO


def test_the_next_program_knows_nothing_of_it_and_an_edge_between_programs_counts_nowhere(cell: Probing) -> None:
    assert cell.finished(cell.order("measure_on ch610", f"ptp joints {joints(9)}")).state is CommandState.DONE
    cell.change(PROBE)
    cell.cell.run(0.1)
    assert not cell.cell.core.state.measured_mask
    job = cell.order(f"ptp joints {joints(12)}")
    assert cell.finished(job).state is CommandState.DONE and not cell.cell.core.lanes[0].mover.storing.flying.read(610)


# ---- fast start-off --------------------------------------------------------------------------------------------------------


def started(cell: Probing) -> int:
    """Time of the first SYNC whose set values have left the place they were at."""
    before = cell.places()[0]
    for _ in range(500):
        cell.cell.cycle()
        if cell.places()[0] != before:
            return cell.cell.core.state.sync_ns
    raise AssertionError("it does not start")


@pytest.mark.requirement("RHO-MOT-17", by="gateway.pure.cycle.inputs:CoreStart.step")
@pytest.mark.parametrize("ago", [0.0, 0.37, 0.99])
def test_the_movement_begins_within_two_cycles_of_the_edge(cell: Probing, ago: float) -> None:
    job = cell.order(f"ptp joints {joints(30)} wait=ch611")
    assert cell.still(0.5) and job.open, "everything is prepared, nothing moves"
    stamp = cell.change(FAST, ago=ago)
    assert 0 <= started(cell) - stamp <= 2 * cell.cell.period_ns
    assert cell.finished(job).state is CommandState.DONE and cell.at(30.0)


@pytest.mark.requirement("RHO-MOT-19", by="gateway.pure.cycle.inputs:CoreStart.begin")
def test_max_time_is_kept_from_the_edge_on(cell: Probing) -> None:
    job = cell.order(f"ptp joints {joints(30)} wait=ch611 delay=0.15")
    assert cell.still(0.3)
    stamp = cell.change(FAST, ago=0.5)
    cell.cell.cycle(5)
    cell.change(FAST, value=False)
    assert 0 <= started(cell) - stamp - 150_000_000 <= 2 * cell.cell.period_ns
    assert cell.finished(job).state is CommandState.DONE


def test_a_condition_that_holds_already_lets_it_begin_at_once_and_the_block_before_ends_at_rest(cell: Probing) -> None:
    cell.change(FAST)
    job = cell.order(
        f"ptp joints {joints(10)} blend=joint zone={zone()}", f"ptp joints {joints(20)} wait=ch611", f"ptp joints {joints(25)} wait=!301"
    )
    run_to(cell, 19.999)
    cell.cell.run(0.3)
    assert cell.still(0.3) and job.open and cell.at(20.0), "301 is still 1"
    cell.change(FAST, value=False)
    assert cell.finished(job).state is CommandState.DONE and cell.at(25.0)


def test_stopped_while_it_waits_it_waits_for_resume_and_edge_both(cell: Probing) -> None:
    job = cell.order(f"ptp joints {joints(30)} wait=ch611")
    assert cell.still(0.3)
    cell.cell.settle(cell.cell.give(Code.STOP))
    cell.change(FAST)
    assert cell.still(0.3) and cell.cell.core.state.motion is Motion.STOPPED
    cell.cell.settle(cell.cell.give(Code.RESUME))
    assert cell.finished(job).state is CommandState.DONE and cell.at(30.0)


def test_resumed_before_its_edge_it_still_waits_and_override_does_not_let_it_go(cell: Probing) -> None:
    job = cell.order(f"ptp joints {joints(30)} wait=ch611")
    assert cell.still(0.3)
    cell.cell.settle(cell.cell.give(Code.STOP))
    cell.cell.give(Code.RESUME)
    cell.cell.settle(cell.cell.give(Code.OVERRIDE, velocity=0.5))
    assert cell.still(0.3) and job.open
    cell.cell.settle(cell.cell.give(Code.OVERRIDE))
    cell.change(FAST)
    assert cell.finished(job).state is CommandState.DONE


def test_abandoned_while_it_waits_no_edge_moves_anything_any_more(cell: Probing) -> None:
    job = cell.order(f"ptp joints {joints(30)} wait=ch611")
    assert cell.still(0.3)
    cell.cell.settle(cell.cell.give(Code.STOP))
    cell.cell.settle(cell.cell.give(Code.ABANDON))
    cell.change(FAST)
    assert cell.still(0.4) and (job.state, job.reason) == (CommandState.ABORTED, Reason.ABANDONED)
    assert cell.finished(cell.order(f"ptp joints {joints(7)}")).state is CommandState.DONE and cell.at(7.0), "the next program is not held"


def test_drives_off_end_the_wait(cell: Probing) -> None:
    job = cell.order(f"ptp joints {joints(30)} wait=ch611")
    assert cell.still(0.3)
    cell.cell.settle(cell.cell.give(Code.DISABLE))
    cell.cell.settle(cell.cell.give(Code.ENABLE))
    cell.change(FAST)
    assert cell.still(0.4) and job.state is CommandState.ABORTED
    assert cell.finished(cell.order(f"ptp joints {joints(5)}")).state is CommandState.DONE


def test_a_planner_that_dies_meanwhile_ends_it_where_it_stands(cell: Probing) -> None:
    cell.order(f"ptp joints {joints(10)} wait=ch611", f"ptp joints {joints(20)} wait=ch611")
    assert cell.still(0.3)
    cell.planner.alive = False
    cell.cell.core.planner_lost()
    cell.change(FAST)
    assert cell.still(0.4), "after any death nothing moves without a fresh command"


def test_a_wait_and_a_probe_at_the_same_block(cell: Probing) -> None:
    job = cell.order(f"ptp joints {joints(50)} wait=ch611 until=ch610 error=NONE", "ptp mpos", "label NONE", f"ptp joints {joints(6)}")
    cell.change(PROBE)
    assert cell.still(0.2), "its edge before the start counts for nothing"
    cell.change(PROBE, value=False)
    cell.cell.run(0.1)
    cell.change(FAST)
    stamp = cell.edge_at(20.0)
    assert cell.finished(job).state is CommandState.DONE and cell.at(6.0)
    assert cell.measured == pytest.approx(cell.was(stamp), abs=CLOSE)


@pytest.mark.parametrize("standing", [False, True])
def test_a_block_behind_a_wait_does_not_move_at_all_where_its_time_is_0_or_its_input_is_set(cell: Probing, standing: bool) -> None:
    within = "" if standing else " within=0"
    job = cell.order(f"ptp joints {joints(50)} wait=ch611 until={PROBE}{within} error=LATE", f"ptp joints {joints(1)}", "label LATE")
    assert cell.still(0.2) and job.open
    before = cell.places()[0]
    cell.change(PROBE, value=standing)
    cell.change(FAST)
    places: list[float] = []
    while job.open:
        cell.cell.cycle()
        places.append(cell.places()[0])
    assert job.state is CommandState.DONE
    assert cell.at(1.0 if standing else 2.0) and max(places) == before


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["measure_on ch630", f"ptp joints {joints(5)}"], "inadmissable input: channel 630"),
        (["measure_on ch611", f"ptp joints {joints(5)}"], "inadmissable input: channel 611; probes of the robot: ch610, ch620"),
        (["measure_on ch620", f"ptp joints {joints(5)}", "ptp mpos"], "block 2, axis A3: point not defined"),
        ([f"ptp joints {joints(5)} wait=ch610"], "inadmissable input: channel 610; high-speed inputs of the robot: ch611"),
        ([f"ptp joints {joints(5)} wait=2000"], "wait=2000: an RC input is needed"),
        ([f"ptp joints {joints(5)} delay=1"], "delay"),
        ([f"ptp joints {joints(5)} wait=ch611 delay=-1"], "delay: -1 s is outside"),
        ([f"ptp joints {joints(5)} wait=x"], "wait: 'x'"),
        (["measure_on 610", f"ptp joints {joints(5)}"], "the channel of a probe"),
        (["measure_on ch610 edge=2", f"ptp joints {joints(5)}"], "edge: 'edge=2'"),
        ([f"ptp joints {joints(5)}", "measure_on ch610"], "measure_on"),
    ],
)
def test_what_can_be_known_of_them_is_refused_before_anything_moves(cell: Probing, lines: list[str], words: str) -> None:
    job = cell.order(*lines)
    assert cell.still(0.2) and (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT)
    assert words in job.detail
