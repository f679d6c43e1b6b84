"""Limits of a path for its law: one number a column (the axes, then way of the TCP, then its turning), and caps on stretches."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motion.geometry.limits import AxisLimits
from motion.paths.joints import JointPath

Array = NDArray[np.float64]
FREE = float("inf")
WAY, TURNING = -2, -1  # columns of the tool


@dataclass(frozen=True, slots=True)
class Cap:
    """On the stretch start .. end of s a column may not exceed these: block speeds, v_flyby, A factors.  inf: no demand."""

    start: float
    end: float
    column: int  # of an axis, WAY or TURNING
    speed: float = FREE
    accel: float = FREE  # speeding up
    decel: float = FREE  # slowing down


@dataclass(frozen=True)
class LawLimits:
    """speed, accel, jerk: (axes + 2,); inf where a column has no limit."""

    speed: Array
    accel: Array
    jerk: Array
    caps: tuple[Cap, ...] = ()

    def whole(self, accel: float, jerk: float) -> "LawLimits":
        """Limits of the axes scaled by these shares; way and turning stay."""
        if accel == jerk == 1.0:
            return self
        axes = np.arange(len(self.speed)) < len(self.speed) - 2
        return replace(self, accel=np.where(axes, self.accel / accel, self.accel), jerk=np.where(axes, self.jerk / jerk, self.jerk))

    @property
    def lopsided(self) -> bool:
        """Whether somewhere speeding up and slowing down differ."""
        return any(cap.accel != cap.decel for cap in self.caps)

    def at(self, s: Array) -> tuple[Array, Array, Array]:
        """(n, axes + 2) speed, accel, jerk at these s, caps applied; accel: the smaller one where speeding up and slowing down differ."""
        shape = (len(s), len(self.speed))
        speed = np.broadcast_to(self.speed, shape).copy()
        for cap in self.caps:
            inside = (s >= cap.start) & (s <= cap.end)
            speed[inside, cap.column] = np.minimum(speed[inside, cap.column], cap.speed)
        return speed, np.asarray(self.pulls(s).min(axis=0)), np.broadcast_to(self.jerk, shape)

    def pulls(self, s: Array) -> Array:
        """(2, n, axes + 2) accelerations at these s, caps applied: speeding up, slowing down."""
        found = np.broadcast_to(self.accel, (2, len(s), len(self.accel))).copy()
        for cap in self.caps:
            inside = (s >= cap.start) & (s <= cap.end)
            for side, most in zip(found, (cap.accel, cap.decel), strict=True):
                side[inside, cap.column] = np.minimum(side[inside, cap.column], most)
        return found


def law_limits(
    axes: Sequence[AxisLimits],
    *,
    speed_factor: float = 1.0,
    accel_factor: float = 1.0,
    way: tuple[float, float, float] = (FREE, FREE, FREE),
    turning: tuple[float, float, float] = (FREE, FREE, FREE),
    caps: Sequence[Cap] = (),
) -> LawLimits:
    """Axis limits with factors (jerk is not scaled, AX-101); way, turning: (speed, acceleration, jerk) in m and rad."""
    rows = [(axis.speed * speed_factor, axis.accel * accel_factor, axis.jerk) for axis in axes]
    table = np.array([*rows, way, turning], dtype=np.float64)
    return LawLimits(table[:, 0], table[:, 1], table[:, 2], tuple(caps))


def speed_squares(path: JointPath, s: Array, limits: LawLimits) -> Array:
    """(n,) largest sdot^2 the speed limits allow."""
    speed = limits.at(s)[0]
    first = np.abs(path.at(s, 1))
    with np.errstate(divide="ignore"):
        bound = np.where(first > 1e-12, speed / np.maximum(first, 1e-12), np.inf)
    return np.asarray(np.minimum(np.min(bound, axis=1) ** 2, 1e12))
