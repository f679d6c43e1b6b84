"""Rounded corners: rho 3 6.1 (L1792-1811), Reis BAHN_RADIUS and BAHN_DISTANZ (L1772-1788), VAL 3 leave and reach (L5416-5481)."""

import itertools
import math
import random

import numpy as np
import pytest

from hil_tests.lab.cells.motion_paths import point
from hil_tests.unit.motion.paths.test_lines_and_arcs import assert_derivatives, turned
from motion.geometry.orientation import angle_between
from motion.paths.arc import arc
from motion.paths.base import PathError, dot, norm, sub
from motion.paths.corner import MISS, Corner, clipped, corner, deviation, inside_sphere, miss, radius_for
from motion.paths.line import line
from motion.paths.polynomial import Polynomial, check_join, part

RIGHT_ANGLE = (line(point(0, 0, 0), point(0.3, 0, 0)), line(point(0.3, 0, 0), point(0.3, 0.2, 0)))


def bend(interior: float, a: float = 0.3, b: float = 0.3) -> tuple[Polynomial, Polynomial]:
    """Two lines that meet in the origin at this interior angle (rad)."""
    end = point(-b * math.cos(interior), b * math.sin(interior), 0)
    return line(point(-a, 0, 0), point(0, 0, 0)), line(point(0, 0, 0), end)


@pytest.mark.requirement("RHO-MOT-02", "RSV-MOT-08", by="motion.paths.corner:corner")
def test_path_leaves_the_corner_r_before_and_rejoins_r_after_tangentially_and_stays_in_the_sphere() -> None:
    before, after = RIGHT_ANGLE
    for r in (0.02, 0.01, 0.2):
        curve = corner(before, after, r, r)
        assert curve.at(0.0).position == pytest.approx((0.3 - r, 0, 0), abs=1e-12)
        assert curve.at(curve.length).position == pytest.approx((0.3, r, 0), abs=1e-12)
        if r < 0.2:
            check_join(part(before, 0.0, 0.3 - r), curve)
            check_join(curve, part(after, r, 0.2))
        for k in range(101):
            assert norm(sub(curve.at(curve.length * k / 100).position, (0.3, 0, 0))) <= r + 1e-12
        assert isinstance(curve, Corner)
        assert inside_sphere(curve, (0.3, 0, 0)) <= r + 1e-12
        for end in (0.0, curve.length):
            assert norm(curve.derivatives(end).p1) == pytest.approx(1.0)
            assert norm(curve.derivatives(end).p2) < 1e-6
        assert_derivatives(curve)


@pytest.mark.requirement("RSV-MOT-09", by="motion.paths.corner:radius_for")
def test_a_corner_asked_to_be_missed_by_3_mm_is_missed_by_3_mm() -> None:
    dice = random.Random(9)
    for _ in range(60):
        before, after = bend(math.radians(dice.uniform(5, 175)))
        u1, u2 = before.derivatives(0.0).p1, after.derivatives(0.0).p1
        r = radius_for(0.003, u1, u2)
        if r <= 0.3:
            assert deviation(corner(before, after, r, r), (0, 0, 0)) == pytest.approx(0.003, abs=1e-9)
        else:
            assert miss(u1, u2, 0.3, 0.3) < 0.003


def test_the_bound_holds_for_unequal_leave_and_reach_and_the_curve_stays_in_plane_and_hull() -> None:
    dice = random.Random(10)
    for _ in range(60):
        before, after = bend(math.radians(dice.uniform(5, 175)), 0.5, 0.5)
        leave, reach = dice.uniform(0.01, 0.5), dice.uniform(0.01, 0.5)
        curve = corner(before, after, leave, reach)
        u1, u2 = before.derivatives(0.0).p1, after.derivatives(0.0).p1
        assert deviation(curve, (0, 0, 0)) <= miss(u1, u2, leave, reach) + 1e-12
        check_join(part(before, 0.0, 0.5 - leave), curve)
        check_join(curve, part(after, reach, 0.5))
        for k in range(41):
            x, y, z = curve.at(curve.length * k / 40).position
            assert abs(z) < 1e-12
            assert max(dot((x, y, z), (-u1[0], -u1[1], 0)), 0) <= leave + 1e-12 or dot((x, y, z), u2) <= reach + 1e-12
        assert_derivatives(curve)


