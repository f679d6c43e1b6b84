"""Programs on belts of all three types: planner, core, drives and encoders in virtual time.  rho 3 Releases part 1, TO04 sections 14-16."""

import numpy as np
import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import get_bit
from hil_tests.lab.running.belt_run import SPEED
from hil_tests.lab.virtual.belt_bench import ALL, BeltBench
from motion.sync.cam import cam

LIMIT = (0.8, 0.8, 0.4, 3.2)  # of the axes, m/s and rad/s
SLOW = ("set path=20", "synchron B1", *["linear pose 100 110 50 0 0 0", "linear pose 100 100 50 0 0 0"] * 2)
AT = "synchron B2 at=60mm", "synchron B3 at=60mm"


@pytest.fixture
def bench() -> BeltBench:
    return BeltBench()


def smooth(bench: BeltBench) -> None:
    """No axis is faster than it may be, and no step is larger than a braking drive could follow."""
    steps = np.diff(np.array(bench.sets()), axis=0) / 0.004
    assert np.all(np.abs(steps) <= np.array(LIMIT) * 1.001)
    assert np.abs(np.diff(steps, axis=0)).max() < 0.15, "m/s from one cycle to the next"


def test_a_part_of_type_1_is_where_its_belt_is_and_the_program_goes_on_beside_it(bench: BeltBench) -> None:
    bench.started(1)
    job = bench.order(
        "synchron B1 at=60mm",
        "linear pose 150 150 50 0 0 0 belt=60mm",
        "linear pose 150 150 90 0 0 0 belt=60mm path=60",
        "synchron_end",
        "linear pose 100 100 50 0 0 0",
    )
    assert bench.finished(job).state is CommandState.DONE
    on = [s for s in bench.seen if abs(s.axes[1].set - 0.15) < 1e-9 and 0.052 < s.axes[2].set < 0.088]
    assert len(on) > 100
    off = [s.axes[0].set - 0.150 - (s.belt + 2 * 0.004 * SPEED - 0.060) for s in on]
    assert max(map(abs, off)) < 1.5e-4, "a set value acts two cycles after the count it was made of"
    assert bench.seen[-1].axes[0].set == pytest.approx(0.1, abs=1e-9)
    smooth(bench)


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_a_part_of_type_1_waits_for_its_belt_from_either_side(bench: BeltBench, turn: float) -> None:
    bench.started(1, turn * SPEED)
    job = bench.order(f"synchron B1 at={turn * 60}mm", "linear pose 150 150 50 0 0 0")
    assert bench.finished(job).state is CommandState.DONE
    first = next(s for s in bench.seen if abs(s.axes[0].set - 0.1) > 1e-6)
    assert 0.058 < turn * first.belt < 0.064


@pytest.mark.requirement("RHO-MOT-23", by="gateway.pure.cycle.belts:CoreBelts._follow")
def test_a_part_of_type_2_reaches_its_point_with_its_belt(bench: BeltBench) -> None:
    bench.started(2)
    job = bench.order(AT[0], "linear pose 200 150 50 0 0 0 belt=160mm pathaccel=3000", "synchron_end", "ptp joints 100 100 50 0")
    assert bench.finished(job).state is CommandState.DONE
    there = next(s.belt for s in bench.seen if s.axes[0].set > 0.2 - 1e-7)
    assert abs(there - 0.160) < 5 * 0.004 * SPEED, "5 interpolation cycles of belt path"
    assert all(abs(s.axes[0].set - 0.1) < 1e-9 for s in bench.seen if 0.0 < s.belt < 0.0595 and s.parts <= 1)
    smooth(bench)


@pytest.mark.requirement("RHO-MOT-27", by=("gateway.pure.cycle.belts:CoreBelts._follow", "gateway.pure.cycle.belts:CoreBelts.add"))
def test_a_part_of_type_3_follows_its_cam_exactly_in_all_coordinates(bench: BeltBench) -> None:
    curve = cam(0.1, 0.03, 0.05)
    bench.started(3)
    job = bench.order(AT[1], "linear pose 200 150 50 0 0 30 belt=160mm camin=30mm camout=50mm")
    assert bench.finished(job).state is CommandState.DONE
    inside = [s for s in bench.seen if 0.061 < s.belt < 0.159]
    assert len(inside) > 100
    for s in inside:
        share, _ = curve.at(s.belt - 0.060)
        assert s.axes[0].set == pytest.approx(0.1 + 0.1 * share, abs=1e-9)
        assert s.axes[1].set == pytest.approx(0.1 + 0.05 * share, abs=1e-9)
        assert s.axes[3].set == pytest.approx(np.radians(30.0) * share, abs=1e-9)
    smooth(bench)


