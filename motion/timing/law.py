"""A law s(t): where on the path at which time.  Even time grid, quintic between its points."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError

Array = NDArray[np.float64]
Ends = Sequence[float] | tuple[Array, Array]
CALM = 24  # points at the ends that are smoothed less and less
LONGEST_S, POSSIBLE_S = 1000.0, 400.0  # no longer law is made: pieces cannot hold more of one (motion.planner.commit)


class EndlessError(MotionError):
    """A law too long to be made."""


def check_seconds(seconds: float, most: float = LONGEST_S) -> float:
    """The same; EndlessError where a law of this duration can be neither made nor handed on."""
    if seconds < most:
        return seconds
    long = f"{seconds:.0f} s" if math.isfinite(seconds) else "endless time"
    raise EndlessError(
        f"a motion of {long} without a stop is too long, at most {POSSIBLE_S:.0f} s are possible: run it faster, or stop in between"
    )


@dataclass(frozen=True)
class Law:
    """s, speed, accel: (n + 1,) at t = k * step; at rest at the end."""

    s: Array
    speed: Array
    accel: Array
    step: float
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.step * (len(self.s) - 1)

    @cached_property
    def _times(self) -> Array:
        return np.asarray(self.step * np.arange(len(self.s)), dtype=np.float64)

    @property
    def at_rest(self) -> bool:
        """Whether it begins at rest."""
        return self.start[1] == 0.0 and self.start[2] == 0.0

    @classmethod
    def sampled(cls, s: Array, step: float, start: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> "Law":
        """From positions alone: speed and acceleration are their differences."""
        law = cls(s, s, s, step, start)
        p = law.padded(2)
        speed = (8 * (p[3:-1] - p[1:-3]) - p[4:] + p[:-4]) / (12 * step)
        accel = (16 * (p[3:-1] + p[1:-3]) - 30 * s - p[4:] - p[:-4]) / (12 * step**2)
        speed[0], accel[0], speed[-1], accel[-1] = start[1], start[2], 0.0, 0.0
        return cls(s, speed, accel, step, start)

    def padded(self, count: int) -> Array:
        """Return s with `count` points before (rest, or its start state extrapolated backwards) and after (rest)."""
        back = -self.step * np.arange(count, 0, -1)
        before = self.s[0] + self.start[1] * back + 0.5 * self.start[2] * back**2
        return np.concatenate([before, self.s, np.full(count, self.s[-1])])

    def warped(self, beta: Array, length: float) -> "Law":
        """Time runs sqrt(beta) as fast; on an even grid again, with as many points."""
        root = np.sqrt(beta)
        times = np.concatenate([[0.0], np.cumsum(2 * self.step / (root[:-1] + root[1:]))])
        b = np.concatenate([[beta[0]], beta, [beta[-1]]])
        slope = (b[2:] - b[:-2]) / (2 * self.step)
        speed, accel = self.speed * root, self.accel * beta + 0.5 * self.speed * slope
        grid: Array = np.linspace(0.0, float(times[-1]), len(self.s))
        s = np.clip(_hermite(times, self.s, speed, accel, grid), self.s[0], length)
        return Law.sampled(s, float(grid[1]), self.start)

    def calmed(self) -> "Law":
        """Without ripples from point to point: the middle of each three counts half.  The ends stay as they are."""
        if len(self.s) < 4 * CALM:
            return self
        x = np.clip((np.arange(len(self.s)) - 2) / CALM, 0.0, 1.0)
        share = x * x * (3 - 2 * x)
        share = 0.25 * np.minimum(share, share[::-1])
        s = self.s.copy()
        s[1:-1] += share[1:-1] * (self.s[:-2] - 2 * self.s[1:-1] + self.s[2:])
        return Law.sampled(s, self.step, self.start)

    def on_grid(self, count: int) -> "Law":
        """The same law with `count` intervals."""
        grid: Array = np.linspace(0.0, self.duration, count + 1)
        s = _hermite(self._times, self.s, self.speed, self.accel, grid)
        return Law.sampled(s, float(grid[1]), self.start)

    def slower(self, factor: float) -> "Law":
        """The same in `factor` times the time; from rest only."""
        return Law(self.s, self.speed / factor, self.accel / factor**2, self.step * factor)

    def shifted(self, by: float) -> "Law":
        """The same on a path that begins `by` further on."""
        return Law(self.s - by, self.speed, self.accel, self.step, (self.start[0] - by, self.start[1], self.start[2]))

    def later(self, seconds: float) -> "Law":
        """Return the same law after this rest (rounded up to full steps); from rest only."""
        count = math.ceil(seconds / self.step - 1e-9)
        none = np.zeros(count)
        rest = np.full(count, self.s[0])
        return Law(np.concatenate([rest, self.s]), np.concatenate([none, self.speed]), np.concatenate([none, self.accel]), self.step)

    def at(self, t: Array) -> Array:
        """s at these times; the ends beyond them."""
        return _hermite(self._times, self.s, self.speed, self.accel, np.clip(t, 0.0, self.duration))

    def place(self, t: float) -> float:
        """Return s at this time, like `at`: a planner calls it in every turn, and arrays of one element are ten times slower."""
        t, times = min(max(t, 0.0), self.duration), self._times
        i = min(max(int(times.searchsorted(t, side="right")) - 1, 0), len(times) - 2)
        knots, s, speed, accel = [row[i : i + 2].tolist() for row in (times, self.s, self.speed, self.accel)]
        return float(_quintic(knots, s, speed, accel, t))


def _hermite(knots: Array, value: Array, slope: Array, bend: Array, at: Array) -> Array:
    """Quintic Hermite at these places; ends have the slope and bend of rest."""
    index = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
    return np.asarray(_within(knots, value, slope, bend, at, index))


def _within(knots: Array, value: Array, slope: Array, bend: Array, at: Array | float, index: NDArray[np.intp] | int) -> Array | float:
    """In the intervals of these numbers."""
    ends = [(row[index], row[index + 1]) for row in (knots, value, slope, bend)]
    return _quintic(ends[0], ends[1], ends[2], ends[3], at)


def _quintic(knots: Ends, value: Ends, slope: Ends, bend: Ends, at: Array | float) -> Array | float:
    """Between two knots, or many pairs of them."""
    h = knots[1] - knots[0]
    u = (at - knots[0]) / h
    a, b, c = value[0], slope[0] * h, 0.5 * bend[0] * h * h
    gap = value[1] - a - b - c
    lean = slope[1] * h - b - 2 * c
    curl = bend[1] * h * h - 2 * c
    fifth = (-15 * gap + 7 * lean - curl) + u * (6 * gap - 3 * lean + 0.5 * curl)
    return a + u * (b + u * (c + u * ((10 * gap - 4 * lean + 0.5 * curl) + u * fifth)))
