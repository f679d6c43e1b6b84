"""Splines through points: SPLINE of the Reis (L318, L2071-2081) with tension, orientation tension and orientation weight; dense
points fitted inside a tolerance tube.

At full tension (1) the positions are the C2 cubic spline over chord lengths whose ends follow the first and last four points.
Tension t scales the first and second derivative at a point: the curve stays inside a tube round the chords that shrinks with t;
near 0 it is the chords with a very tight bend at each point (L1838-1850: 0 = near straight line with corner, 100 = full swing).
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from motion.geometry.frames import Pose, Rotation, Vector, product, rotate, transposed
from motion.geometry.orientation import angle_between, is_half_turn, rotation_vector, slerp
from motion.paths.base import PathError, add, dot, norm, scale, sub
from motion.paths.corner import control_points, hermite
from motion.paths.polynomial import Chain, Polynomial, Row
from motion.paths.turning import vector_change, vector_rate

LOOSEST = 0.02  # tension 0 still turns smoothly
NEAR_M, NEAR_RAD = 1e-6, 1e-9  # points closer than both are one point
TUBE_STEPS = 40  # halvings of the tension where the tube asks for it


def spline(
    points: Sequence[Pose],
    tension: Sequence[float] | float = 1.0,
    orientation_tension: Sequence[float] | float = 1.0,
    weight: Sequence[float] | float = 1.0,
) -> Chain:
    """Through all points.  tension, orientation_tension, weight: 0 .. 1 each, one for all or one for each point.

    PathError: fewer than two points, equal neighbours (620), weights below 1 at two neighbours (Reis path error 903).
    """
    if len(points) < 2:
        raise PathError(f"a spline needs two points, {len(points)} given")
    tensions, turnings, weights = (
        _shares(name, value, len(points))
        for name, value in (("tension", tension), ("orientation tension", orientation_tension), ("orientation weight", weight))
    )
    for number, (a, b) in enumerate(pairwise(weights)):
        if a < 1.0 and b < 1.0:
            raise PathError(f"orientation weight below 100 at two successive points, {number} and {number + 1}", 903, number)
    lengths = [_gap(a, b, number) for number, (a, b) in enumerate(pairwise(points))]
    rotations = _weighted([p.rotation for p in points], weights, lengths)
    slopes, bends = cubic_derivatives([p.position for p in points], lengths)
    rates = _rates(rotations, lengths)
    curves = [
        _interval(
            points[i],
            points[i + 1],
            rotations[i : i + 2],
            lengths[i],
            (scale(slopes[i], tensions[i]), scale(bends[i], tensions[i]), scale(rates[i], turnings[i])),
            (scale(slopes[i + 1], tensions[i + 1]), scale(bends[i + 1], tensions[i + 1]), scale(rates[i + 1], turnings[i + 1])),
        )
        for i in range(len(lengths))
    ]
    starts = [0.0]
    for length in lengths:
        starts.append(starts[-1] + length)
    return Chain(tuple(curves), tuple(starts[:-1]), starts[-1])


def fit(
    points: Sequence[Pose],
    tolerance: Sequence[float] | float,
    tension: Sequence[float] | float = 1.0,
    orientation_tension: Sequence[float] | float = 1.0,
    weight: Sequence[float] | float = 1.0,
) -> Chain:
    """A spline through dense points that nowhere leaves the chords by more than tolerance (m, one for all or one for each chord): where
    its swing would, the tension at both ends of that chord is lowered until the hull of the interval's control points lies inside the
    tube.  The rest: see spline()."""
    tubes = _each(tolerance, len(points) - 1)
    if len(tubes) != len(points) - 1 or not all(tube > 0 for tube in tubes):
        raise PathError(f"tolerance {tolerance} is not a length > 0")
    tensions = _shares("tension", tension, len(points))
    for _ in range(TUBE_STEPS):
        curve = spline(points, tensions, orientation_tension, weight)
        wide = [
            i
            for i, (interval, tube) in enumerate(zip(curve.curves, tubes, strict=True))
            if tube < math.inf and isinstance(interval, Polynomial) and swing(interval) > tube
        ]
        if not wide:
            return curve
        for end in {end for i in wide for end in (i, i + 1)}:
            tensions[end] *= 0.8
        if min(tensions) <= LOOSEST:
            break
    tube = tubes[wide[0]] * 1e3
    raise PathError(f"no smooth curve stays within {tube:.6g} mm of the straight way here: round the corner or stop", interval=wide[0])


def swing(interval: Polynomial) -> float:
    """How far at most an interval leaves its chord: the control points' distance from it, m."""
    return beside(interval, interval.origin.position, interval.at(interval.length).position)


def beside(interval: Polynomial, a: Vector, b: Vector) -> float:
    """How far at most an interval leaves the straight way from a to b: the control points' distance from it, m."""
    chord = sub(b, a)
    way = norm(chord)
    u = scale(chord, 1 / way) if way > 0.0 else chord
    steps = [sub(add(interval.origin.position, p), a) for p in control_points(interval.rows[:3], interval.length)]
    return max(norm(sub(step, scale(u, min(max(dot(step, u), 0.0), way)))) for step in steps)


def _each(value: Sequence[float] | float, count: int) -> list[float]:
    """Expand one number for all, of any numeric type (not every NumPy number is a float), or check one for each."""
    return [float(v) for v in value] if isinstance(value, Sequence | np.ndarray) else [float(value)] * count


def _shares(name: str, value: Sequence[float] | float, count: int) -> list[float]:
    shares = _each(value, count)
    if len(shares) != count or not all(0.0 <= v <= 1.0 for v in shares):
        raise PathError(f"{name} {value} is not {count} values of 0 .. 1")
    return shares if name == "orientation weight" else [max(v, LOOSEST) for v in shares]


