"""Units, travel and speed limits: messages name axis, value, range and unit."""

import math

import pytest

from motion.errors import LimitError, MotionError
from motion.geometry.limits import AxisLimits, check_factor, check_speed, check_target, check_targets, limits_from
from motion.geometry.units import Kind, from_si, kind_of, to_si


def test_units_of_the_sources() -> None:
    assert to_si(1234.5, "mm") == pytest.approx(1.2345)
    assert to_si(12345, "0.1 mm") == pytest.approx(1.2345)
    assert to_si(180, "deg") == math.pi
    assert from_si(math.pi / 2, "0.1 deg") == pytest.approx(900)
    assert (kind_of("mm"), kind_of("deg")) == (Kind.LINEAR, Kind.ROTARY)


def test_unknown_unit_is_named() -> None:
    with pytest.raises(MotionError, match="'inch' is unknown; known are mm"):
        to_si(1, "inch")


def test_target_outside_names_axis_value_range_and_unit() -> None:
    axis = limits_from("A1", "mm", lower=-5, upper=2405, speed=1500, accel=3000, jerk=30000)
    with pytest.raises(LimitError, match=r"axis A1: target 2500 mm is outside -5 \.\. 2405 mm") as caught:
        check_target(axis, 2.5)
    assert caught.value.value == pytest.approx(2500.0)
    assert (caught.value.axis, caught.value.unit) == ("A1", "mm")


def test_both_ends_are_inside_one_step_beyond_is_not() -> None:
    axis = limits_from("A4", "deg", lower=-180, upper=180, speed=90, accel=500, jerk=5000)
    check_target(axis, math.radians(180))
    check_target(axis, math.radians(-180))
    for value in (math.radians(180) + 1e-8, math.radians(-180) - 1e-8, math.nan, math.inf):
        with pytest.raises(LimitError, match="axis A4"):
            check_target(axis, value)


def test_speed_is_checked_both_ways() -> None:
    axis = AxisLimits("A2", -1, 1, 2, 10, 100)
    check_speed(axis, -2.0)
    for value in (2.001, -2.001, math.nan):
        with pytest.raises(LimitError, match="axis A2: speed"):
            check_speed(axis, value)


def test_limits_that_contradict_themselves_are_refused() -> None:
    for lower, upper, speed, accel, jerk in (
        (1, 1, 1, 1, 1),
        (2, 1, 1, 1, 1),
        (0, math.nan, 1, 1, 1),
        (0, 1, 0, 1, 1),
        (0, 1, 1, -1, 1),
        (0, 1, 1, 1, math.inf),
    ):
        with pytest.raises(LimitError, match="axis A9"):
            AxisLimits("A9", lower, upper, speed, accel, jerk)


def test_number_of_targets_must_fit() -> None:
    with pytest.raises(MotionError, match="1 targets for 2 axes"):
        check_targets([AxisLimits("A", -1, 1, 1, 1, 1)] * 2, [0.0])


def test_factors_lie_above_0_and_not_above_1() -> None:
    check_factor("velocity factor", 1.0)
    check_factor("velocity factor", 0.0001)
    for value in (0.0, -0.1, 1.0001, math.nan):
        with pytest.raises(MotionError, match="velocity factor"):
            check_factor("velocity factor", value)
