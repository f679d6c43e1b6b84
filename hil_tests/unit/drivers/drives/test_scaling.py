"""Increments and axis units, both directions; the booster's own limits."""

import math

import pytest

from drivers.drives.limits import LagMonitor, LagState, booster_limits, fits_int32, saturated_rpm
from drivers.drives.scaling import Scaling, ScalingError


def test_a_linear_axis_with_a_gear() -> None:
    axis = Scaling(16384, gear=5.0, feed_per_turn=0.010)
    assert axis.to_inc(0.010) == 5 * 16384
    assert axis.to_si(16384) == pytest.approx(0.002)
    assert axis.to_rpm(0.1) == pytest.approx(10 * 5 * 60)
    assert axis.speed_from_inc(5 * 16384) == pytest.approx(0.010)


def test_direction_mirrors_position_and_speed_alike() -> None:
    plus, minus = Scaling(4096, 2.0, 2 * math.pi, 1), Scaling(4096, 2.0, 2 * math.pi, -1)
    assert minus.to_inc(1.0) == -plus.to_inc(1.0)
    assert minus.to_rpm(1.0) == -plus.to_rpm(1.0)


@pytest.mark.parametrize("direction", [1, -1])
def test_round_trip_within_half_an_increment(direction: int) -> None:
    axis = Scaling(16384, 3.7, 0.005, direction).with_zero(-12345.5)
    assert axis.to_si(-12345.5) == 0.0
    for q in (-1.0, -0.01, 0.0, 1e-7, 0.3):
        assert abs(axis.to_si(axis.to_inc(q)) - q) <= 0.5001 / abs(axis.inc_per_unit)


def test_reach_is_what_four_bytes_can_name() -> None:
    for direction in (1, -1):
        axis = Scaling(16384, 10.0, 0.001, direction)
        low, high = axis.reach()
        assert low < 0 < high
        assert fits_int32(axis.to_inc(low))
        assert fits_int32(axis.to_inc(high))
        assert not (fits_int32(axis.to_inc(low - 1e-6)) or fits_int32(axis.to_inc(high + 1e-6)))


def test_numbers_no_axis_can_have_are_refused() -> None:
    for turn, direction in ((0, 1), (16384, 2)):
        with pytest.raises(ScalingError):
            Scaling(turn, direction=direction)
    for gear, feed, zero in ((0.0, 1.0, 0.0), (1.0, math.nan, 0.0), (1.0, 1.0, math.inf)):
        with pytest.raises(ScalingError):
            Scaling(gear=gear, feed_per_turn=feed, zero_inc=zero)


def test_speed_feed_forward_is_cut_to_int16_and_says_so() -> None:
    assert saturated_rpm(32767.0) == 32767
    assert saturated_rpm(-32767.4) == -32767
    assert saturated_rpm(40000.0) == 32767
    assert saturated_rpm(-1e9) == -32767
    assert saturated_rpm(math.nan) == 0


def test_lag_warns_with_hysteresis_and_a_trip_stays_until_cleared() -> None:
    lag = LagMonitor(warn=2.0, trip=5.0)
    assert [lag.check(value) for value in (1.9, -2.1, 1.9, 1.7)] == [LagState.OK, LagState.WARNING, LagState.WARNING, LagState.OK]
    assert [lag.check(value) for value in (-5.1, 0.0)] == [LagState.TRIPPED, LagState.TRIPPED]
    lag.clear()
    assert lag.check(0.0) is LagState.OK
    assert lag.check(math.nan) is LagState.TRIPPED


@pytest.mark.requirement("RHO-CAN-20", by="drivers.drives.limits:booster_limits")
def test_software_limits_for_the_drive_as_the_manual_computes_them() -> None:
    """P204 = 90, P207 = P208 = 0, GF = 4, zero offset 0, CPS = 16384: p_RMC_L = 16384 (L3724-3731)."""
    lower, upper = booster_limits(90.0, 90.0, 0.0, 0.0, 4.0, 0.0, 16384)
    moved = booster_limits(90.0, 90.0, 10.0, 5.0, 4.0, 30.0, 16384)
    assert (lower, upper) == (16384.0, 16384.0)
    assert moved == pytest.approx(((105 * 4 - 30) * 16384 / 360, (75 * 4 + 30) * 16384 / 360))
