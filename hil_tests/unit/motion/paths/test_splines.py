"""SPLINE of the Reis (L318, L2071-2081) with tension (L1838-1906) and orientation weight (L1908-1926); dense points in a tube."""

import math

import numpy as np
import pytest

from hil_tests.lab.cells.motion_paths import contour_points, contour_radius, point
from hil_tests.unit.motion.paths.test_lines_and_arcs import assert_derivatives, turned
from motion.geometry.frames import Pose
from motion.geometry.orientation import angle_between, rotation_by, slerp
from motion.paths.base import Curve, PathError, norm, sub
from motion.paths.polynomial import Chain, check_join
from motion.paths.spline import fit, spline

FIVE = [
    turned(0, 0, 0, 0, 0, 0),
    turned(0.1, 0.05, 0, 0.3, 0, 0),
    turned(0.2, -0.02, 0.05, 0.3, 0.4, 0),
    turned(0.3, 0.08, 0.02, 0, 0.4, -0.3),
    turned(0.35, 0.2, 0, 0.1, 0, 0),
]


def from_chords(curve: Chain, points: list[Pose]) -> float:
    """Largest distance of the curve from the polyline of its points."""
    worst = 0.0
    for interval, a, b in zip(curve.curves, points, points[1:], strict=False):
        u = np.array(sub(b.position, a.position)) / norm(sub(b.position, a.position))
        for k in range(41):
            step = np.array(sub(interval.at(interval.length * k / 40).position, a.position))
            worst = max(worst, float(np.linalg.norm(step - u * (step @ u))))
    return worst


def assert_smooth(curve: Chain) -> None:
    for number, (left, right) in enumerate(zip(curve.curves, curve.curves[1:], strict=False)):
        check_join(left, right, number)
        out, into = left.derivatives(left.length), right.derivatives(0.0)
        assert np.allclose(out.p2, into.p2, atol=1e-6)
        assert np.allclose(out.w1, into.w1, atol=1e-5)


@pytest.mark.requirement("RSV-MOT-10", by="motion.paths.spline:spline")
def test_the_spline_meets_all_points_and_orientations_and_has_no_corner() -> None:
    curve = spline(FIVE)
    for start, pose in zip((*curve.starts, curve.length), FIVE, strict=True):
        assert curve.at(start).position == pytest.approx(pose.position, abs=1e-12)
        assert angle_between(curve.at(start).rotation, pose.rotation) < 1e-9
    assert_smooth(curve)
    for interval in curve.curves:
        assert_derivatives(interval, rel=1e-4)


@pytest.mark.requirement("RSV-MOT-11", by="motion.paths.spline:spline")
def test_tension_0_50_100_swings_more_and_more_and_meets_the_points() -> None:
    swings = []
    for tension in (0.0, 0.5, 1.0):
        curve = spline(FIVE, tension)
        swings.append(from_chords(curve, FIVE))
        assert_smooth(curve)
        for start, pose in zip((*curve.starts, curve.length), FIVE, strict=True):
            assert curve.at(start).position == pytest.approx(pose.position, abs=1e-12)
    assert swings[0] < swings[1] < swings[2]
    assert swings[0] < 0.05 * swings[2]


def test_tension_of_one_point_acts_there_alone() -> None:
    full, part = spline(FIVE), spline(FIVE, [1.0, 1.0, 0.3, 1.0, 1.0])
    assert norm(sub(full.at(0.05).position, part.at(0.05).position)) < 1e-12
    middle = full.starts[1] + 0.5 * full.curves[1].length
    assert norm(sub(full.at(middle).position, part.at(middle).position)) > 1e-4


def swing_of_the_head(curve: Curve, a: Pose, b: Pose) -> float:
    return max(
        min(angle_between(curve.at(curve.length * k / 20).rotation, slerp(a.rotation, b.rotation, u / 100)) for u in range(101))
        for k in range(21)
    )


