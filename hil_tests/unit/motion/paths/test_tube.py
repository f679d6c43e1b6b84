"""Dense points run inside a tolerance tube about as fast as the curve they were taken from (motion.md E 4, goal 7)."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest

from hil_tests.lab.cells import motion_paths as lab
from hil_tests.lab.cells.motion_paths import contour_points, contour_radius, point
from hil_tests.unit.motion.paths.test_lines_and_arcs import turned
from hil_tests.unit.motion.paths.test_splines import assert_smooth
from motion.geometry.frames import Pose
from motion.geometry.orientation import angle_between
from motion.paths.base import PathError
from motion.paths.polynomial import Chain
from motion.paths.spline import fit, spline
from motion.paths.tube import Fitted, fitted
from motion.timing.jerk import jerk_limited
from motion.timing.limits import law_limits

UM = 1e-6
LIMITS = law_limits(lab.portal_limits(0.5, 5.0, 200.0))
ZIGZAG = [point(0.004 * k, 0.003 * (k % 7 == 3), 0) for k in range(15)]
SHAKEN = [  # 120 points 0.5 mm apart on a circle, 10 um beside it to both sides
    point((0.1 + 10 * UM * math.sin(37 * k * k)) * math.cos(k / 200), (0.1 + 10 * UM * math.sin(37 * k * k)) * math.sin(k / 200), 0)
    for k in range(120)
]


def in_tube(points: Sequence[Pose], tube: float | Sequence[float], tension: float = 1.0) -> Fitted:
    ones = [1.0] * len(points)
    tubes = [tube] * (len(points) - 1) if isinstance(tube, float) else list(tube)
    return fitted(points, tubes, [tension] * len(points), ones, ones)


def from_polyline(curve: Chain, points: Sequence[Pose], grid: int = 20) -> float:
    """Largest distance of the curve from the straight ways between the points, `grid` places an interval, m."""
    ends = np.array([p.position for p in points])
    starts, steps = ends[:-1], np.diff(ends, axis=0)
    squares = np.sum(steps * steps, axis=1)
    worst = 0.0
    for interval in curve.curves:
        for k in range(grid):
            way = np.array(interval.at(interval.length * k / grid).position) - starts
            share = np.clip(np.sum(way * steps, axis=1) / squares, 0.0, 1.0)
            worst = max(worst, float(np.min(np.linalg.norm(way - share[:, None] * steps, axis=1))))
    return worst


def seconds(curve: Chain) -> float:
    """Shortest jerk-limited time at 0.5 m/s, 5 m/s2, 200 m/s3 (goal 7)."""
    return jerk_limited(lab.chain_path(curve), LIMITS).duration


def assert_fitted(found: Fitted, points: Sequence[Pose], tube: float) -> None:
    assert from_polyline(found.curve, points) <= tube + 1e-12
    assert_smooth(found.curve)
    assert len(found.ends) == len(points) and found.ends[0] == 0.0 and found.ends[-1] == found.curve.length
    for s, pose in zip(found.ends, points, strict=True):
        assert math.dist(found.curve.at(s).position, pose.position) <= tube
    for s, pose in ((0.0, points[0]), (found.curve.length, points[-1])):
        assert found.curve.at(s).position == pytest.approx(pose.position, abs=1e-12)


@pytest.mark.parametrize(("count", "tube", "owed"), [(200, 50 * UM, 1.90), (60, 20 * UM, 1.2)])
def test_a_contour_in_a_tube_narrower_than_its_sagitta_is_run_as_fast_as_the_tube_allows(count: int, tube: float, owed: float) -> None:
    points = contour_points()[:count]
    found = in_tube(points, tube)
    assert_fitted(found, points, tube)
    assert seconds(found.curve) <= owed, "1.8966 s the true curve; meeting all points in 50 um: 8.6 s"


def test_a_tube_far_narrower_than_the_sagitta_makes_a_curve_that_hugs_the_chords() -> None:
    points = contour_points()[:30]
    assert_fitted(in_tube(points, 5 * UM), points, 5 * UM)


def test_in_a_tube_wider_than_the_sagitta_smooth_points_are_met() -> None:
    points = contour_points()
    curve = in_tube(points, 100 * UM).curve
    assert curve == spline(points)
    places = [curve.at(curve.length * k / 999).position for k in range(1000)]
    assert max(abs(math.hypot(x, y) - contour_radius(math.atan2(y, x))) for x, y, _ in places) < 5 * UM


def test_points_that_shake_inside_their_tube_do_not_shake_the_tool() -> None:
    found = in_tube(SHAKEN, 50 * UM)
    assert_fitted(found, SHAKEN, 50 * UM)
    assert seconds(found.curve) <= 0.25 < 0.3 * seconds(spline(SHAKEN))


def test_a_rough_row_takes_its_corners_as_wide_as_the_tube() -> None:
    for tube, owed in ((200 * UM, 0.52), (50 * UM, 0.68)):
        found = in_tube(ZIGZAG, tube)
        assert_fitted(found, ZIGZAG, tube)
        assert seconds(found.curve) <= owed, "by tension alone 1.9 s and 5.0 s"


def test_chords_without_tube_keep_their_points_and_each_chord_its_own_tube() -> None:
    tubes = [math.inf] * 6 + [50 * UM] * 4 + [200 * UM] * 4
    found = in_tube(ZIGZAG, tubes)
    for s, pose in list(zip(found.ends, ZIGZAG, strict=True))[:7]:
        assert found.curve.at(s).position == pytest.approx(pose.position, abs=1e-12)
    inner = [
        interval for start, interval in zip(found.curve.starts, found.curve.curves, strict=True) if found.ends[6] <= start < found.ends[10]
    ]
    assert from_polyline(Chain(tuple(inner), (), 0.0), ZIGZAG) <= 50 * UM
    assert in_tube(ZIGZAG, [math.inf] * 14).curve == spline(ZIGZAG)


def test_the_head_turns_as_along_the_free_spline() -> None:
    points = [turned(*pose.position, 0.02 * k, 0.3 * math.sin(0.4 * k), 0) for k, pose in enumerate(ZIGZAG)]
    found, free = in_tube(points, 50 * UM), spline(points)
    for (a, b), (c, d) in zip(pairwise(found.ends), pairwise((*free.starts, free.length)), strict=True):
        for share in (0.0, 0.25, 0.5, 0.75, 1.0):
            ours, theirs = found.curve.at(a + share * (b - a)).rotation, free.at(c + share * (d - c)).rotation
            assert angle_between(ours, theirs) < (1e-9 if share in (0.0, 1.0) else 0.01)


def test_programmed_tension_meets_the_points() -> None:
    assert in_tube(ZIGZAG, 50 * UM, 0.5).curve == fit(ZIGZAG, 50 * UM, 0.5)


def test_what_no_curve_can_keep_is_refused() -> None:
    with pytest.raises(PathError, match="no smooth curve"):
        in_tube(ZIGZAG, 1e-7)
    for bad in (0.0, -1.0, math.nan):
        with pytest.raises(PathError):
            in_tube(ZIGZAG, bad)
