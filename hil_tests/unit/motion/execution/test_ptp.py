"""PTP: straight, all axes together, limits of each axis, time of ruckig (motion.md goal 15)."""

import math
import random

import pytest
import ruckig

from hil_tests.unit.motion.execution.measure import axes_limits, loaded, off_line, run_out, worst
from motion.errors import LimitError, MotionError
from motion.execution.ptp import nominal_duration, plan_ptp
from motion.geometry.limits import AxisLimits, limits_from

START, TARGET = [0.0, 0.5, -1.0, 0.2, 0.0, 3.0], [1.0, -1.5, -0.5, 0.2, 0.001, -3.0]


def phase_synchronised(start: list[float], target: list[float], limits: list[AxisLimits]) -> ruckig.Trajectory:
    """ruckig's own multi-axis answer."""
    count = len(limits)
    wish, answer = ruckig.InputParameter(count), ruckig.Trajectory(count)
    wish.synchronization = ruckig.Synchronization.Phase
    wish.current_position, wish.target_position = start, target
    wish.max_velocity = [axis.speed for axis in limits]
    wish.max_acceleration = [axis.accel for axis in limits]
    wish.max_jerk = [axis.jerk for axis in limits]
    ruckig.Ruckig(count).calculate(wish, answer)
    return answer


def test_all_axes_start_and_end_in_the_same_cycle() -> None:
    samples = run_out(loaded(plan_ptp(START, TARGET, axes_limits()), 6))
    assert samples[-1].q == pytest.approx(TARGET, abs=1e-9)
    first, before_last = samples[0].q, samples[-2].q
    for n in (0, 1, 2, 4, 5):
        assert first[n] != START[n], f"axis {n} starts late"
        assert abs(before_last[n] - TARGET[n]) > 0, f"axis {n} ends early"
    assert all(sample.q[3] == 0.2 for sample in samples)


def test_the_way_is_the_straight_joint_line_to_1e_9() -> None:
    samples = run_out(loaded(plan_ptp(START, TARGET, axes_limits()), 6))
    assert len(samples) > 100
    assert max(off_line(sample.q, START, TARGET) for sample in samples) <= 1e-9


def test_each_axis_keeps_its_limits_and_one_reaches_each() -> None:
    shares = worst([START, *(s.q for s in run_out(loaded(plan_ptp(START, TARGET, axes_limits()), 6, 0.001)))], axes_limits(), 0.001)
    assert all(share <= 1.0001 for share in shares)
    assert all(share > 0.99 for share in shares), "slower than it may be"


def test_duration_within_0_1_percent_of_ruckigs_phase_synchronised_result() -> None:
    """Where ruckig's result is the straight line; where it gives the line up, it is never beaten by more than rounding."""
    dice = random.Random(15)
    straight = 0
    for _ in range(2000):
        count = dice.randint(1, 6)
        speed, accel, jerk = (10 ** dice.uniform(-0.5, 0.5) * scale for scale in (1, 5, 50))
        alike = dice.random() < 0.5
        limits = [
            AxisLimits(f"A{n}", -10, 10, speed * share, accel * share, jerk * share)
            if alike
            else AxisLimits(f"A{n}", -10, 10, dice.uniform(0.5, 3), dice.uniform(2, 20), dice.uniform(20, 300))
            for n in range(count)
            for share in [dice.uniform(0.5, 2)]
        ]
        start, target = ([dice.uniform(-9, 9) for _ in limits] for _ in range(2))
        reference = phase_synchronised(start, target, limits)
        ours = nominal_duration(plan_ptp(start, target, limits))
        middle = reference.at_time(0.37 * reference.duration)[0]
        if off_line(middle, start, target) < 1e-6 and off_line(reference.at_time(0.1 * reference.duration)[0], start, target) < 1e-6:
            straight += 1
            assert ours == pytest.approx(reference.duration, rel=1e-3)
        else:
            assert ours >= reference.duration * (1 - 1e-9)
    assert straight > 1000


def test_factors_scale_speed_and_acceleration() -> None:
    limits = axes_limits(1)
    full, half = plan_ptp([0], [1], limits), plan_ptp([0], [1], limits, 0.5, 0.25)
    assert half.table[0] == pytest.approx(full.table[0] / 4)
    assert half.accel == pytest.approx(full.accel / 4)
    assert half.jerk == full.jerk
    long = nominal_duration(plan_ptp([-9], [9], limits, 0.1))
    assert long == pytest.approx(18 / 0.2 + 0.2 / 10 + 10 / 100, rel=0.001)


def test_a_target_outside_names_its_axis() -> None:
    limits = [
        limits_from("A1", "mm", lower=-5, upper=2405, speed=1500, accel=3000, jerk=30000),
        limits_from("A2", "deg", lower=-90, upper=90, speed=90, accel=300, jerk=3000),
    ]
    with pytest.raises(LimitError, match=r"axis A2: target 91 deg is outside -90 \.\. 90 deg"):
        plan_ptp([0, 0], [1.0, math.radians(91)], limits)
    with pytest.raises(LimitError, match="axis A1: target nan mm"):
        plan_ptp([0, 0], [math.nan, 0], limits)


def test_axes_outside_the_mask_are_neither_checked_nor_moved() -> None:
    piece = plan_ptp([0, 0, 0], [1, 99, -1], axes_limits(3), mask=0b101)
    assert piece.axes == (0, 2)
    assert piece.end() == pytest.approx((1, -1))


def test_a_move_of_no_length_is_done_at_once() -> None:
    piece = plan_ptp([1.0, 2.0], [1.0, 2.0], axes_limits(2), piece_id=9)
    assert nominal_duration(piece) == 0.0
    sample = loaded(piece, 2).step()
    assert (sample.done_id, sample.q, sample.qd, sample.state.name) == (9, (1.0, 2.0), (0.0, 0.0), "IDLE")


@pytest.mark.parametrize("way", [1e-9, 1e-6, 1e-3, 1e3, 1e4])
def test_moves_of_any_size(way: float) -> None:
    limits = axes_limits(2, speed=50, accel=500, jerk=50000, reach=2e5)
    piece = plan_ptp([1.0, 0.0], [1.0 + way, -way / 3], limits)
    samples = run_out(loaded(piece, 2), 600_000)
    assert samples[-1].q == pytest.approx([1.0 + way, -way / 3], abs=1e-9)
    if way < 1e3:
        shares = worst([(1.0, 0.0), *(s.q for s in samples)], limits, 0.004)
        assert shares.accel <= 1.001
        assert shares.jerk <= 1.001


def test_what_cannot_be_planned_raises() -> None:
    limits = axes_limits(2)
    here, there = [0.0, 0.0], [1.0, 1.0]
    with pytest.raises(MotionError):
        plan_ptp([0.0], there, limits)
    with pytest.raises(MotionError):
        plan_ptp([math.nan, 0.0], there, limits)
    for speed, accel, number, mask in ((0.0, 1.0, 1, 3), (1.0, 1.1, 1, 3), (1.0, 1.0, 0, 3), (1.0, 1.0, 1, 4), (1.0, 1.0, 1, 0)):
        with pytest.raises(MotionError):
            plan_ptp(here, there, limits, speed, accel, number, mask)
