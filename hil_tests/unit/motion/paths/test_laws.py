"""Laws along paths: TOPP against toppra, jerk-limited laws against limits, closed forms and the figures of motion.md C."""

import itertools
import math

import numpy as np
import pytest
import toppra.algorithm
import toppra.constraint

from hil_tests.lab.cells.motion_paths import chain_path, contour_points, point, portal_limits, portal_path, u_arm, u_portal
from motion.errors import MotionError
from motion.execution.ptp import nominal_duration, plan_ptp
from motion.paths.corner import corner
from motion.paths.joints import joint_line
from motion.paths.line import line
from motion.paths.spline import spline
from motion.timing import topp
from motion.timing.banded import Banded
from motion.timing.choice import Rounded, assembled, duration, fastest
from motion.timing.jerk import jerk_limited, shares
from motion.timing.law import Law
from motion.timing.limiter import ABORT_TEXT, AxisTooFast, Monitoring, limited
from motion.timing.limits import Cap, law_limits
from motion.timing.override_ramp import OverrideRamp


def test_topp_agrees_with_toppra_and_keeps_its_limits() -> None:
    chance, n = np.random.default_rng(2), 400
    at = np.linspace(0.0, 1.0, n + 1)
    for _ in range(12):
        curve = toppra.SplineInterpolator(np.linspace(0.0, 1.0, 5), chance.uniform(-2.0, 2.0, (5, 6)))
        speed, accel = chance.uniform(1.0, 3.0, 6), chance.uniform(3.0, 12.0, 6)
        first, second = curve.evald(at), curve.evaldd(at)
        ours = topp.solve(first, second, 1.0 / n, accel, topp.speed_limit(first, speed))
        kind = toppra.constraint.DiscretizationType.Interpolation
        limits = [
            toppra.constraint.JointVelocityConstraint(np.stack([-speed, speed], axis=1)),
            toppra.constraint.JointAccelerationConstraint(np.stack([-accel, accel], axis=1), discretization_scheme=kind),
        ]
        sdot = toppra.algorithm.TOPPRA(limits, curve, gridpoints=at).compute_parameterization(0.0, 0.0)[1]
        assert ours.duration == pytest.approx(float(np.sum(2.0 / n / (sdot[1:] + sdot[:-1]))), rel=5e-4)
        u = np.diff(ours.b) * n / 2
        load = np.abs(first[:-1] * u[:, None] + second[:-1] * ours.b[:-1, None]) / accel
        assert np.max(load) <= 1.0 + 1e-6
        assert np.max(np.abs(first) * np.sqrt(ours.b)[:, None] / speed) <= 1.0 + 1e-9


def test_topp_on_a_straight_line_is_the_trapezoid() -> None:
    n = 1000
    first, second = np.ones((n + 1, 1)), np.zeros((n + 1, 1))
    found = topp.solve(first, second, 1.0 / n, np.array([2.0]), topp.speed_limit(first, np.array([0.5])))
    assert found.duration == pytest.approx(1.0 / 0.5 + 0.5 / 2.0, rel=1e-3)
    free = topp.solve(first, second, 1.0 / n, np.array([2.0]), topp.speed_limit(first, np.array([9.0])))
    assert free.duration == pytest.approx(math.sqrt(2.0), rel=1e-3)
    with pytest.raises(MotionError, match="cannot be entered"):
        topp.solve(first, second, 1.0 / n, np.array([2.0]), topp.speed_limit(first, np.array([9.0])), b_start=4.1)


def test_five_banded_systems_are_solved() -> None:
    chance = np.random.default_rng(4)
    n = 40
    lower = np.tril(chance.normal(size=(n, n))) * (np.abs(np.subtract.outer(range(n), range(n))) <= 2) + 3 * np.eye(n)
    matrix = lower @ lower.T
    right = chance.normal(size=n)
    system = Banded(np.diag(matrix), np.diag(matrix, 1), np.diag(matrix, 2))
    assert np.allclose(system.solve(right), np.linalg.solve(matrix, right))


@pytest.mark.parametrize("length", [0.01, 0.1, 0.5])
def test_a_straight_line_takes_what_the_closed_form_says(length: float) -> None:
    limits = portal_limits()
    exact = nominal_duration(plan_ptp([0.0, 0.0, 0.0], [length, 0.3 * length, 0.0], limits))
    law = jerk_limited(joint_line([0.0, 0.0, 0.0], [length, 0.3 * length, 0.0]), law_limits(limits))
    assert exact * 0.985 <= law.duration <= exact * 1.01


def test_the_contour_is_done_in_1_90_s_inside_all_limits() -> None:
    """Goal 7; acceleration-limited 1.862 s, sequential LP 1.872 s (C.6)."""
    path, limits = chain_path(spline(contour_points())), law_limits(portal_limits(0.5, 5.0, 200.0))
    law = jerk_limited(path, limits)
    assert 1.80 < law.duration <= 1.90
    assert_kept(shares(path, limits, law))


