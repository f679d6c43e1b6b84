"""Corners that cost more time than stopping in them are not rounded: a row of stretches, split where it stops (motion.timing.choice)."""

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace

from motion.planner.robot import Machine
from motion.planner.route import Kind, Stretch
from motion.planner.runs import Run, make_run
from motion.planner.team import Team, TeamStretch
from motion.program.factors import FULL, Factors
from motion.timing.choice import groups, passed
from motion.timing.jerk import estimate
from motion.timing.slices import Work

MOST = 16  # corners in a row that are looked at: longer rows are short segments, where stopping is never quicker


def quicker(
    row: Sequence[Stretch], machine: Machine | Team, seconds: Callable[[Run], Work[float]], factors: Factors = FULL
) -> Work[list[list[Stretch]]]:
    """Rows from rest to rest in place of `row`, which ends at rest; seconds: what a run takes.

    Corners of block slope, with a programmed speed or time, or of a row that is too long stay as they are.
    """
    corners = [stretch for stretch in row if stretch.kind is Kind.CORNER]
    if not 0 < len(corners) <= MOST or any(_fixed(stretch) for stretch in row):
        return [list(row)]
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

    chosen = yield from passed([True] * len(corners), quick, exact)
    return [joined(*group) for group in groups(chosen)]


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
