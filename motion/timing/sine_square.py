"""Sine-square slope: from rest to rest with accelerations A sin^2(pi t / T), and a steady speed between both ramps (AX-575).

A ramp of T seconds makes a speed V = A T / 2 over a way of V T / 2; its jerk is pi A / T at most, and 0 at both ends, as is the
acceleration.  So T = max(2 V / a, sqrt(2 pi V / j)) keeps both limits, and where two such ramps are longer than the way, the speed is
lowered until they just fit: V (T1 + T2) / 2 = length.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motion.timing.law import Law, check_seconds
from motion.timing.two_ramps import highest

Array = NDArray[np.float64]
STEP_S = 0.8e-3


@dataclass(frozen=True, slots=True)
class SineSquare:
    """length: of the way; speed: in the middle; ramp, landing: seconds of the first ramp and of the last."""

    length: float
    speed: float
    ramp: float
    landing: float

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.length / self.speed + 0.5 * (self.ramp + self.landing)

    @property
    def accel(self) -> float:
        """The largest."""
        return 2.0 * self.speed / min(self.ramp, self.landing)

    @property
    def jerk(self) -> float:
        """The largest."""
        return math.pi * self.accel / min(self.ramp, self.landing)

    def at(self, t: float) -> tuple[float, float, float]:
        """(s, sdot, sddot) t seconds after the start; at rest before and after."""
        s, v, a = self.states(np.array([t]))[0]
        return float(s), float(v), float(a)

    def states(self, t: Array) -> Array:
        """(n, 3) s, sdot, sddot at these times."""
        total = self.duration
        t = np.clip(t, 0.0, total)
        up, down = np.minimum(t, self.ramp), np.minimum(total - t, self.landing)
        (s1, v1, a1), (s2, v2, a2) = self._ramped(up, self.ramp), self._ramped(down, self.landing)
        rising = t <= 0.5 * (self.ramp + total - self.landing)
        s = np.where(rising, s1 + self.speed * (t - up), self.length - s2 - self.speed * (total - t - down))
        return np.stack([s, np.where(rising, v1, v2), np.where(rising, a1, -a2)], axis=1)

    def way(self, t: Array) -> Array:
        """(n,) s."""
        return np.asarray(self.states(t)[:, 0])

    def _ramped(self, t: Array, lasts: float) -> tuple[Array, Array, Array]:
        """Way, speed and acceleration t seconds into a ramp."""
        w, half = 2.0 * math.pi / lasts, self.speed / lasts
        speed = half * (t - np.sin(w * t) / w)
        way = half * (0.5 * t * t - 2.0 * (np.sin(0.5 * w * t) / w) ** 2)
        return way, speed, 2.0 * half * np.sin(0.5 * w * t) ** 2

    def slower(self, factor: float) -> "SineSquare":
        """The same in `factor` times the time."""
        return SineSquare(self.length, self.speed / factor, self.ramp * factor, self.landing * factor)

    def law(self) -> Law:
        """On an even grid."""
        count = max(math.ceil(check_seconds(self.duration) / STEP_S), 2)
        rows = self.states(np.linspace(0.0, self.duration, count + 1))
        rows[0], rows[-1] = (0.0, 0.0, 0.0), (self.length, 0.0, 0.0)
        return Law(rows[:, 0], rows[:, 1], rows[:, 2], self.duration / count)


def sine_square(length: float, speed: float, accel: float, jerk: float, decel: float | None = None) -> SineSquare:
    """The quickest one within these limits; decel: of the last ramp, that of the first when left out; s units, all > 0 and finite."""
    up, down = accel, accel if decel is None else decel
    most = _fitting(length, speed, (up, down), jerk)
    return SineSquare(length, most, _ramp_s(most, up, jerk), _ramp_s(most, down, jerk))


def _ramp_s(speed: float, accel: float, jerk: float) -> float:
    return max(2.0 * speed / accel, math.sqrt(2.0 * math.pi * speed / jerk))


def _fitting(length: float, speed: float, pulls: tuple[float, float], jerk: float) -> float:
    """The highest speed, at most `speed`, whose two ramps fit the way."""
    if pulls[0] == pulls[1]:
        return min(speed, math.sqrt(0.5 * length * pulls[0]), math.cbrt(length * length * jerk / (2.0 * math.pi)))

    def fits(v: float) -> bool:
        return 0.5 * v * sum(_ramp_s(v, pull, jerk) for pull in pulls) <= length

    return highest(fits, speed)