def test_the_orientation_turns_smoothly_from_one_rate_to_the_other() -> None:
    first = line(turned(0, 0, 0, 0, 0, 0), turned(0.3, 0, 0, 0.5, 0.2, 0))
    second = line(turned(0.3, 0, 0, 0.5, 0.2, 0), turned(0.3, 0.3, 0, 0.5, -0.4, 0.7))
    curve = corner(first, second, 0.08, 0.12)
    for mine, theirs in ((curve.derivatives(0.0), first.derivatives(0.22)), (curve.derivatives(curve.length), second.derivatives(0.12))):
        assert np.allclose(mine.w, theirs.w, atol=1e-9)
        assert norm(mine.w1) < 1e-6
    assert angle_between(curve.at(0.0).rotation, first.at(0.22).rotation) < 1e-12
    assert_derivatives(curve)


def test_corners_between_lines_and_arcs_join_both_with_equal_bend() -> None:
    before = line(point(-0.3, 0, 0), turned(0, 0, 0, 0.3, 0, 0))
    after = arc(turned(0, 0, 0, 0.3, 0, 0), point(0.1, 0.1, 0), point(0.2, 0, 0))
    curve = corner(before, after, 0.05, 0.07)
    assert isinstance(curve, Polynomial)
    for mine, theirs in (
        (curve.derivatives(0.0), before.derivatives(before.length - 0.05)),
        (curve.derivatives(curve.length), after.derivatives(0.07)),
    ):
        for a, b in ((mine.p1, theirs.p1), (mine.p2, theirs.p2), (mine.w, theirs.w), (mine.w1, theirs.w1)):
            assert np.allclose(a, b, atol=1e-6)
    assert deviation(curve, (0, 0, 0)) < 0.05
    assert_derivatives(curve)


@pytest.mark.requirement("RHO-MOT-03", by="motion.paths.corner:clipped")
def test_points_10_mm_apart_with_r_20_mm_get_the_largest_range_that_fits() -> None:
    assert clipped(0.020, 0.010, 0.5) == pytest.approx(0.005)
    assert clipped(0.004, 0.010, 0.5) == pytest.approx(0.004)
    assert clipped(0.020, 0.010, 0.4) == pytest.approx(0.004)
    points = [point(0.01 * k, 0.003 * (k % 2), 0) for k in range(4)]
    lines = [line(a, b) for a, b in itertools.pairwise(points)]
    r = [clipped(0.02, curve.length, 0.5) for curve in lines]
    first, second = (corner(a, b, r[0], r[0]) for a, b in itertools.pairwise(lines))
    assert norm(sub(first.at(first.length).position, second.at(0.0).position)) < 1e-12
    check_join(first, second)
    for share, wanted in ((1.0, 0.01), (0.0, 0.01), (0.5, -0.01)):
        with pytest.raises(PathError):
            clipped(wanted, 0.1, share)


def test_what_cannot_be_rounded_is_refused() -> None:
    before, after = RIGHT_ANGLE
    with pytest.raises(PathError, match="do not fit"):
        corner(before, after, 0.31, 0.1)
    with pytest.raises(PathError, match="do not meet"):
        corner(before, line(point(0, 0, 0), point(0, 1, 0)), 0.1, 0.1)
    with pytest.raises(PathError, match="the path reverses here"):
        corner(before, line(point(0.3, 0, 0), point(0, 0, 0)), 0.1, 0.1)
    with pytest.raises(PathError) as refused:
        corner(line(turned(0, 0, 0, 0, 0, 0), turned(0, 0, 0, 0, 0, 0.5)), line(turned(0, 0, 0, 0, 0, 0.5), point(1, 0, 0)), 0.1, 0.1)
    assert refused.value.number == 621


def test_the_share_of_the_bend_is_three_sixteenths() -> None:
    assert MISS == 3 / 16
    assert miss((1, 0, 0), (0, 1, 0), 1.0, 1.0) == pytest.approx(0.265, abs=2e-4)
