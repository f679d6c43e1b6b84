"""From rest to rest along a straight way with one jerk, and accelerations that differ for speeding up and slowing down: the optimum."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
HALVINGS = 100


@dataclass(frozen=True, slots=True)
class TwoRamps:
    """length: of the way; speed: in the middle; accel, decel, jerk: of the ramps."""

    length: float
    speed: float
    accel: float
    decel: float
    jerk: float

    @property
    def duration(self) -> float:
        """Seconds."""
        up, down = (ramp_s(self.speed, most, self.jerk) for most in (self.accel, self.decel))
        return self.length / self.speed + 0.5 * (up + down)

    def at(self, t: float) -> tuple[float, float, float]:
        """(s, sdot, sddot) t seconds after the start; at rest before and after."""
        s, v, a = self.states(np.array([t]))[0]
        return float(s), float(v), float(a)

    def states(self, t: Array) -> Array:
        """(n, 3) s, sdot, sddot at these times."""
        total, rise = self.duration, ramp_s(self.speed, self.accel, self.jerk)
        t = np.clip(t, 0.0, total)
        s1, v1, a1 = self._ramped(t, self.accel)
        s2, v2, a2 = self._ramped(total - t, self.decel)
        rising = t <= rise
        return np.stack([np.where(rising, s1, self.length - s2), np.where(rising, v1, v2), np.where(rising, a1, -a2)], axis=1)

    def _ramped(self, t: Array, most: float) -> tuple[Array, Array, Array]:
        """Return way, speed and acceleration t seconds into a ramp, and at steady speed after it."""
        j, lasts = self.jerk, ramp_s(self.speed, most, self.jerk)
        edge = min(most / j, 0.5 * lasts)  # duration of the acceleration's rise, and of its fall
        here = np.minimum(t, lasts)
        one, two = np.minimum(here, edge), np.clip(here - edge, 0.0, lasts - 2.0 * edge)
        v1, s1, a = j * edge * edge / 2.0, j * edge**3 / 6.0, j * edge
        left = np.minimum(lasts - here, edge)
        way = j * one**3 / 6.0 + two * (v1 + 0.5 * a * two)
        late = here > lasts - edge
        middle = s1 + (lasts - 2.0 * edge) * (v1 + 0.5 * a * (lasts - 2.0 * edge))
        s3 = middle + self.speed * (edge - left) - j * (edge**3 - left**3) / 6.0
        way = np.where(late, s3, way) + self.speed * np.maximum(t - lasts, 0.0)
        speed = np.where(late, self.speed - 0.5 * j * left * left, 0.5 * j * one * one + a * two)
        accel = np.where(late, j * left, j * one)
        return way, speed, accel


def ramp_s(speed: float, accel: float, jerk: float) -> float:
    """Seconds from rest to this speed."""
    return speed / accel + accel / jerk if speed * jerk >= accel * accel else 2.0 * math.sqrt(speed / jerk)


def two_ramps(length: float, speed: float, pulls: tuple[float, float], jerk: float) -> TwoRamps:
    """The quickest one within these limits; pulls: speeding up, slowing down; s units, all > 0 and finite."""

    def fits(v: float) -> bool:
        return 0.5 * v * sum(ramp_s(v, pull, jerk) for pull in pulls) <= length

    return TwoRamps(length, highest(fits, speed), *pulls, jerk)


def highest(fits: Callable[[float], bool], most: float) -> float:
    """The highest value up to `most` that fits; lower ones fit, too."""
    low, high = 0.0, most
    if fits(most):
        return most
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low
