"""Corners that cost more time than stopping in them are not rounded: a row of stretches, split where it stops (motion.timing.choice)."""

import functools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motion.planner.robot import Machine
from motion.planner.route import Kind, Stretch
from motion.planner.runs import Run, make_run
from motion.planner.team import Team, TeamStretch
from motion.program.factors import FULL, Factors
from motion.timing.choice import groups, passed
from motion.timing.jerk import estimate
from motion.timing.slices import Work

MOST = 16  # corners in a row that are looked at one by one: a longer row is, in parts, where stopping in all of them may be quicker


def quicker(
    row: Sequence[Stretch], machine: Machine | Team, seconds: Callable[[Run], Work[float]], factors: Factors = FULL
) -> Work[list[list[Stretch]]]:
    """Rows from rest to rest in place of `row`, which ends at rest; seconds: what a run takes.

    Corners of block slope, with a programmed speed or time stay as they are.
    """
    corners = [stretch for stretch in row if stretch.kind is Kind.CORNER]
    if not corners or any(_fixed(stretch) for stretch in row):
        return [list(row)]
    if len(corners) > MOST:
        return (yield from _in_parts(row, machine, seconds, factors))
    legs: list[list[Stretch]] = [[]]
    for stretch in row:
        if stretch.kind is Kind.CORNER:
            legs.append([])
        else:
            legs[-1].append(stretch)
    parts = [_square(corner) for corner in corners]

    def joined(first: int, last: int) -> list[Stretch]:
        found = [parts[first - 1][1]] if first > 0 else []
        for k in range(first, last + 1):
            found += legs[k]
            if k < last:
                found.append(corners[k])
        return [*found, parts[last][0]] if last < len(corners) else found

    @functools.cache
    def run(first: int, last: int) -> Run:
        return make_run(joined(first, last), machine, factors)

    quick = functools.cache(lambda first, last: estimate(run(first, last).path, run(first, last).limits))
    known: dict[tuple[int, int], float] = {}

    def exact(first: int, last: int) -> Work[float]:
        if (first, last) not in known:
            known[first, last] = yield from seconds(run(first, last))
        return known[first, last]

    ways = [_shortest(way, machine) for way in _ways(row, machine.axes)]
    chosen = yield from passed([True] * len(corners), quick, exact, ways.__getitem__)
    return [joined(*group) for group in groups(chosen)]


def _in_parts(
    row: Sequence[Stretch], machine: Machine | Team, seconds: Callable[[Run], Work[float]], factors: Factors
) -> Work[list[list[Stretch]]]:
    """A long row as it is, unless parts of it that end at rest are quicker together."""
    passing = yield from seconds(make_run(row, machine, factors))
    if passing <= sum(_shortest(way, machine) for way in _ways(row, machine.axes)):
        return [list(row)]
    found: list[list[Stretch]] = []
    for part in _parts(row):
        found += yield from quicker(part, machine, seconds, factors)
    taken = 0.0
    for one in found:
        taken += yield from seconds(make_run(one, machine, factors))
    return found if taken < passing else [list(row)]


def _parts(row: Sequence[Stretch]) -> list[list[Stretch]]:
    """With as many corners as are looked at; the corners between them are stopped in."""
    parts: list[list[Stretch]] = [[]]
    count = 0
    for stretch in row:
        count += stretch.kind is Kind.CORNER
        if count <= MOST:
            parts[-1].append(stretch)
            continue
        to, on = _square(stretch)
        parts[-1].append(to)
        parts.append([on])
        count = 0
    return parts


def _shortest(way: NDArray[np.float64], machine: Machine | Team) -> float:
    """Seconds from rest to rest that the axes take at least for a way (axes,) of each."""
    limits = [axis for each in ((machine,) if isinstance(machine, Machine) else machine.machines) for axis in each.limits]
    speed, accel, jerk = (np.array([getattr(axis, name) for axis in limits]) for name in ("speed", "accel", "jerk"))
    return float(np.max(np.maximum(np.maximum(way / speed, 2.0 * np.sqrt(way / accel)), np.cbrt(32.0 * way / jerk))))


def _ways(row: Sequence[Stretch], count: int) -> Iterator[NDArray[np.float64]]:
    """(axes,) from corner to corner, each with the halves of both."""
    way = np.zeros(count)
    for stretch in row:
        q = stretch.path.at(np.array([0.0, 0.5, 1.0]) * stretch.path.length)[:, :count]
        first, second = np.abs(np.diff(q, axis=0))
        if stretch.kind is Kind.CORNER:
            yield way + first
            way = second
        else:
            way = way + np.abs(q[-1] - q[0])
    yield way


def _fixed(stretch: Stretch) -> bool:
    timed = stretch.source.pace.time is not None or (stretch.following is not None and stretch.following.pace.time is not None)
    return timed or (stretch.kind is Kind.CORNER and (stretch.square is None or stretch.source.blend.flyby is not None))


def _square(corner: Stretch) -> tuple[Stretch, Stretch]:
    """The corner driven out: the rest of its block to the point, and the beginning of the next."""
    assert corner.square is not None and corner.following is not None
    to, on = corner.square()
    first = replace(corner, path=to, kind=Kind.MAIN, share=(corner.share[0], 1.0), following=None, stop=True, square=None)
    whole = on.length / corner.share[1]
    second = replace(first, path=on, block=corner.block + 1, source=corner.following, share=(0.0, corner.share[1]), stop=False, way=whole)
    if isinstance(first, TeamStretch) and isinstance(second, TeamStretch):
        ((n, own),) = first.parts  # of one kinematic alone: shared corners have no square
        one, two = _square(own)
        return replace(first, parts=((n, one),)), replace(second, parts=((n, two),))
    return first, second
