"""What the planner leaves of the axes' limits to a belt and to slowing down on the path (motion.md E 7; AX-447)."""

from collections.abc import Sequence
from dataclasses import replace

from motion.errors import MotionError
from motion.limits import AxisLimits

ACCEL, JERK = 0.9, 0.7  # of the limits: on a path that uses all of the jerk the follower can hardly slow down
LEAST = 0.1  # of the speed: less would hardly move


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