def test_a_belt_that_stops_holds_its_robot_and_takes_it_along_again(bench: BeltBench) -> None:
    bench.started(3)
    job = bench.order(AT[1], "linear pose 200 150 50 0 0 0 belt=160mm")
    bench.until(lambda s: s.axes[0].set > 0.13)
    bench.drive(3, 0.0)
    bench.run(0.2)
    before = bench.set()
    bench.run(0.2)
    assert bench.set() == pytest.approx(before, abs=1e-9)
    bench.drive(3, SPEED)
    assert bench.finished(job).state is CommandState.DONE and bench.set()[0] == pytest.approx(200.0, abs=1e-6)


@pytest.mark.requirement("RHO-MOT-25", by="gateway.pure.cycle.belt_mover:BeltMover._belt_fault")
def test_a_belt_reversed_before_the_start_is_928_and_opens_ready(bench: BeltBench) -> None:
    bench.started(2)
    job = bench.order("synchron B2 at=4000mm", "linear pose 200 150 50 0 0 0 belt=4100mm")
    bench.until(lambda s: s.job == job.id)
    bench.run(0.1)
    assert get_bit(bench.core.outputs, 64)
    bench.drive(2, -SPEED)
    bench.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.BELT_FAULT)
    assert job.detail == "block 1, kinematic 1: wrong belt direction (rho 3 928)"
    bench.run(0.5)
    assert not get_bit(bench.core.outputs, 64) and get_bit(bench.core.outputs, 67) and bench.core.state.emergency


@pytest.mark.requirement(
    "RHO-MOT-24", by=("gateway.pure.cycle.belts:CoreBelts._follow", "gateway.pure.cycle.belt_mover:BeltMover._belt_fault")
)
def test_a_robot_more_than_five_cycles_of_belt_path_late_is_944_and_stands(bench: BeltBench) -> None:
    bench.started(2)
    job = bench.order(AT[0], "linear pose 200 150 50 0 0 0 belt=160mm pathaccel=200", "synchron_end", "ptp joints 100 100 50 0")
    bench.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.BELT_FAULT)
    assert job.detail == "block 1, kinematic 1: BS-tolerance too big (rho 3 944)"
    left = next(s.belt for s in bench.seen if s.belt_code == 944)
    assert 0.160 + 5 * 0.004 * SPEED <= left < 0.160 + 9 * 0.004 * SPEED, "beyond the point by the tolerance, no sooner"
    bench.run(0.5)
    assert 110.0 < bench.set()[0] < 190.0 and still(bench) and not get_bit(bench.core.outputs, 64)


def test_feed_hold_on_a_belt_of_type_2_is_944(bench: BeltBench) -> None:
    bench.started(2)
    job = bench.order(AT[0], "linear pose 200 150 50 0 0 0 belt=160mm")
    bench.until(lambda s: s.axes[0].set > 0.12)
    bench.permit(27, value=False)
    bench.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.BELT_FAULT) and "BS-tolerance too big (rho 3 944)" in job.detail


def test_feed_hold_on_a_belt_of_type_1_keeps_the_robot_on_it(bench: BeltBench) -> None:
    bench.started(1)
    job = bench.order(*SLOW)
    bench.until(lambda s: s.axes[1].set > 0.104 and s.axes[0].speed > 0.1)
    bench.permit(27, value=False)
    bench.run(0.6)
    place, y = bench.core.state.belt - bench.core.state.axes[0].set, bench.core.state.axes[1].set
    bench.run(0.3)
    assert bench.core.state.belt - bench.core.state.axes[0].set == pytest.approx(place, abs=2e-4)
    assert bench.core.state.axes[1].set == pytest.approx(y, abs=1e-9) and job.open
    bench.permit(27)
    bench.until(lambda s: s.axes[1].set > y + 1e-3)


def still(bench: BeltBench) -> bool:
    before = bench.set()
    bench.run(1.0)
    return bench.set() == pytest.approx(before, abs=1e-9)


def test_a_stop_brakes_path_and_belt_and_nothing_is_left_to_resume(bench: BeltBench) -> None:
    bench.started(1)
    job = bench.order(*SLOW)
    bench.until(lambda s: s.axes[1].set > 0.104 and s.axes[0].speed > 0.1)
    assert bench.settle(bench.give(Code.STOP, ALL)).state is CommandState.DONE
    bench.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.STOPPED_BY_SOURCE) and still(bench)
    assert bench.give(Code.RESUME, ALL).reason is Reason.NOTHING_TO_RESUME
    smooth(bench)


def test_the_planners_death_on_a_belt_ends_at_rest_beside_it(bench: BeltBench) -> None:
    bench.started(1)
    job = bench.order(*SLOW, *SLOW[2:] * 4)
    bench.until(lambda s: s.axes[1].set > 0.104 and s.axes[0].speed > 0.1)
    bench.planner.alive = False
    bench.planner.held.clear()
    bench.core.planner_lost()
    bench.finished(job)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.PLANNER_LOST) and still(bench)
    smooth(bench)


