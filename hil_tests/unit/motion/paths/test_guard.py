"""The last look at a set value: what is added to c so that differences of the set values keep the limits of all axes."""

import pytest

from motion.timing.guard import ACCEL_MOST, JERK_MOST, correction

H, ACCEL, JERK = 1e-3, 20.0, 1000.0


def row(jerk: float, slope: float, accel: float = 0.0) -> tuple[float, float, float, float, float, float, float]:
    """Positions whose last third difference is `jerk` and whose second one is `accel`, as shares of the limits."""
    second, third = accel * ACCEL * H * H, jerk * JERK * H**3
    one, two, three = 0.3, 0.2, 0.1 + second - third
    return 2 * one - two + second, slope, one, two, three, ACCEL, JERK


def test_nothing_is_added_while_all_axes_are_inside() -> None:
    assert correction([row(1.0, 2.0), row(-1.05, -0.5, 1.0)], 1.0, 0.0, H) == 0.0


def test_as_little_as_brings_the_jerk_back_is_added() -> None:
    assert correction([row(1.2, 2.0)], 1.0, 0.0, H) == pytest.approx(-(1.2 - JERK_MOST) * JERK / 2.0, rel=1e-6)
    assert correction([row(1.2, -2.0)], 1.0, 0.0, H) == pytest.approx((1.2 - JERK_MOST) * JERK / 2.0, rel=1e-6)


def test_as_little_as_brings_the_acceleration_back_is_added() -> None:
    assert correction([row(0.0, 0.5, -1.03)], 1.0, 0.0, H) == pytest.approx((1.03 - ACCEL_MOST) * ACCEL / 0.5 / H, rel=1e-6)


def test_where_no_c_serves_all_axes_the_worst_one_is_as_good_as_it_can_be() -> None:
    """One axis turns back at 1.3 of its jerk, whatever c is: the other one must not be spoiled for it."""
    c = correction([row(1.3, 1e-7), row(1.0, 2.0)], 1.0, 0.0, H)
    assert abs(1.0 + c * 2.0 / JERK) <= 1.4 * JERK_MOST
    opposed = correction([row(1.3, 2.0), row(1.3, -2.0)], 1.0, 0.0, H)
    assert abs(1.3 + opposed * 2.0 / JERK) <= 1.2 * JERK_MOST + 1e-9 and abs(1.3 - opposed * 2.0 / JERK) <= 1.2 * JERK_MOST + 1e-9


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_an_axis_that_bears_more_of_c_from_the_next_period_on_than_it_gains_now_asks_for_nothing(sense: float) -> None:
    """It brakes to turn back, at 0.07 m/s and 20 m/s2: c gains 0.07 of itself now and costs 0.06 in each period behind, on the way
    there and on the way back alike."""
    speed = 0.07
    assert correction([row(1.15, -sense * speed, 1.0)], sense, 0.0, H) == 0.0
    leaving = correction([row(1.15, sense * speed, 1.0)], sense, 0.0, H)
    assert leaving == pytest.approx(-sense * (1.15 - JERK_MOST) * JERK / speed, rel=1e-6)
    fast = correction([row(1.15, -sense * 10 * speed, 1.0)], sense, 0.0, H)
    assert fast == pytest.approx(sense * (1.15 - JERK_MOST) * JERK / (10 * speed), rel=1e-6)


@pytest.mark.parametrize("omega", [0.02, -0.02])
def test_an_axis_whose_acceleration_is_all_of_the_change_of_speed_gains_by_c(omega: float) -> None:
    """Where the path turns round its own acceleration, omega^2 q'', is nothing: no c stays to be borne, however large u is."""
    u, slope = 50.0, 0.2
    c = correction([row(1.13, -slope, -u * slope / ACCEL)], omega, u, H)
    assert c == pytest.approx((1.13 - JERK_MOST) * JERK / slope, rel=1e-6)
