"""Per corner the faster of passing and exact stop: a small corner can cost more time than stopping in it (motion.md 0.9).

A corner is judged on its own two legs first (from rest, over the corner, to rest); then what came out as a whole is compared with
stopping at every corner, so the result is never slower than exact stops.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from motion.errors import MotionError
from motion.paths.joints import JointPath, joined, joint_part
from motion.timing.jerk import jerk_limited
from motion.timing.law import Law
from motion.timing.limits import LawLimits

EDGE = 1e-9  # of a leg: less of it is not driven


@dataclass(frozen=True)
class Rounded:
    """A way past the end of a leg: it leaves `leave` before the end and joins the next leg `reach` behind its start (s of the legs)."""

    leave: float
    reach: float
    path: JointPath


Run = tuple[JointPath, Law]


def fastest(legs: Sequence[JointPath], corners: Sequence[Rounded | None], limits: LawLimits) -> tuple[list[Run], list[bool]]:
    """Runs from rest to rest, and for each corner whether it is passed.  corners: one less than legs; None: exact stop is asked for."""
    if len(corners) != len(legs) - 1:
        raise MotionError(f"{len(corners)} corners for {len(legs)} legs")
    alone = [(leg, jerk_limited(leg, limits)) for leg in legs]
    passed = [
        corner is not None
        and jerk_limited(assembled(legs[k : k + 2], [corner]), limits).duration < alone[k][1].duration + alone[k + 1][1].duration
        for k, corner in enumerate(corners)
    ]
    runs: list[Run] = []
    begin = 0
    for k in range(len(legs)):
        if k == len(legs) - 1 or not passed[k]:
            path = assembled(legs[begin : k + 1], corners[begin:k])
            runs.append((path, jerk_limited(path, limits)) if k > begin else alone[k])
            begin = k + 1
    if duration(runs) > duration(alone):
        return alone, [False] * len(corners)
    return runs, passed


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
