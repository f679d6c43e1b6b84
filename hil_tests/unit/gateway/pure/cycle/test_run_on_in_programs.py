"""The modified MOVE UNTIL in the cycle (rho 3 part 2, L6756-6830): the axes run on behind the edge, without ramps."""

from collections.abc import Callable
from itertools import pairwise

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.jobs import Job
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.virtual.probing import CLOSE, PROBE, Probing
from hil_tests.lab.virtual.program_bench import LIMITS, joints


def alone(place: float) -> str:
    """Axis 1 moves, the others stay at 2."""
    return " ".join([f"{place:g}", *["2"] * (len(LIMITS) - 1)])


WAY = f"ptp joints {alone(90)} until=ch710"


class Running(Probing):
    """Beside it: set values of axis 1 in each cycle."""

    def __init__(self) -> None:
        super().__init__()
        self.sets: list[float] = []
        each: Callable[[], None] = self.cell.each

        def look() -> None:
            self.sets.append(self.cell.core.state.axes[0].set)
            each()

        self.cell.each = look

    def distance(self, value: float) -> None:
        """In units of axis 1, while whatever moves goes on."""
        self.cell.dispatcher.run_on(1, value * self.unit)
        self.cell._hand_over()

    def beyond(self, place: float) -> None:
        """Runs until axis 1 is beyond a place."""
        for _ in range(3000):
            if self.places()[0] > place:
                return
            self.cell.cycle()
        raise AssertionError(f"never beyond {place}: {self.places()}")

    @property
    def unit(self) -> float:
        return self.cell.dispatcher.axes[0].si

    def stepped(self) -> list[float]:
        """Ways of axis 1 in the cycles it moved in."""
        return [abs(b - a) for a, b in pairwise(self.sets) if b != a]


@pytest.fixture(scope="module")
def bench() -> Running:
    return Running()


@pytest.fixture
def both(bench: Running) -> Running:
    """At rest, near the beginning of the travel, the input 0."""
    bench.cell.permit(PROBE, value=False)
    bench.distance(0.0)
    if not bench.at(2.0):
        assert bench.finished(bench.order(f"ptp joints {joints(2)}")).state is CommandState.DONE
    bench.seen.clear()
    bench.sets.clear()
    return bench


def done(both: Running, job: Job) -> bool:
    return both.finished(job).state is CommandState.DONE


@pytest.mark.requirement("RHO-MOT-14", by="gateway.pure.cycle.measure_until:CoreMeasure.course")
@pytest.mark.requirement("RHO-MOT-14", by="gateway.pure.cycle.mover:Mover._edge")
def test_the_axes_end_so_far_behind_the_edge_without_a_ramp_and_the_next_block_begins_there(both: Running) -> None:
    job = both.order(WAY, f"ptp rel joints {' '.join(['0'] * len(LIMITS))}")
    both.beyond(25.0)
    both.distance(30.0)
    both.sets.clear()
    stamp = both.edge_at(40.0, ago=0.37)
    assert done(both, job)
    assert both.places()[0] * both.unit == pytest.approx(both.was(stamp) + 30.0 * both.unit, abs=CLOSE)
    steps = both.stepped()
    assert steps[-2] == pytest.approx(steps[-8], rel=1e-6) and steps[-2] > 0.9 * max(steps), "at the speed of the edge to the last cycle"
    assert both.measured == pytest.approx(both.was(stamp), abs=CLOSE), "@MPOS is the place of the edge"


def test_without_a_distance_the_axes_come_back_to_the_edge(both: Running) -> None:
    job = both.order(WAY)
    both.edge_at(20.0, ago=0.2)
    assert done(both, job)
    assert both.places()[0] * both.unit == pytest.approx(both.measured, abs=1e-9)
    assert max(both.sets) > both.sets[-1]


def test_without_an_edge_the_block_runs_to_its_end(both: Running) -> None:
    both.distance(5.0)
    job = both.order(f"ptp joints {joints(12)} until=ch710 error=NONE", f"ptp joints {joints(40)}", "label NONE")
    assert done(both, job) and both.at(12.0)


def test_a_stop_on_the_way_rests_at_once_and_the_rest_of_the_way_follows(both: Running) -> None:
    both.distance(30.0)
    job = both.order(WAY)
    both.edge_at(20.0)
    both.cell.run(0.05)
    before = both.places()[0]
    stop = both.cell.give(Code.STOP)
    both.cell.settle(stop)
    assert both.still(0.2) and both.cell.core.state.motion is Motion.STOPPED and job.open
    assert 20.0 < before <= both.places()[0] < before + 3.0, "at once"
    both.cell.settle(both.cell.give(Code.RESUME))
    assert done(both, job)
    assert both.sets[-1] == pytest.approx(both.measured + 30.0 * both.unit, abs=1e-9)


def test_a_rest_of_the_way_that_is_given_up_stays_behind(both: Running) -> None:
    both.distance(30.0)
    job = both.order(WAY)
    both.edge_at(20.0)
    both.cell.run(0.05)
    both.cell.settle(both.cell.give(Code.STOP))
    stood = both.sets[-1]
    both.cell.settle(both.cell.give(Code.ABANDON))
    assert both.finished(job).state is CommandState.ABORTED and both.sets[-1] == stood
    assert done(both, both.order(f"ptp joints {joints(4)}")) and both.at(4.0)


def test_a_way_out_of_the_travel_is_not_begun_and_names_the_axis(both: Running) -> None:
    both.distance(1e5)
    job = both.order(WAY, f"ptp joints {joints(5)}")
    both.edge_at(20.0)
    assert both.finished(job).state is CommandState.ABORTED and job.reason is Reason.TARGET_LIMIT
    assert both.cell.dispatcher.axes[0].name in job.detail
    assert 20.0 < both.places()[0] < 89.9 and both.still(0.2), "stopped on the path"


def test_a_share_of_the_speed_acts_on_the_move_under_way_alone(both: Running) -> None:
    job = both.order(f"ptp joints {alone(90)}", velocity=0.2)
    both.beyond(40.0)
    fast = both.stepped()[-1]
    both.cell.dispatcher.slow_move(job, 0.2)
    both.cell._hand_over()
    both.beyond(60.0)
    assert both.stepped()[-1] == pytest.approx(0.2 * fast, rel=0.02)
    assert done(both, job)
    both.sets.clear()
    both.cell.dispatcher.slow_move(job, 0.1)  # too late
    assert done(both, both.order(f"ptp joints {joints(2)}", velocity=0.2))
    assert max(both.stepped()) > 0.9 * fast
