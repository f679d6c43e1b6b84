"""Dense points fitted inside a tolerance tube: of all curves that nowhere leave the chords by more than the tube, one that bends
little (motion.md E 4: "spline fit inside a tube for dense points").

A spline through the points leaves the chords by their sagitta.  Where the tube is wider than that and the points are smooth, it is the
curve.  Where it leaves the tube, or bends far more than the tube asks for because the points are rough, the knots leave the points: the
sum of squared bends plus pulls back to the polyline is least, and the pull of each knot is adapted until it uses most of its tube or is
not needed (Reinsch's smoothing spline with a weight for each knot).  Intervals that still leave the tube are halved, so that knots gather
where the way is rough.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from motion.geometry.frames import Pose, Vector
from motion.paths.base import PathError, add, dot, norm, scale, sub
from motion.paths.polynomial import Chain, Polynomial
from motion.paths.spline import NEAR_M, beside, fit, spline

USED = 0.9  # share of the tube a knot may use; the rest is for the curve between knots
PULLS = 25  # adaptations of the pulls, each round
STRONGER, WEAKER = 30.0, 0.1  # largest change of a pull at once
WEAKEST, HELD = 1e-7, 1e12  # of the stiffness at a knot: nearly free; does not move
FINEST = 7  # halvings of a chord
ROUGH = 2.0  # the curve leaves the points when meeting them needs this many times the bend


@dataclass(frozen=True, slots=True)
class Fitted:
    """A curve and its s at (or, in a tube, nearest to) each of the points, first and last included."""

    curve: Chain
    ends: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Knot:
    """On chord number `chord` at `share` of it; `room`: how far the curve may be from `place` there, m, 0: not at all."""

    chord: int
    share: float
    place: Vector
    room: float


def fitted(
    points: Sequence[Pose],
    tubes: Sequence[float],
    tension: Sequence[float],
    orientation_tension: Sequence[float],
    weight: Sequence[float],
) -> Fitted:
    """Return the curve through the points or past them.  tubes: m, one for each chord, inf: free; the others: one for each point, see
    spline().

    The ends of a free chord are met.  A row with a tension below 1 meets all points and is pulled to its chords: see fit().  PathError:
    see spline() and fit().
    """
    if len(tubes) != len(points) - 1 or not all(tube > 0 for tube in tubes):
        raise PathError(f"tolerance {tubes} is not a length > 0 for each chord")
    free = spline(points, tension, orientation_tension, weight)
    met = Fitted(free, (*free.starts, free.length))
    if min(tubes) == math.inf:
        return met
    ways = [(a.position, b.position) for a, b in pairwise(points)]
    inside = all(tube == math.inf or beside(_polynomial(free, i), *ways[i]) <= tube for i, tube in enumerate(tubes))
    found = _smooth(points, tubes, free, orientation_tension) if min(tension) == 1.0 else None
    if inside:
        return met if found is None or _bend(free) <= ROUGH * _bend(found.curve) else found
    if found is not None:
        return found
    curve = fit(points, tubes, tension, orientation_tension, weight)
    return Fitted(curve, (*curve.starts, curve.length))


def _bend(curve: Chain) -> float:
    """Integral of the square of p'', which is linear over each interval, 1/m."""
    total = 0.0
    for interval in curve.curves:
        a, b = interval.derivatives(0.0).p2, interval.derivatives(interval.length).p2
        total += interval.length / 3 * (dot(a, a) + dot(a, b) + dot(b, b))
    return total


def _polynomial(curve: Chain, number: int) -> Polynomial:
    interval = curve.curves[number]
    if not isinstance(interval, Polynomial):
        raise PathError(f"interval {number} of a spline is not a polynomial")
    return interval


def _smooth(points: Sequence[Pose], tubes: Sequence[float], free: Chain, turning: Sequence[float]) -> Fitted | None:
    """Return None where no spline exists or its knots would be closer than 2 ** -FINEST of a chord."""
    knots = _knots(points, tubes)
    for _ in range(FINEST):
        lengths = [_between(a, b, free) for a, b in pairwise(knots)]
        places = _places(knots, lengths)
        poses = [Pose(place, _pose(knot, free).rotation) for knot, place in zip(knots, places, strict=True)]
        turnings = [turning[knot.chord] if knot.share == 0.0 else 1.0 for knot in knots]
        turnings[-1] = turning[-1]
        try:
            curve = spline(poses, 1.0, turnings)
        except PathError:
            return None
        wide = {
            i
            for i, knot in enumerate(knots[:-1])
            if beside(_polynomial(curve, i), points[knot.chord].position, points[knot.chord + 1].position) > tubes[knot.chord]
        }
        if not wide:
            starts = [start for start, knot in zip(curve.starts, knots[:-1], strict=True) if knot.share == 0.0]
            return Fitted(curve, (*starts, curve.length))
        knots = _halved(knots, wide, points, tubes)
    return None


def _knots(points: Sequence[Pose], tubes: Sequence[float]) -> list[Knot]:
    """The points, and the middle of each chord with a tube."""
    rooms = [0.0, *(min(a, b) if max(a, b) < math.inf else 0.0 for a, b in pairwise(tubes)), 0.0]
    for i, (a, b) in enumerate(pairwise(points)):
        if norm(sub(b.position, a.position)) <= NEAR_M:
            rooms[i] = rooms[i + 1] = 0.0  # the tool turns in place: there it has to be
    knots = []
    for i, (a, b) in enumerate(pairwise(points)):
        knots.append(Knot(i, 0.0, a.position, USED * rooms[i]))
        if tubes[i] < math.inf:
            knots.append(_inserted(i, 0.5, a, b, tubes[i]))
    last = len(points) - 2
    return [*knots, Knot(last, 1.0, points[-1].position, 0.0)]


def _inserted(chord: int, share: float, a: Pose, b: Pose, tube: float) -> Knot:
    return Knot(chord, share, add(a.position, scale(sub(b.position, a.position), share)), USED * tube)


def _halved(knots: Sequence[Knot], wide: set[int], points: Sequence[Pose], tubes: Sequence[float]) -> list[Knot]:
    result = []
    for i, knot in enumerate(knots):
        result.append(knot)
        if i in wide:
            end = knots[i + 1].share or 1.0
            n = knot.chord
            result.append(_inserted(n, 0.5 * (knot.share + end), points[n], points[n + 1], tubes[n]))
    return result


def _between(a: Knot, b: Knot, free: Chain) -> float:
    return ((b.share or 1.0) - a.share) * free.curves[a.chord].length


def _pose(knot: Knot, free: Chain) -> Pose:
    interval = free.curves[knot.chord]
    return interval.at(knot.share * interval.length)


def _places(knots: Sequence[Knot], lengths: Sequence[float]) -> list[Vector]:
    """Where the knots are when the bend is least and each lies about within its room."""
    stiff, first, second, loads = _stiffness(knots, lengths)
    pulls = [s if knot.room else HELD * s for s, knot in zip(stiff, knots, strict=True)]
    for _ in range(PULLS):
        shifts = _solved([s + pull for s, pull in zip(stiff, pulls, strict=True)], first, second, loads)
        for i, knot in enumerate(knots):
            if knot.room:
                used = math.hypot(shifts[0][i], shifts[1][i], shifts[2][i]) / knot.room
                pulls[i] = max(pulls[i] * min(max(used, WEAKER), STRONGER), WEAKEST * stiff[i])
    return [add(knot.place, (x, y, z)) if knot.room else knot.place for knot, x, y, z in zip(knots, *shifts, strict=True)]


def _stiffness(knots: Sequence[Knot], lengths: Sequence[float]) -> tuple[list[float], list[float], list[float], list[list[float]]]:
    """The sum of squared bends by the knots' shifts: its three diagonals, and what the polyline's own bends load the knots with."""
    count = len(knots)
    bands = [[0.0] * count for _ in range(3)]
    loads = [[0.0] * count for _ in range(3)]
    for i, (a, b) in enumerate(pairwise(lengths)):
        share, row = 2 / (a + b), (1 / a, -1 / a - 1 / b, 1 / b)
        bend = [share * sum(row[j] * knots[i + j].place[axis] for j in range(3)) for axis in range(3)]
        for j in range(3):
            for k in range(j, 3):
                bands[k - j][i + j] += share * row[j] * row[k]
            for axis in range(3):
                loads[axis][i + j] -= row[j] * bend[axis]
    return bands[0], bands[1], bands[2], loads


def _solved(main: list[float], first: list[float], second: list[float], loads: Sequence[Sequence[float]]) -> list[list[float]]:
    """Symmetric system of five diagonals, one solution for each row of loads: L D L^T without pivoting."""
    d: list[float] = []
    one: list[float] = []
    two: list[float] = []
    for i, value in enumerate(main):
        a = one[i - 1] * d[i - 1] if i else 0.0
        b = two[i - 2] * d[i - 2] if i > 1 else 0.0
        pivot = value - (a * one[i - 1] if i else 0.0) - (b * two[i - 2] if i > 1 else 0.0)
        d.append(pivot)
        one.append((first[i] - (two[i - 1] * a if i else 0.0)) / pivot)
        two.append(second[i] / pivot)
    return [_substituted(d, one, two, load) for load in loads]


def _substituted(d: list[float], one: list[float], two: list[float], load: Sequence[float]) -> list[float]:
    result: list[float] = []
    for i, value in enumerate(load):
        result.append(value - (one[i - 1] * result[i - 1] if i else 0.0) - (two[i - 2] * result[i - 2] if i > 1 else 0.0))
    below = further = 0.0
    for i in range(len(load) - 1, -1, -1):
        result[i] = result[i] / d[i] - one[i] * below - two[i] * further
        below, further = result[i], below
    return result
