"""Per corner the faster of passing and exact stop: a small corner can cost more time than stopping in it (motion.md 0.9).

A corner is judged on its own two legs first (from rest, over the corner, to rest); then the overall result is compared with stopping at
every corner, so it is never slower than exact stops.
"""

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from motion.errors import MotionError
from motion.paths.joints import JointPath, joined, joint_part
from motion.timing.jerk import jerk_limited
from motion.timing.law import Law
from motion.timing.limits import LawLimits
from motion.timing.slices import Work, whole

EDGE = 1e-9  # of a leg: less of it is not driven
CLEAR = 0.9  # of the time of exact stops, by the quick estimate of both: less, and one corner is passed without a look at the laws
SURE = 0.96  # of the quick estimate of legs from rest to rest, which is accurate to two per cent: no law of them is shorter


@dataclass(frozen=True)
class Rounded:
    """A way past the end of a leg: it leaves `leave` before the end and joins the next leg `reach` after its start (s of the legs)."""

    leave: float
    reach: float
    path: JointPath


Run = tuple[JointPath, Law]


def fastest(legs: Sequence[JointPath], corners: Sequence[Rounded | None], limits: LawLimits) -> tuple[list[Run], list[bool]]:
    """Runs from rest to rest, and for each corner whether it is passed.  corners: one less than legs; None: exact stop is asked for."""
    if len(corners) != len(legs) - 1:
        raise MotionError(f"{len(corners)} corners for {len(legs)} legs")

    @functools.cache
    def run(first: int, last: int) -> Run:
        path = assembled(legs[first : last + 1], corners[first:last])
        return path, jerk_limited(path, limits)

    def seconds(first: int, last: int) -> float:
        return run(first, last)[1].duration

    def exact(first: int, last: int) -> Work[float]:
        yield
        return seconds(first, last)

    chosen = whole(passed([corner is not None for corner in corners], seconds, exact))
    return [run(first, last) for first, last in groups(chosen)], chosen


def passed(
    may: Sequence[bool],
    quick: Callable[[int, int], float],
    exact: Callable[[int, int], Work[float]],
    least: Callable[[int], float] = lambda leg: 0.0,
) -> Work[list[bool]]:
    """For each corner whether it is passed.  may: whether it can be; quick, exact: seconds of legs first .. last, all corners between
    them passed, as estimated and as the law has it; least: no law of one leg from rest to rest is quicker."""
    chosen: list[bool] = []
    for k, possible in enumerate(may):
        chosen.append(possible and (yield from _better(k, quick, exact)))
        yield
    taken, alone = groups(chosen), [(k, k) for k in range(len(may) + 1)]
    if len(taken) == len(alone):
        return chosen
    together = apart = 0.0
    for one in taken:
        together += yield from exact(*one)
    if together <= sum(least(leg) for leg, _ in alone):
        return chosen
    quickly = 0.0
    for one in alone:
        quickly += quick(*one)
        yield
    if together <= SURE * quickly:
        return chosen
    for one in alone:
        apart += yield from exact(*one)
    return chosen if together <= apart else [False] * len(may)


def _better(k: int, quick: Callable[[int, int], float], exact: Callable[[int, int], Work[float]]) -> Work[bool]:
    """Return whether two legs are quicker with the corner between them passed.  The estimate is rough for corners, so an unclear case is
    decided by the law over it; laws of legs from rest to rest are made where their estimate does not decide.
    """
    passing, stopping = quick(k, k + 1), quick(k, k) + quick(k + 1, k + 1)
    yield
    if passing < CLEAR * stopping or SURE * passing > stopping:
        return passing < stopping
    passing = yield from exact(k, k + 1)
    if passing < SURE * stopping or SURE * passing > stopping:
        return passing < stopping
    return passing < (yield from exact(k, k)) + (yield from exact(k + 1, k + 1))


def groups(chosen: Sequence[bool]) -> list[tuple[int, int]]:
    """(first, last) leg of each run from rest to rest."""
    found, begin = [], 0
    for k in range(len(chosen) + 1):
        if k == len(chosen) or not chosen[k]:
            found.append((begin, k))
            begin = k + 1
    return found


def duration(runs: Sequence[Run]) -> float:
    """Seconds of all runs."""
    return sum(law.duration for _, law in runs)


def assembled(legs: Sequence[JointPath], corners: Sequence[Rounded | None]) -> JointPath:
    """One path over all these corners (none of them None)."""
    parts: list[JointPath] = []
    begin = 0.0
    for k, leg in enumerate(legs):
        corner = corners[k] if k < len(corners) else None
        end = leg.length - (corner.leave if corner else 0.0)
        if end - begin > EDGE * leg.length:
            parts.append(joint_part(leg, begin, end))
        if corner:
            parts.append(corner.path)
            begin = corner.reach
    return joined(parts)
