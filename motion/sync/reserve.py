"""What the planner leaves of the axes' limits to a belt and to slowing down on the path (motion.md E 7; AX-447)."""

from collections.abc import Sequence
from dataclasses import replace
from math import cbrt, inf, sqrt

from motion.errors import MotionError
from motion.geometry.limits import AxisLimits

ACCEL, JERK = 0.9, 0.7  # of the limits: on a path that uses all of the jerk the follower can hardly slow down
LEAST = 0.1  # of the speed: less would hardly move
NONE = 1e-9  # of an axis per unit of belt: below, the axis is at rest


def reserved(limits: Sequence[AxisLimits], belt_speeds: Sequence[float] = ()) -> list[AxisLimits]:
    """Limits to plan a synchronous path with; the pieces themselves carry the full ones.

    belt_speeds: what the belt alone asks of each axis, per s (from the inverse Jacobian at the middle of the path); none: 0.
    """
    speeds = tuple(belt_speeds) or (0.0,) * len(limits)
    if len(speeds) != len(limits):
        raise MotionError(f"{len(speeds)} belt speeds for {len(limits)} axes")
    return [
        replace(axis, speed=max(axis.speed - abs(b), LEAST * axis.speed), accel=ACCEL * axis.accel, jerk=JERK * axis.jerk)
        for axis, b in zip(limits, speeds, strict=True)
    ]


def borne(along: Sequence[float], limits: Sequence[AxisLimits]) -> tuple[float, float]:
    """Acceleration and jerk of the belt value that getting on and off may have: each axis within what a path may ask of it.

    along: what each axis moves for one m or rad of belt.
    """
    asked = [(abs(p), axis) for p, axis in zip(along, limits, strict=True) if abs(p) > NONE]
    accel = min((ACCEL * axis.accel / p for p, axis in asked), default=inf)
    return accel, min((JERK * axis.jerk / p for p, axis in asked), default=inf)


def left_over(along: Sequence[float], limits: Sequence[AxisLimits], accel: float, jerk: float) -> float:
    """Return the share of full speed at which a path planned with `reserved` fits together with this acceleration and jerk of the belt
    value, in each axis.

    A path at a share of its speed needs the square of the share of acceleration and its cube of jerk.
    """
    share = 1.0
    for p, axis in zip(along, limits, strict=True):
        if abs(p) > NONE:
            by_accel, by_jerk = (1.0 - abs(p) * accel / axis.accel) / ACCEL, (1.0 - abs(p) * jerk / axis.jerk) / JERK
            share = min(share, sqrt(max(by_accel, 0.0)), cbrt(max(by_jerk, 0.0)))
    return share