def _gap(a: Pose, b: Pose, number: int) -> float:
    way = norm(sub(b.position, a.position))
    if is_half_turn(a.rotation, b.rotation):
        raise PathError(f"the orientation turns by exactly 180 deg between points {number} and {number + 1}", 553, number)
    length = way if way > NEAR_M else angle_between(a.rotation, b.rotation)
    if not length > NEAR_RAD:
        raise PathError(f"points {number} and {number + 1} of the spline are the same", 620, number)
    return length


def _weighted(rotations: list[Rotation], weights: list[float], lengths: list[float]) -> list[Rotation]:
    """Weight 1: as programmed; 0: the average of the neighbours, by way (L1908-1926).  The ends have one neighbour: as programmed."""
    result = list(rotations)
    for i in range(1, len(rotations) - 1):
        if weights[i] < 1.0:
            average = slerp(rotations[i - 1], rotations[i + 1], lengths[i - 1] / (lengths[i - 1] + lengths[i]))
            result[i] = slerp(average, rotations[i], weights[i])
    return result


def _rates(rotations: list[Rotation], lengths: list[float]) -> list[Vector]:
    """Rate of turning at each point, outside frame, rad per unit of s: the parabola through the neighbours."""
    chords = [
        scale(rotate(a, rotation_vector(product(transposed(a), b))), 1 / length)
        for (a, b), length in zip(pairwise(rotations), lengths, strict=True)
    ]
    inner = [
        scale(add(scale(left, after), scale(right, before)), 1 / (before + after))
        for (left, right), (before, after) in zip(pairwise(chords), pairwise(lengths), strict=True)
    ]
    return [chords[0], *inner, chords[-1]]


def _interval(
    a: Pose, b: Pose, turns: Sequence[Rotation], length: float, start: tuple[Vector, Vector, Vector], end: tuple[Vector, Vector, Vector]
) -> Polynomial:
    """From point a to point b with slope, bend and rate of turning at both; the rate does not change at the points."""
    rows: list[Row] = []
    step = sub(b.position, a.position)
    for k in range(3):
        rows.append(hermite(length, (0.0, start[0][k], start[1][k]), (step[k], end[0][k], end[1][k])))
    back = transposed(turns[0])
    rho = rotation_vector(product(back, turns[1]))
    first, last = rotate(back, start[2]), vector_rate(rho, rotate(back, end[2]))
    bend = vector_change(rho, last, (0.0, 0.0, 0.0))
    for k in range(3):
        rows.append(hermite(length, (0.0, first[k], 0.0), (rho[k], last[k], bend[k])))
    return Polynomial(Pose(a.position, turns[0]), (rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]), length)


def cubic_derivatives(points: Sequence[Vector], lengths: Sequence[float]) -> tuple[list[Vector], list[Vector]]:
    """First and second derivatives at the points of the C2 cubic spline over these lengths; end slopes from the polynomial through
    the first and last four points (fewer if there are fewer)."""
    count = len(points)
    chords = [scale(sub(b, a), 1 / h) for (a, b), h in zip(pairwise(points), lengths, strict=True)]
    first = _end_slope(points[:4], lengths[:3])
    last = scale(_end_slope(points[::-1][:4], lengths[::-1][:3]), -1.0)
    slopes = [first, *_solve(chords, lengths, first, last), last] if count > 2 else [first, last]
    bends = [_bend(chords[i], slopes[i], slopes[i + 1], lengths[i]) for i in range(count - 1)]
    final = scale(_bend(chords[-1], slopes[-1], slopes[-2], lengths[-1]), -1.0)
    return slopes, [*bends, final]


def _bend(chord: Vector, here: Vector, there: Vector, h: float) -> Vector:
    return scale(sub(scale(chord, 3.0), add(scale(here, 2.0), there)), 2 / h)


def _end_slope(points: Sequence[Vector], lengths: Sequence[float]) -> Vector:
    """Derivative at the first of up to four points of the polynomial through them (Lagrange)."""
    at = [0.0]
    for h in lengths[: len(points) - 1]:
        at.append(at[-1] + h)
    total: Vector = (0.0, 0.0, 0.0)
    for j, point in enumerate(points):
        if j == 0:
            weight = sum(-1 / at[k] for k in range(1, len(at)))
        else:
            weight = math.prod(-at[k] / (at[j] - at[k]) for k in range(1, len(at)) if k != j) / at[j]
        total = add(total, scale(point, weight))
    return total


def _solve(chords: Sequence[Vector], lengths: Sequence[float], first: Vector, last: Vector) -> list[Vector]:
    """Inner slopes of a clamped cubic spline: h1 m0 + 2 (h0 + h1) m1 + h0 m2 = 3 (h1 c0 + h0 c1); Thomas' algorithm."""
    count = len(chords) - 1
    upper: list[float] = []
    right: list[Vector] = []
    for i in range(count):
        h0, h1 = lengths[i], lengths[i + 1]
        value = scale(add(scale(chords[i], h1), scale(chords[i + 1], h0)), 3.0)
        pivot = 2 * (h0 + h1)
        before = first if i == 0 else right[-1]
        if i:
            pivot -= h1 * upper[-1]
        value = sub(value, scale(before, h1))
        if i == count - 1:
            value = sub(value, scale(last, h0))
        upper.append(h0 / pivot)
        right.append(scale(value, 1 / pivot))
    for i in range(count - 2, -1, -1):
        right[i] = sub(right[i], scale(right[i + 1], upper[i]))
    return right