def test_drives_off_on_a_belt_forget_the_part_and_the_next_program_runs(bench: BeltBench) -> None:
    bench.started(1)
    job = bench.order(*SLOW)
    bench.until(lambda s: s.axes[1].set > 0.104 and s.axes[0].speed > 0.1)
    assert bench.settle(bench.give(Code.DISABLE, ALL)).state is CommandState.DONE
    bench.run(0.5)
    assert (job.state, job.reason) == (CommandState.ABORTED, Reason.DRIVES_OFF)
    assert bench.settle(bench.give(Code.ENABLE, ALL)).state is CommandState.DONE
    assert bench.finished(bench.order("ptp joints 100 100 50 0")).state is CommandState.DONE


def test_an_encoder_that_says_nothing_ends_the_part(bench: BeltBench) -> None:
    bench.started(1)
    job = bench.order(*SLOW)
    bench.until(lambda s: s.axes[1].set > 0.104 and s.axes[0].speed > 0.1)
    bench.emulated.all[0].silent = True
    bench.finished(job)
    assert job.reason is Reason.BELT_FAULT and "no telegram from the belt's encoder" in job.detail and still(bench)


def test_a_belt_that_would_carry_an_axis_out_of_its_travel_is_left_in_time(bench: BeltBench) -> None:
    bench.started(1, 0.5)
    job = bench.order("synchron B1", "linear pose 100 100 60 0 0 0", "linear pose 100 110 60 0 0 0 path=1")
    bench.finished(job)
    assert job.reason is Reason.BELT_FAULT and job.detail.endswith("axis X: the axis would leave its travel on the belt")
    assert 1.40 < bench.core.state.axes[0].set <= 1.5 and still(bench)


SAYS = {
    "line 7: block 2: kinematic 1: PTP not allowed for belt synchronous or sensor movement, belt B2 (rho 3 23)": [
        "ptp joints 110 100 50 0",
        AT[0],
        "ptp joints 200 100 50 0 belt=160mm",
    ],
    "beltdistance is zero, belt B3 (rho 3 89)": [
        AT[1],
        "linear pose 200 100 50 0 0 0 belt=160mm",
        "linear pose 250 100 50 0 0 0 belt=160mm",
    ],
    "Belt-sync. n.possible, belt B3 (rho 3 20)": [AT[1], "circular via pose 150 150 50 0 0 0 to pose 200 100 50 0 0 0 belt=160mm"],
    "belt nobody: Inadmiss. Belt-No; this cell has B1, B2, B3 (rho 3 93)": ["synchron nobody", "linear pose 200 100 50 0 0 0"],
    "wrong belt direction, belt B2 (rho 3 928)": [
        AT[0],
        "linear pose 200 100 50 0 0 0 belt=160mm",
        "linear pose 250 100 50 0 0 0 belt=100mm",
    ],
    "block 1, axis X: point not reachable": [AT[0], "linear pose 2000 100 50 0 0 0 belt=160mm"],
    "belt= is needed with a belt of type 2 (B2)": [AT[0], "linear pose 200 100 50 0 0 0"],
    "at= of the part, the belt value of the point before it is needed": ["synchron B2", "linear pose 200 100 50 0 0 0 belt=160mm"],
    "a place of the axes does not lie on belt B1": ["synchron B1", "ptp joints 200 100 50 0"],
    "until= has no place in a synchronous part": ["synchron B1", "linear pose 200 100 50 0 0 0 until=464"],
}


@pytest.mark.requirement("RHO-MOT-23", by="motion.sync.planned:BeltPlan.add")
def test_rules_of_belts_are_reported_before_anything_moves(bench: BeltBench) -> None:
    before = bench.set()
    for words, lines in SAYS.items():
        job = bench.settle(bench.order(*lines))
        assert (job.state, job.reason) == (CommandState.REFUSED, Reason.PROGRAM_FAULT), words
        assert words in job.detail, job.detail
        assert bench.set() == before


@pytest.mark.requirement("RHO-MOT-20", "RHO-MOT-21", by="gateway.pure.cycle.belts:CoreBelts.update")
def test_signals_376_and_399_act_on_counters_and_speeds(bench: BeltBench) -> None:
    bench.drive(1, SPEED)
    bench.run(0.4)
    assert bench.core.state.belt == pytest.approx(0.06, abs=2e-3) and bench.core.state.belt_speed == pytest.approx(SPEED, rel=0.05)
    bench.zero(1)
    assert bench.core.state.belt == pytest.approx(0.0, abs=2e-3)
    bench.permit(399)
    bench.run(0.1)
    assert bench.core.state.belt_speed == pytest.approx(0.05), "P508"
    bench.permit(399, value=False)
    bench.run(0.1)
    assert bench.core.state.belt_speed == pytest.approx(SPEED, rel=0.05)
