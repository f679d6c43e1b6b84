"""Corners that cost more time than stopping in them are not rounded: a row of stretches, split where it stops (motion.timing.choice)."""

import functools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motion.planner.robot import Machine
from motion.planner.runs import Run, all_caps, make_run
from motion.planner.stretch import Kind, Stretch, evenly
from motion.planner.team import Team, TeamStretch
from motion.program.factors import FULL, Factors
from motion.timing.choice import groups, passed
from motion.timing.jerk import estimate
from motion.timing.slices import Work

TINY = 1e-12
PAUSE_S = 1e-3  # between two runs: the jerk one ends with and the jerk the next begins with do not add up (AX-317)
MOST = 16  # corners in a row that are looked at one by one: a longer row is, in parts, where stopping in all of them may be quicker


def quicker(
    row: Sequence[Stretch], machine: Machine | Team, seconds: Callable[[Run], Work[float]], factors: Factors = FULL
) -> Work[list[list[Stretch]]]:
    """Return rows from rest to rest in place of `row`, which ends at rest; seconds: duration of a run.

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
    parts = [_driven_out(corner) for corner in corners]

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

    chosen = yield from passed([True] * len(corners), quick, exact, _shortest(row, machine, factors).__getitem__)
    return [joined(*group) for group in groups(chosen)]


def _in_parts(
    row: Sequence[Stretch], machine: Machine | Team, seconds: Callable[[Run], Work[float]], factors: Factors
) -> Work[list[list[Stretch]]]:
    """A long row as it is, unless parts of it that end at rest are quicker together."""
    passing = yield from seconds(make_run(row, machine, factors))
    if passing <= sum(_shortest(row, machine, factors)):
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
        to, on = _driven_out(stretch)
        parts[-1].append(to)
        parts.append([on])
        count = 0
    return parts


def _shortest(row: Sequence[Stretch], machine: Machine | Team, factors: Factors) -> list[float]:
    """Return the least seconds from rest to rest between corners, each way straight and at the programmed speeds."""
    return [_least(way, slowest, machine) for way, slowest in _ways(row, machine, factors)]


def _least(way: NDArray[np.float64], slowest: float, machine: Machine | Team) -> float:
    """way: (axes,) of each; slowest: seconds the programmed speeds alone ask for."""
    limits = [axis for each in ((machine,) if isinstance(machine, Machine) else machine.machines) for axis in each.limits]
    speed, accel, jerk = (np.array([getattr(axis, name) for axis in limits]) for name in ("speed", "accel", "jerk"))
    speed, ramp = np.minimum(speed, way / slowest) if slowest > 0.0 else speed, accel / jerk
    full = speed >= accel * ramp  # acceleration is reached on the way to the speed
    rise = np.where(full, speed / accel + ramp, 2.0 * np.sqrt(speed / jerk))
    slow = np.where(way < 2.0 * accel * ramp**2, np.cbrt(32.0 * way / jerk), ramp + np.sqrt(ramp**2 + 4.0 * way / accel))
    return float(np.max(np.where(way > speed * rise, way / np.maximum(speed, TINY) + rise, slow), initial=0.0, where=way > TINY))


def _ways(row: Sequence[Stretch], machine: Machine | Team, factors: Factors) -> Iterator[tuple[NDArray[np.float64], float]]:
    """(axes,) and seconds at the programmed speeds from corner to corner, each with the halves of both."""
    way, slowest = np.zeros(machine.axes), 0.0
    for stretch in row:
        columns = stretch.path.at(np.array([0.0, 0.5, 1.0]) * stretch.path.length)
        first, second = np.abs(np.diff(columns, axis=0))
        caps = all_caps(stretch, 0.0, machine, factors)
        halves = [max((float(part[cap.column]) / cap.speed for cap in caps), default=0.0) for part in (first, second)]
        first, second = first[: machine.axes], second[: machine.axes]
        if stretch.kind is Kind.CORNER:
            yield way + first, slowest + halves[0]
            way, slowest = second, halves[1]
        else:
            way, slowest = way + first + second, slowest + sum(halves)
    yield way, slowest


def stopping(
    row: Sequence[Stretch], machine: Machine | Team, passing: float, factors: Factors = FULL, *, moving: bool = False
) -> Work[tuple[list[list[Stretch]], float]]:
    """Runs that stop in all corners of a row whose end may be open, and their seconds, if that is quicker than the law of `passing`
    seconds; else none.  moving: the first of them continues a motion and is not counted."""
    if not any(stretch.kind is Kind.CORNER for stretch in row) or any(_fixed(stretch) for stretch in row):
        return [], 0.0
    least = 0.0
    for n, (way, slowest) in enumerate(_ways(row, machine, factors)):
        least += _least(way, slowest, machine) if n >= moving else 0.0
        if passing <= least:
            return [], 0.0
    found: list[list[Stretch]] = [[]]
    seconds = 0.0
    for stretch in row:
        if stretch.kind is not Kind.CORNER:
            found[-1].append(stretch)
            continue
        yield
        to, on = _driven_out(stretch)
        found[-1].append(to)
        seconds += _estimated(found[-1], machine, factors) if len(found) > moving else 0.0
        if seconds >= passing:
            return [], 0.0
        found.append([on])
    seconds += _estimated(found[-1], machine, factors)
    return (found, seconds) if seconds < passing else ([], 0.0)


def _estimated(row: Sequence[Stretch], machine: Machine | Team, factors: Factors) -> float:
    run = make_run(row, machine, factors)
    return estimate(run.path, run.limits) + PAUSE_S


def _fixed(stretch: Stretch) -> bool:
    timed = stretch.source.pace.time is not None or (stretch.following is not None and stretch.following.pace.time is not None)
    return timed or (stretch.kind is Kind.CORNER and (stretch.square is None or stretch.source.blend.flyby is not None))


def _driven_out(corner: Stretch) -> tuple[Stretch, Stretch]:
    """As _square, by a parameter of its own where the axes swing."""
    to, on = _square(corner)
    return (to, on) if isinstance(corner, TeamStretch) else (evenly(to), evenly(on))


def _square(corner: Stretch) -> tuple[Stretch, Stretch]:
    """The corner driven out: the rest of its block to the point, and the beginning of the next."""
    assert corner.square is not None and corner.following is not None
    to, on = corner.square()
    first = replace(corner, path=to, kind=Kind.MAIN, share=(corner.share[0], 1.0), following=None, stop=True, square=None, even=False)
    whole = on.length / corner.share[1]
    second = replace(first, path=on, block=corner.block + 1, source=corner.following, share=(0.0, corner.share[1]), stop=False, way=whole)
    if isinstance(first, TeamStretch) and isinstance(second, TeamStretch):
        ((n, own),) = first.parts  # of one kinematic alone: shared corners have no square
        one, two = _square(own)
        return replace(first, parts=((n, one),)), replace(second, parts=((n, two),))
    return first, second
