"""Lines and circles: rho 3, Reis 3.1 (L300-338), VAL 3 movel and movec (L5374-5527)."""

import math

import numpy as np
import pytest

from hil_tests.lab.cells.motion_paths import point
from motion.geometry.frames import Pose
from motion.geometry.orientation import angle_between, rotation_by
from motion.paths.arc import arc, full_circle, helix
from motion.paths.base import Curve, PathError, norm, sub, way
from motion.paths.line import line

Z = (0.0, 0.0, 1.0)


def turned(x: float, y: float, z: float, *vector: float) -> Pose:
    return Pose((x, y, z), rotation_by((vector[0], vector[1], vector[2])))


def assert_derivatives(curve: Curve, shares: tuple[float, ...] = (0.02, 0.21, 0.5, 0.83, 0.98), rel: float = 1e-5) -> None:
    """Derivatives are those of the positions and orientations, by central differences."""
    h = 1e-4 * curve.length
    for share in shares:
        s = share * curve.length
        before, here, after = curve.at(s - h), curve.derivatives(s), curve.at(s + h)
        p1 = (np.array(after.position) - np.array(before.position)) / (2 * h)
        assert np.allclose(here.p1, p1, atol=rel * (1 + norm(here.p1)))
        first, last = curve.derivatives(s - h), curve.derivatives(s + h)
        for value, a, b in ((here.p2, first.p1, last.p1), (here.p3, first.p2, last.p2), (here.w1, first.w, last.w)):
            assert np.allclose(value, (np.array(b) - np.array(a)) / (2 * h), atol=2e-5 * (1 + norm(value)) / min(curve.length, 1.0))
        turn = angle_between(before.rotation, after.rotation) / (2 * h)
        assert turn == pytest.approx(norm(here.w), abs=1e-5 * (1 + norm(here.w)))


@pytest.mark.requirement("RSV-MOT-03", by="motion.paths.line:line")
def test_linear_stays_on_the_line_and_turns_steadily_by_the_least_rotation() -> None:
    start, end = turned(0.1, 0.2, 0.3, 0.0, 0.0, 0.2), turned(0.4, -0.2, 0.35, 0.5, -0.3, 1.0)
    curve = line(start, end)
    u = np.array(sub(end.position, start.position)) / curve.length
    whole = angle_between(start.rotation, end.rotation)
    for k in range(101):
        pose = curve.at(curve.length * k / 100)
        step = np.array(sub(pose.position, start.position))
        assert np.linalg.norm(step - u * (step @ u)) < 1e-12
        assert step @ u == pytest.approx(curve.length * k / 100, abs=1e-12)
        assert angle_between(start.rotation, pose.rotation) == pytest.approx(whole * k / 100, abs=1e-9)
    assert curve.at(curve.length).position == pytest.approx(end.position, abs=1e-12)
    assert_derivatives(curve)


def test_a_line_that_only_turns_runs_in_radians() -> None:
    curve = line(turned(1, 1, 1, 0, 0, 0), turned(1, 1, 1, 0, 0.8, 0))
    assert curve.length == pytest.approx(0.8)
    assert norm(curve.derivatives(0.3).w) == pytest.approx(1.0)
    assert norm(curve.derivatives(0.3).p1) == pytest.approx(0.0)


def test_lines_that_are_none_are_refused() -> None:
    with pytest.raises(PathError, match="same pose"):
        line(point(1, 2, 3), point(1, 2, 3))
    with pytest.raises(PathError, match="not a number"):
        line(point(1, 2, 3), point(1, math.nan, 3))
    with pytest.raises(PathError) as refused:
        line(point(0, 0, 0), turned(1, 0, 0, math.pi, 0, 0))
    assert refused.value.number == 553


@pytest.mark.requirement("RSV-MOT-05", by="motion.paths.arc:arc")
def test_two_arcs_each_through_its_auxiliary_point() -> None:
    """C start, D aux, E end and start of the next, F aux, G end."""
    c, d, e, f, g = (point(x, y, 0.1) for x, y in ((0, 0), (0.1, 0.1), (0.2, 0), (0.25, -0.08), (0.4, -0.1)))
    for start, via, end in ((c, d, e), (e, f, g)):
        curve = arc(start, via, end)
        assert curve.at(0.0).position == pytest.approx(start.position, abs=1e-12)
        assert curve.at(curve.length).position == pytest.approx(end.position, abs=1e-12)
        at_via = min(norm(sub(curve.at(curve.length * k / 4000).position, via.position)) for k in range(4001))
        assert at_via < curve.length / 4000
        assert {round(norm(sub(curve.at(curve.length * k / 50).position, curve.centre)), 9) for k in range(51)} == {round(curve.radius, 9)}
        assert way(curve, 0.0, curve.length) == pytest.approx(curve.length)
        assert_derivatives(curve)