def assert_kept(found: tuple[float, float, float]) -> None:
    speed, accel, jerk = found
    assert speed <= 1.0
    assert accel <= 1.02
    assert jerk <= 1.05


def test_the_u_cycle_of_the_arm_is_done_in_0_345_s_inside_all_limits() -> None:
    """Goal 6, R 25 mm (0.341 s in C.5)."""
    legs, corners, limits = u_arm(0.02499)
    path = assembled(legs, corners)
    law = jerk_limited(path, limits)
    assert law.duration <= 0.345
    assert_kept(shares(path, limits, law))


def test_a_corner_is_passed_only_where_that_is_faster() -> None:
    """motion.md 0.9; a nearly closed corner with a small range against a wide one."""
    points = [point(0, 0, 0), point(0.1, 0, 0), point(0.002, 0.005, 0), point(0.1, 0.05, 0)]
    lines = [line(a, b) for a, b in itertools.pairwise(points)]
    legs, limits = [portal_path(curve) for curve in lines], law_limits(portal_limits())
    stops = duration(fastest(legs, [None, None], limits)[0])
    r = 0.0005
    corners: list[Rounded | None] = [Rounded(r, r, portal_path(corner(a, b, r, r))) for a, b in itertools.pairwise(lines)]
    runs, passed = fastest(legs, corners, limits)
    assert len(runs) == 1 + passed.count(False)
    assert duration(runs) <= stops + 1e-12
    legs, round_ = u_portal(0.0124999)
    runs, passed = fastest(legs, round_, limits)
    assert passed == [True, True] and len(runs) == 1
    assert duration(runs) < 0.9 * duration(fastest(legs, [None, None], limits)[0])
    with pytest.raises(MotionError):
        fastest(legs, [None], limits)


@pytest.mark.requirement("RSV-MOT-04", by="motion.timing.jerk:jerk_limited")
def test_path_speed_100_mm_s_and_half_of_2000_mm_s2_are_ramps_and_a_constant_phase() -> None:
    """BAHN_GESCHW 100, BAHN_BESCHL 50, _RACC_MAX 2000 (L1712-1726)."""
    path = portal_path(line(point(0, 0, 0), point(0.12, 0.16, 0)))
    limits = law_limits(portal_limits(), way=(0.1, 0.5 * 2.0, 100.0))
    law = jerk_limited(path, limits)
    assert isinstance(law, Law)
    s = law.at(np.arange(0.0, law.duration + 1e-3, 1e-3))
    speed, accel = np.diff(s) / 1e-3, np.diff(s, 2) / 1e-6
    assert np.max(speed) == pytest.approx(0.1, rel=1e-3)
    assert np.max(np.abs(accel)) == pytest.approx(1.0, rel=0.02)
    assert np.mean(np.abs(speed - 0.1) < 1e-4) > 0.85
    assert law.duration == pytest.approx(0.2 / 0.1 + 0.1 / 1.0 + 1.0 / 100.0, rel=0.01)


@pytest.mark.requirement("RSV-MOT-07", by="motion.timing.limits:LawLimits.at")
@pytest.mark.parametrize(("flyby", "middle"), [(1.0, 0.150), (0.5, 0.075)])
def test_a_cap_gives_the_flyby_speed_in_the_middle_of_the_corner(flyby: float, middle: float) -> None:
    """v1 = 100, v2 = 200: 150 mm/s at the corner's middle, 75 at 50 % (L1792-1811); the block speeds outside it."""
    before, after = line(point(0.1, 0, 0), point(0.2, 0, 0)), line(point(0.2, 0, 0), point(0.2, 0.1, 0))
    legs = [portal_path(before), portal_path(after)]
    rounded = Rounded(0.03, 0.03, portal_path(corner(before, after, 0.03, 0.03)))
    path = assembled(legs, [rounded])
    slow = abs(float(path.at(np.array([0.1]), 1)[0, 0])) + 0.0
    rate = math.hypot(slow, float(path.at(np.array([0.1]), 1)[0, 1]))
    asked = flyby * (0.1 + 0.2) / 2
    caps = [
        Cap(0.0, 0.07, 0, 0.1),
        Cap(0.098, 0.102, 0, asked * slow / rate),
        Cap(0.07, 0.1, 0, max(asked, 0.1)),
        Cap(0.1, path.length, 1, 0.2),
    ]
    law = jerk_limited(path, law_limits(portal_limits(), caps=caps))
    t = np.arange(0.0, law.duration, 1e-3)
    s = law.at(t)
    q = path.at(s)[:, :2]
    speed = np.linalg.norm(np.diff(q, axis=0), axis=1) / 1e-3
    at = int(np.argmin(np.abs(s - 0.1)))
    assert speed[at] == pytest.approx(middle, rel=0.01)
    assert np.max(speed[s[:-1] < 0.065]) <= 0.1 * 1.001
    assert np.max(speed[s[:-1] > 0.135]) == pytest.approx(0.2, rel=0.01)


