"""Limits of the axes: travel, speed, acceleration, jerk, and checks that name the violation.

Values inside are SI (m or rad, per s, s2, s3); `unit` is the outside unit of the axis and only makes messages readable.
Source: rho 3 P202..P205 (software limits), P103..P105 (speed, acceleration) by their meaning; ranges are the cell's.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from motion.errors import LimitError, MotionError
from motion.geometry.units import from_si, kind_of, to_si

ROUNDS = 1e5  # most turns of an endless axis in one program: beyond, positions would lose their last digits
TOUCH = 1e-9  # m or rad: tolerance that keeps a target on the limit legal despite rounding in a unit conversion


@dataclass(frozen=True, slots=True)
class AxisLimits:
    """Limits of one axis in SI; raises LimitError when they contradict themselves."""

    name: str
    lower: float  # m or rad
    upper: float  # m or rad
    speed: float  # per s
    accel: float  # per s2
    jerk: float  # per s3
    unit: str = "rad"  # outside unit of a position
    manual: bool = False  # P303 1, 4: it goes along on paths without transformation, and makes neither way nor speed
    modulo: float = 0.0  # rad: an endless axis (P303 3) goes round at it (P311); 0: an axis with ends

    def __post_init__(self) -> None:
        kind_of(self.unit)
        for quantity, value, per in (("speed", self.speed, "/s"), ("acceleration", self.accel, "/s2"), ("jerk", self.jerk, "/s3")):
            if not (math.isfinite(value) and value > 0):
                raise LimitError(self.name, f"{quantity} limit", from_si(value, self.unit), 0.0, math.inf, self.unit + per)
        if not (math.isfinite(self.lower) and math.isfinite(self.upper) and self.lower < self.upper):
            lower, upper = from_si(self.lower, self.unit), from_si(self.upper, self.unit)
            raise LimitError(self.name, "lower travel limit", lower, -math.inf, upper, self.unit)


def limits_from(
    name: str, unit: str, *, lower: float, upper: float, speed: float, accel: float, jerk: float, modulo: float = 0.0
) -> AxisLimits:
    """Limits given in the outside unit (mm, deg) -> AxisLimits in SI; an endless axis travels as far as it likes."""
    if modulo > 0.0:
        lower, upper = -ROUNDS * modulo, ROUNDS * modulo
    inside = [to_si(value, unit) for value in (lower, upper, speed, accel, jerk)]
    return AxisLimits(name, inside[0], inside[1], inside[2], inside[3], inside[4], unit, modulo=to_si(modulo, unit))


def check_target(limits: AxisLimits, target: float) -> None:
    """Raises LimitError when `target` (m or rad) is not a number or outside the travel; the limits themselves are inside."""
    if not limits.lower - TOUCH <= target <= limits.upper + TOUCH:  # a NaN fails here too
        unit = limits.unit
        raise LimitError(limits.name, "target", from_si(target, unit), from_si(limits.lower, unit), from_si(limits.upper, unit), unit)


def check_targets(limits: Sequence[AxisLimits], targets: Sequence[float]) -> None:
    """All axes at once, in their order; the first one outside is named."""
    if len(limits) != len(targets):
        raise MotionError(f"{len(targets)} targets for {len(limits)} axes")
    for axis, target in zip(limits, targets, strict=True):
        check_target(axis, target)


def check_speed(limits: AxisLimits, speed: float) -> None:
    """Raises LimitError when |speed| (per s) is beyond the axis' speed limit."""
    if not abs(speed) <= limits.speed * (1 + 1e-12):
        unit, top = limits.unit, from_si(limits.speed, limits.unit)
        raise LimitError(limits.name, "speed", from_si(speed, unit), -top, top, f"{unit}/s")


def check_factor(name: str, value: float) -> None:
    """Velocity, acceleration factors: more than 0, at most 1."""
    if not 0.0 < value <= 1.0:
        raise MotionError(f"{name} {value:.6g} is outside 0 .. 1 (0 itself would never arrive)")