def test_an_arc_follows_the_orientation_of_the_auxiliary_point_as_far_as_it_counts() -> None:
    start, via, end = point(0.1, 0, 0), turned(0, 0.1, 0, 0.4, 0, 0), turned(-0.1, 0, 0, 0, 0.3, 0)
    half = arc(start, via, end).length / 2
    assert angle_between(arc(start, via, end).at(half).rotation, via.rotation) < 1e-9
    free = arc(start, via, end, via_weight=0.0).at(half).rotation
    assert angle_between(free, rotation_by((0, 0.15, 0))) < 1e-9
    assert 0.05 < angle_between(arc(start, via, end, via_weight=0.5).at(half).rotation, via.rotation) < angle_between(free, via.rotation)
    for weight in (0.0, 0.5, 1.0):
        curve = arc(start, via, end, via_weight=weight)
        assert angle_between(curve.at(curve.length).rotation, end.rotation) < 1e-9
        assert_derivatives(curve)


def test_orientation_fixed_to_the_contour_turns_with_it() -> None:
    """ZIRK_BAHN_ORI, and the same as a special case of VAL 3's least rotation: all three points alike relative to the path."""
    poses = [turned(0.1 * math.cos(a), 0.1 * math.sin(a), 0, 0, 0, a) for a in (0.0, 1.4, 2.9)]
    moving = arc(poses[0], poses[1], poses[2], moving=True)
    least = arc(poses[0], poses[1], poses[2])
    for k in range(11):
        angle = 2.9 * k / 10
        for curve in (moving, least):
            assert angle_between(curve.at(curve.length * k / 10).rotation, rotation_by((0, 0, angle))) < 1e-9
    assert_derivatives(moving)
    still = arc(point(0.1, 0, 0), point(0, 0.1, 0), point(-0.1, 0, 0))
    assert angle_between(still.at(0.1).rotation, still.at(0.0).rotation) < 1e-12


def test_more_than_half_a_turn_of_the_tool_goes_on_the_same_way() -> None:
    poses = [turned(0.1 * math.cos(a), 0.1 * math.sin(a), 0, 0, 0, a) for a in (0.0, 2.5, 5.0)]
    curve = arc(*poses)
    for k in range(11):
        assert angle_between(curve.at(curve.length * k / 10).rotation, rotation_by((0, 0, 0.5 * k))) < 1e-9


@pytest.mark.parametrize(
    ("angles", "number"),
    [((0.0, 3.3, 4.0), 550), ((0.0, 0.5, 4.0), 551), ((0.0, 0.00001, 1.0), 552), ((0.0, 1.0, 2 * math.pi), 552)],
)
def test_degenerate_circles_carry_the_numbers_of_val3(angles: tuple[float, float, float], number: int) -> None:
    poses = [point(0.1 * math.cos(a), 0.1 * math.sin(a), 0.0) for a in angles]
    with pytest.raises(PathError) as refused:
        arc(*poses, halves=True)
    assert refused.value.number == number


def test_half_a_turn_of_the_tool_and_points_in_a_row_are_refused() -> None:
    with pytest.raises(PathError) as refused:
        arc(point(0.1, 0, 0), turned(0, 0.1, 0, math.pi, 0, 0), point(-0.1, 0, 0))
    assert refused.value.number == 553
    with pytest.raises(PathError, match="straight line"):
        arc(point(0, 0, 0), point(0.1, 0, 0), point(0.3, 0, 0))
    with pytest.raises(PathError):
        arc(point(0, 0, 0), point(math.nan, 0, 0), point(0.3, 0, 0))


def test_a_full_circle_comes_back_and_a_helix_rises() -> None:
    ring = full_circle(point(0.1, 0, 0), point(0, 0.1, 0), point(-0.1, 0, 0))
    assert ring.length == pytest.approx(2 * math.pi * 0.1)
    assert ring.at(ring.length).position == pytest.approx((0.1, 0, 0), abs=1e-12)
    assert ring.at(ring.length / 4).position == pytest.approx((0, 0.1, 0), abs=1e-12)
    back = full_circle(point(0.1, 0, 0), point(-0.1, 0, 0), point(0, 0.1, 0))
    assert back.at(back.length / 4).position == pytest.approx((0, -0.1, 0), abs=1e-12)
    screw = helix(turned(0.1, 0, 0, 0, 0, 0), (0, 0, 0), Z, -4 * math.pi, 0.05, moving=True)
    assert screw.at(screw.length).position == pytest.approx((0.1, 0, 0.05), abs=1e-12)
    assert screw.at(screw.length / 8).position == pytest.approx((0, -0.1, 0.05 / 8), abs=1e-12)
    assert norm(screw.derivatives(0.2).p1) == pytest.approx(1.0)
    assert_derivatives(screw)
    with pytest.raises(PathError):
        helix(point(0, 0, 0.2), (0, 0, 0), Z, 1.0, 0.0)