@pytest.mark.requirement("RSV-MOT-20", by="motion.timing.override_ramp:OverrideRamp.step")
def test_an_override_step_of_80_percent_takes_8_cycles() -> None:
    ramp = OverrideRamp(0.1, 0.2)
    seen = [ramp.step(1.0) for _ in range(10)]
    assert seen == pytest.approx([0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.0, 1.0])
    assert [ramp.step(0.95), ramp.step(0.0)] == pytest.approx([0.95, 0.85])
    for bad in (0.0, 1.1, math.nan):
        with pytest.raises(MotionError):
            OverrideRamp(bad)
    with pytest.raises(MotionError):
        ramp.step(1.2)


@pytest.mark.requirement("RHO-MOT-45", by="motion.timing.limiter:limited")
def test_40_where_15_are_allowed_becomes_three_clocks_of_13_33_of_all_axes() -> None:
    for automatic in (False, True):
        found = limited((40.0, -3.0, 6.0), (15.0, 15.0, 15.0), Monitoring.ALWAYS, automatic=automatic)
        assert found.count == 3
        assert found.step == pytest.approx((13.3333333, -1.0, 2.0))
        assert found.warning == "Interpolator Stop"
    assert limited((30.0,), (15.0,), Monitoring.ALWAYS, automatic=True).count == 2
    inside = limited((15.0, -15.0), (15.0, 15.0), Monitoring.ALWAYS, automatic=True)
    assert (inside.count, inside.step, inside.warning) == (1, (15.0, -15.0), "")


@pytest.mark.requirement("RHO-MOT-45", by="motion.timing.limiter:limited")
def test_the_axis_nearest_its_own_limit_decides_and_the_way_of_the_clocks_is_the_way_that_was_asked_for() -> None:
    steps, most = (6.0, -44.0, 10.0), (15.0, 20.0, 4.0)
    found = limited(steps, most, Monitoring.ALWAYS, automatic=True)
    assert found.count == 3, "axis 3 is 2.5 times beyond its limit, axis 2 only 2.2 times"
    assert [way * found.count for way in found.step] == pytest.approx(steps)
    assert all(abs(way) <= limit for way, limit in zip(found.step, most, strict=True))
    for asked, count in ((15.0, 1), (15.1, 2), (30.0, 2), (30.1, 3), (-30.1, 3), (45.0, 3)):
        clocks = limited((asked,), (15.0,), Monitoring.ALWAYS, automatic=True)
        assert (clocks.count, clocks.warning) == (count, "Interpolator Stop" if count > 1 else ""), asked
    for mode in (Monitoring.ABORT, Monitoring.MANUAL):
        assert limited((15.0, -20.0, 4.0), most, mode, automatic=False).count == 1, "at the limit is within it"
    with pytest.raises(AxisTooFast) as aborted:
        limited(steps, most, Monitoring.ABORT, automatic=True, last=True)
    assert aborted.value.axis == 1, "the first beyond its limit is named, the last part of a block not spared"
    for wrong in ((15.0, 20.0), (15.0, 20.0, 4.0, 4.0), (15.0, 20.0, 0.0), (15.0, -20.0, 4.0)):
        with pytest.raises(MotionError, match="limits > 0"):
            limited(steps, wrong, Monitoring.NONE, automatic=True)


@pytest.mark.requirement("RHO-MOT-45", by="motion.timing.limiter:limited")
def test_the_other_modes_of_p306() -> None:
    assert limited((40.0,), (15.0,), Monitoring.NONE, automatic=True).count == 1
    assert limited((40.0,), (15.0,), Monitoring.MANUAL, automatic=True).count == 1
    assert limited((40.0,), (15.0,), Monitoring.MANUAL, automatic=False).count == 3
    assert limited((40.0,), (15.0,), Monitoring.ALWAYS, automatic=True, last=True).count == 1
    assert limited((40.0,), (15.0,), Monitoring.ALWAYS, automatic=False, last=True).count == 3
    with pytest.raises(AxisTooFast, match=ABORT_TEXT) as aborted:
        limited((1.0, -40.0), (15.0, 15.0), Monitoring.ABORT, automatic=True)
    assert aborted.value.axis == 1
    with pytest.raises(MotionError):
        limited((1.0,), (0.0,), Monitoring.ALWAYS, automatic=True)


def test_the_place_at_one_time_is_that_among_many_to_the_last_bit() -> None:
    legs, corners, limits = u_arm(0.0125)
    law = jerk_limited(assembled(legs, corners), limits)
    times = np.concatenate([np.random.default_rng(1).uniform(-0.1, law.duration + 0.1, 200), [0.0, law.step, law.duration]])
    assert [law.place(float(t)) for t in times] == law.at(times).tolist()
    assert law.place(-1.0) == 0.0 and law.place(2.0 * law.duration) == pytest.approx(law.s[-1], abs=1e-12)
