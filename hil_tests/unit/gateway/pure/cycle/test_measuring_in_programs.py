"""MOVE UNTIL in programs of a cell (rho3 4.3): the position caught at the edge, what reads it, and where it goes on without it."""

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.jobs import Job
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.virtual.probing import CLOSE, FAST, ON_TWO, PROBE, Probing
from hil_tests.lab.virtual.program_bench import joints


@pytest.fixture(scope="module")
def bench() -> Probing:
    return Probing()


@pytest.fixture
def both(bench: Probing) -> Probing:
    """At rest, near the beginning of the travel, both inputs 0."""
    bench.cell.permit(PROBE, FAST, value=False)
    if not bench.at(2.0):
        assert bench.finished(bench.order(f"ptp joints {joints(2)}")).state is CommandState.DONE
    bench.seen.clear()
    return bench


def done(both: Probing, job: Job) -> bool:
    return both.finished(job).state is CommandState.DONE


@pytest.mark.requirement("RHO-MOT-10", by="gateway.pure.cycle.measure_until:CoreMeasure.look")
def test_a_probe_stops_the_axes_on_their_way_and_mpos_is_where_they_were_at_its_edge(both: Probing) -> None:
    job = both.order(f"ptp joints {joints(90)} until=ch610", "ptp mpos")
    stamp = both.edge_at(20.0, ago=0.37)
    assert done(both, job)
    assert both.measured == pytest.approx(both.was(stamp), abs=CLOSE)
    furthest = max(q for _, q in both.seen)
    assert furthest > both.measured + 1e-3, "they stopped behind it, within their limits"
    assert both.cell.core.state.axes[0].set == pytest.approx(both.measured, abs=1e-9), "MOVE TO @MPOS"


def test_a_fast_input_stores_the_next_position_controller_cycle(both: Probing) -> None:
    job = both.order(f"ptp joints {joints(90)} until=ch611")
    stamp = both.edge_at(20.0, FAST, ago=0.37)
    assert done(both, job)
    grid = both.cell.period_ns
    assert both.measured == pytest.approx(both.was(-(-stamp // grid) * grid), abs=CLOSE)


@pytest.mark.requirement("RHO-MOT-11", by="gateway.pure.cycle.measure_until:CoreMeasure.value_present")
def test_a_fast_input_that_is_set_lets_nothing_move_and_measures_where_the_axes_stand(both: Probing) -> None:
    before = both.places()
    both.change(FAST)
    assert done(both, both.order(f"ptp joints {joints(60)} until=ch611"))
    assert both.places() == before
    assert both.measured == pytest.approx(both.cell.core.state.axes[0].actual, abs=3e-5), "within the increments of the encoder"


@pytest.mark.requirement("RHO-MOT-11", by="gateway.pure.cycle.measure_until:CoreMeasure.look")
def test_a_probe_that_stands_has_to_change_during_the_block(both: Probing) -> None:
    both.change(PROBE)
    job = both.order(f"ptp joints {joints(90)} until=ch610")
    for _ in range(3000):
        both.cell.cycle()
        if both.places()[0] > 10.0:
            break
    both.change(PROBE, value=False)
    both.cell.run(0.05)
    assert not both.cell.core.state.measured_mask, "it has not risen yet"
    both.edge_at(20.0)
    assert done(both, job) and 20.0 < both.places()[0] < 88.0


@pytest.mark.requirement("RHO-MOT-12", by="gateway.pure.planning.trial:Trial.skip")
def test_without_an_edge_the_program_goes_on_at_the_label_and_mpos_is_not_read(both: Probing) -> None:
    way = [
        f"ptp joints {joints(20)} until=ch610 error=NONE",
        "ptp mpos",
        f"ptp joints {joints(5)}",
        "label NONE",
        f"ptp joints {joints(9)}",
    ]
    assert done(both, both.order(*way)) and both.at(9.0)
    assert max(q for _, q in both.seen) < 21.0 * both.cell.dispatcher.axes[0].si, "the rest was left out"
    assert not any(abs(q / both.cell.dispatcher.axes[0].si - 5.0) < 1e-6 for _, q in both.seen[-200:])
    assert both.cell.core.state.measured_mask == 0
    assert both.programs.state.block in (0, 4)


def test_with_an_edge_the_label_is_passed(both: Probing) -> None:
    way = [f"ptp joints {joints(90)} until=ch610 error=END out=400:1", f"ptp joints {joints(7)}", "label END"]
    job = both.order(*way)
    both.edge_at(20.0)
    assert done(both, job) and both.at(7.0)


def test_a_label_at_the_very_end_ends_the_program(both: Probing) -> None:
    job = both.order(f"ptp joints {joints(12)} until=ch610 error=END", f"ptp joints {joints(40)}", "label END")
    assert done(both, job) and both.at(12.0)


@pytest.mark.requirement("RHO-MOT-13", by="gateway.pure.planning.parts:Measuring.resolved")
def test_mpos_after_a_block_whose_input_never_came_is_not_defined(both: Probing) -> None:
    job = both.order(f"ptp joints {joints(12)} until=ch610", "ptp mpos")
    assert both.finished(job).state is CommandState.ABORTED
    assert job.reason is Reason.PROGRAM_FAULT and "point not defined" in job.detail and "block 2, axis A1" in job.detail
    assert both.at(12.0) and both.still(0.2)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["ptp mpos"], "block 1, axis A1: point not defined"),
        ([f"ptp joints {joints(5)} until=ch620", "ptp mpos"], "block 2, axis A3: point not defined"),
        ([f"ptp joints {joints(5)} until=ch630"], "inadmissable input: channel 630"),
        ([f"ptp joints {joints(5)} until=ch730"], "inadmissable input: channel 730"),
        ([f"ptp joints {joints(5)} until=ch610 error=X", f"ptp joints {joints(6)}"], "label X"),
        (["label X", f"ptp joints {joints(5)} until=ch610 error=X"], "label X"),
        ([f"ptp joints {joints(5)} error=X", "label X"], "error"),
    ],
)
def test_what_can_be_known_is_refused_before_anything_moves(both: Probing, lines: list[str], words: str) -> None:
    job = both.order(*lines)
    assert both.still(0.2) and (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT)
    assert words in job.detail


def test_axes_of_another_board_are_not_measured(both: Probing) -> None:
    job = both.order(f"ptp joints {joints(90)} until=ch620")
    both.edge_at(20.0)
    assert done(both, job) and both.cell.core.state.measured_mask == ON_TWO
    assert done(both, both.order("# nothing")) and not both.cell.core.state.measured_mask, "an earlier program's is forgotten"


def test_an_edge_while_a_source_has_stopped_the_path_moves_nothing_and_counts_at_its_resume(both: Probing) -> None:
    job = both.order(f"ptp joints {joints(90)} until=ch610", f"ptp joints {joints(5)}")
    for _ in range(3000):
        both.cell.cycle()
        if both.places()[0] > 15.0:
            break
    both.cell.settle(both.cell.give(Code.STOP))
    stopped = both.places()[0]
    both.change(PROBE)
    assert both.still(0.3) and both.cell.core.state.motion is Motion.STOPPED and job.open
    assert both.measured == pytest.approx(stopped * both.cell.dispatcher.axes[0].si, abs=1e-4), "it is measured all the same"
    both.cell.settle(both.cell.give(Code.RESUME))
    assert done(both, job) and both.at(5.0)
    assert max(q for _, q in both.seen) < (stopped + 1.0) * both.cell.dispatcher.axes[0].si
