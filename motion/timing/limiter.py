"""Axis speeds on linear and circular paths as the rho 3 limits them: P306 sub-query 6, "Monitoring axis WC" (section 10, L5549-5596).

Works on what the interpolator asks of the axes in one clock: where one axis would be too fast, the same way of all axes is spread over
several clocks.  The manual's 40/15 = 3 is read as rounding up (rho3 D-20): rounding down would leave 20 of 15 allowed.
Feed enable and hold act before this; the last part of a block is not limited in automatic mode (L5578).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from motion.errors import MotionError

ABORT_TEXT = "Ax-Velocity exceeded"
WARNING_TEXT = "Interpolator Stop"
TOUCH = 1e-9  # relative: a speed on the limit is inside it


class Monitoring(Enum):
    """P306, sub-query 6."""

    NONE = 0
    ABORT = 1
    MANUAL = 2  # limited in manual mode only
    ALWAYS = 3


class TooFast(Enum):
    """What becomes of a path whose programmed speed asks more of an axis than its limit."""

    SLOW = "slow"  # it is run more slowly there, on the path, without a report: P306 = 0
    WARN = "warn"  # the same, and "Interpolator Stop" is reported with the axis: P306 = 3, by a law instead of by clocks
    ABORT = "abort"  # P306 = 1, reported before anything moves
    ERROR = "error"  # VAL 3: 540, reported before anything moves


def too_fast(said: str | int) -> TooFast:
    """A word, or P306 sub-query 6 of a program: programs run in automatic alone, where mode 2 watches nothing (AX-571)."""
    if isinstance(said, str):
        return TooFast(said)
    match Monitoring(said):
        case Monitoring.NONE | Monitoring.MANUAL:
            return TooFast.SLOW
        case Monitoring.ABORT:
            return TooFast.ABORT
    return TooFast.WARN


class AxisTooFast(MotionError):
    """Mode 1: the movement is aborted; `axis` is the first one beyond its limit (from 0)."""

    def __init__(self, axis: int, asked: float, most: float) -> None:
        self.axis = axis
        super().__init__(f"{ABORT_TEXT}: axis {axis + 1} would make {asked:.6g} in a clock, {most:.6g} allowed")


@dataclass(frozen=True, slots=True)
class Clocks:
    """The way of one clock spread over several: `count` times `step`; warning: "Interpolator Stop" or nothing."""

    count: int
    step: tuple[float, ...]
    warning: str = ""


def limited(step: Sequence[float], most: Sequence[float], mode: Monitoring, *, automatic: bool, last: bool = False) -> Clocks:
    """step: (axes,) m or rad of one clock; most: (axes,) highest way in a clock, P103 in automatic and P114 in manual mode.

    last: the last part of the block.  Raises AxisTooFast in mode 1.
    """
    if len(step) != len(most) or not all(limit > 0 for limit in most):
        raise MotionError(f"{len(most)} limits > 0 are needed for {len(step)} axes")
    watched = mode is not Monitoring.NONE and not (mode is Monitoring.MANUAL and automatic)
    ratio = max((abs(way) / limit for way, limit in zip(step, most, strict=True)), default=0.0)
    if not watched or ratio <= 1 + TOUCH or (last and automatic and mode is not Monitoring.ABORT):
        return Clocks(1, tuple(step))
    if mode is Monitoring.ABORT:
        axis = next(n for n, (way, limit) in enumerate(zip(step, most, strict=True)) if abs(way) > limit * (1 + TOUCH))
        raise AxisTooFast(axis, abs(step[axis]), most[axis])
    count = math.ceil(ratio - TOUCH)
    return Clocks(count, tuple(way / count for way in step), WARNING_TEXT)