def test_orientation_tension_calms_the_head() -> None:
    loud, calm = spline(FIVE, 1.0, 1.0), spline(FIVE, 1.0, 0.0)
    assert swing_of_the_head(calm.curves[2], FIVE[2], FIVE[3]) < 0.2 * swing_of_the_head(loud.curves[2], FIVE[2], FIVE[3])
    assert_smooth(calm)


@pytest.mark.requirement("RSV-MOT-12", by="motion.paths.spline:spline")
def test_orientation_weight_0_at_p2_ignores_its_orientation_and_p3_is_met() -> None:
    curve = spline(FIVE, weight=[1.0, 1.0, 0.0, 1.0, 1.0])
    lengths = [interval.length for interval in curve.curves]
    average = slerp(FIVE[1].rotation, FIVE[3].rotation, lengths[1] / (lengths[1] + lengths[2]))
    assert angle_between(curve.at(curve.starts[2]).rotation, average) < 1e-9
    assert angle_between(curve.at(curve.starts[2]).rotation, FIVE[2].rotation) > 0.1
    assert curve.at(curve.starts[2]).position == pytest.approx(FIVE[2].position, abs=1e-12)
    for k in (1, 3):
        assert angle_between(curve.at(curve.starts[k]).rotation, FIVE[k].rotation) < 1e-9
    half = spline(FIVE, weight=[1.0, 1.0, 0.5, 1.0, 1.0])
    assert angle_between(half.at(curve.starts[2]).rotation, slerp(average, FIVE[2].rotation, 0.5)) < 1e-9
    with pytest.raises(PathError) as refused:
        spline(FIVE, weight=[1.0, 0.0, 0.5, 1.0, 1.0])
    assert refused.value.number == 903


def test_200_points_of_the_contour_stay_within_5_um_of_the_true_curve() -> None:
    curve = spline(contour_points())
    worst = 0.0
    for k in range(2001):
        x, y, _ = curve.at(curve.length * k / 2000).position
        worst = max(worst, abs(math.hypot(x, y) - contour_radius(math.atan2(y, x))))
    assert worst < 5e-6


def test_a_fit_stays_inside_its_tube_and_is_as_loose_as_it_may_be() -> None:
    points = [point(0.004 * k, 0.003 * (1 if k % 7 == 3 else 0), 0) for k in range(15)]
    assert from_chords(spline(points), points) > 50e-6
    for tolerance in (50e-6, 200e-6, 1e-2):
        curve = fit(points, tolerance)
        assert from_chords(curve, points) <= tolerance
        assert_smooth(curve)
    free = fit(points, 1e-2)
    assert free.at(0.03).position == spline(points).at(0.03).position
    for bad in (0.0, -1.0, math.nan):
        with pytest.raises(PathError):
            fit(points, bad)
    with pytest.raises(PathError, match="no smooth curve"):
        fit(points, 1e-7)


def test_points_that_make_no_spline_are_refused() -> None:
    with pytest.raises(PathError, match="two points"):
        spline(FIVE[:1])
    with pytest.raises(PathError) as same:
        spline([FIVE[0], FIVE[0], FIVE[1]])
    assert same.value.number == 620
    with pytest.raises(PathError) as half:
        spline([point(0, 0, 0), Pose((0.1, 0, 0), rotation_by((0, math.pi, 0)))])
    assert half.value.number == 553
    for bad in (-0.1, 1.1, [1.0]):
        with pytest.raises(PathError):
            spline(FIVE, bad)


def test_tolerance_and_tension_are_numbers_of_any_kind() -> None:
    points = contour_points(40)
    plain = fit(points, 1e-4, 1.0)
    for made in (fit(points, np.float32(1e-4), np.int64(1)), fit(points, np.full(40, np.float32(1e-4)), np.ones(41))):  # type: ignore[arg-type]  # NumPy numbers on purpose
        assert norm(sub(made.at(0.3 * made.length).position, plain.at(0.3 * plain.length).position)) < 1e-7
