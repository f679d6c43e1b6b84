"""Fastest law along a path under limits of speed and acceleration: the TOPP pass of motion.md F, interpolation scheme.

Grid s_i with step h, b = sdot^2, u = sddot.  Rows |q' u + q'' b| <= a at s_i and, with b + 2 h u, at s_(i+1).  Every pair of a
lower and an upper row yields one bound of b that depends on the path alone: these are computed for all grid points at once in numpy;
only the few rows against the next point's bound run point by point, on plain numbers: a dozen of them cost less than one call of numpy.
Where the bounds of two neighbours allow each other, as along a way at the programmed speed, the pass is there at once.
"""

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.timing.needed import needed
from motion.timing.pulls import sided
from motion.timing.slices import Work, whole

Array = NDArray[np.float64]
BIG = 1e12  # means no limit on b
FLAT = 1e-12  # smaller coefficients of u do not limit u
FEW = 20  # rows: of fewer the search for those that count costs more than it saves
NOISE = 1e-6  # of the largest coefficient of the path
PORTION = 64  # places whose rows become plain numbers at once


@dataclass(frozen=True)
class Topp:
    """b: (n + 1,) sdot^2 on the grid; controllable: the largest b from which the end can still be reached; duration in s."""

    b: Array
    controllable: Array
    step: float

    @property
    def duration(self) -> float:
        """Seconds from the first to the last grid point."""
        root = np.sqrt(self.b)
        return float(np.sum(2 * self.step / (root[:-1] + root[1:])))

    @property
    def times(self) -> Array:
        """(n + 1,) s at which each grid point is passed."""
        root = np.sqrt(self.b)
        return np.concatenate([[0.0], np.cumsum(2 * self.step / (root[:-1] + root[1:]))])

    def smoothed(self, t: Array, window: float) -> Array:
        """Grid parameter (from 0) at these times, averaged over the `window` seconds before; at rest before and after."""
        return np.asarray((self._summed(t) - self._summed(t - window)) / window)

    def _summed(self, t: Array) -> Array:
        """Integral of the grid parameter over time, from rest at 0: exact, u is constant between grid points."""
        times, root = self.times, np.sqrt(self.b)
        u = (self.b[1:] - self.b[:-1]) / (2 * self.step)
        place = self.step * np.arange(len(u))
        spans = np.diff(times)
        whole = np.concatenate([[0.0], np.cumsum(spans * (place + spans * (root[:-1] / 2 + spans * u / 6)))])
        inside = np.clip(t, 0.0, times[-1])
        index = np.clip(np.searchsorted(times, inside, side="right") - 1, 0, len(u) - 1)
        late = inside - times[index]
        return np.asarray(
            whole[index]
            + late * (place[index] + late * (root[index] / 2 + late * u[index] / 6))
            + np.maximum(t - times[-1], 0.0) * self.step * len(u)
        )


@dataclass(frozen=True)
class _Rows:
    """u between low and high: low0 + low1 b <= u <= high0 + high1 b; all (n, 2 m); most: (n,) largest b of the rows alone."""

    low0: Array
    low1: Array
    high0: Array
    high1: Array
    most: Array


@dataclass(frozen=True)
class Entries:
    """controllable: the largest b at every place from which the end can still be reached."""

    rows: _Rows
    controllable: Array
    step: float

    @property
    def most(self) -> float:
        """The largest b at the start."""
        return float(self.controllable[0])

    def admit(self, b_start: float) -> bool:
        """Whether the path can be entered so fast."""
        return b_start <= self.most * (1 + 1e-9) + 1e-15

    def law(self, b_start: float) -> Topp:
        """The fastest one from there, which admit() has looked at."""
        return Topp(_forward(self.rows, self.controllable, self.step, b_start), self.controllable, self.step)


def solve(first: Array, second: Array, step: float, accel: Array, most: Array, b_start: float = 0.0, b_end: float = 0.0) -> Topp:
    """As solve_work, at once."""
    return whole(solve_work(first, second, step, accel, most, b_start, b_end))


def solve_work(first: Array, second: Array, step: float, accel: Array, most: Array, b_start: float = 0.0, b_end: float = 0.0) -> Work[Topp]:
    """first, second: (n + 1, m) q' and q''; accel: (m,) or (n + 1, m) limits, or (2, n + 1, m): speeding up, slowing down;
    most: (n + 1,) largest b the speeds allow (see speed_limit).

    Raises MotionError where no law leads from b_start to b_end.
    """
    ready = yield from entries_work(first, second, step, accel, most, b_end)
    if not ready.admit(b_start):
        raise MotionError(f"the path cannot be entered at {b_start**0.5:.6g}: at most {ready.most**0.5:.6g} can still be braked")
    yield
    return ready.law(b_start)


def entries(first: Array, second: Array, step: float, accel: Array, most: Array) -> Entries:
    """How a path to rest may be entered: looked at once for several speeds at its start."""
    return whole(entries_work(first, second, step, accel, most))


def entries_work(first: Array, second: Array, step: float, accel: Array, most: Array, b_end: float = 0.0) -> Work[Entries]:
    """As entries, a slice for the limits and one for the way back from the end."""
    accel = np.broadcast_to(accel, (2, *first.shape))
    moves = np.any((first != 0.0) | (second != 0.0), axis=0)  # a column at rest everywhere limits nothing
    if np.any(moves) and not np.all(moves):
        first, second, accel = first[:, moves], second[:, moves], accel[:, :, moves]
    rows = _rows(first, second, step, accel)
    yield
    return Entries(rows, _backward(rows, np.minimum(most, BIG), step, b_end), step)


def speed_limit(first: Array, speed: Array) -> Array:
    """(n,) largest sdot^2: |q' sdot| <= speed in every column; speed: (m,) or (n, m)."""
    with np.errstate(divide="ignore"):
        bound = np.where(np.abs(first) > FLAT, np.abs(speed / np.where(first == 0.0, 1.0, first)), np.inf)
    return np.asarray(np.minimum(np.min(bound, axis=1) ** 2, BIG))


def _rows(first: Array, second: Array, h: float, accel: Array) -> _Rows:
    """Return rows at both ends of every interval, solved for u, and their bounds of b."""
    d = np.concatenate([first[:-1], first[1:] + 2 * h * second[1:]], axis=1)
    c = np.concatenate([second[:-1], second[1:]], axis=1)
    highest, lowest = (np.concatenate([a[:-1], a[1:]], axis=1) for a in sided(first, np.where(np.isfinite(accel), accel, 1e9)))
    if d.shape[1] > FEW and np.array_equal(highest, lowest):
        d, c, highest = _that_count(d, c, highest)
        lowest = highest
    flat = np.abs(d) < FLAT
    size = np.where(flat, 1.0, np.abs(d))
    slope = np.where(flat, 0.0, -c / np.where(flat, 1.0, d))
    up = d >= 0.0
    high0 = np.where(flat, BIG, np.where(up, highest, lowest) / size)
    low0 = -np.where(flat, BIG, np.where(up, lowest, highest) / size)
    # lower row r against upper row s: low_r + slope_r b <= high_s + slope_s b; of (r, s) and (s, r) the one that leans counts
    one, two = np.triu_indices(d.shape[1], 1)
    above, below, lean = (np.ascontiguousarray(each.T) for each in (high0, -low0, slope))
    apart = lean[one] - lean[two]
    gap = np.where(apart > 0.0, below[one] + above[two], above[one] + below[two])
    apart = np.abs(apart)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = gap / apart
        ratio[apart <= FLAT] = BIG
        pairs = ratio.min(axis=0, initial=BIG)
        alone = np.where(flat & (np.abs(c) > FLAT), np.where(c > 0.0, highest, lowest) / np.abs(c), BIG).min(axis=1)
        # b at the next point may not become negative: u >= -b / 2h must leave room under every upper row
        floor = slope + 1 / (2 * h)
        stays = np.where(floor < -FLAT, high0 / np.maximum(-floor, FLAT), BIG).min(axis=1)
    return _Rows(low0, slope, high0, slope, np.minimum(np.minimum(pairs, alone), stays))


def _that_count(d: Array, c: Array, a: Array) -> tuple[Array, Array, Array]:
    """Return (n, fewer): the rows that determine the bounds of u and b; the same number at every place, that of the worst one."""
    both = np.stack([d / a, c / a], axis=2)
    count = needed(both / np.maximum(np.max(np.abs(both), axis=(0, 1)), FLAT), NOISE)
    first = np.argsort(~count, axis=1, kind="stable")[:, : max(int(np.max(np.sum(count, axis=1))), 1)]
    return np.take_along_axis(d, first, 1), np.take_along_axis(c, first, 1), np.take_along_axis(a, first, 1)


def _backward(rows: _Rows, most: Array, h: float, b_end: float) -> Array:
    """K_i: the largest b from which some u meets the rows and 0 <= b + 2 h u <= K_(i+1)."""
    inverse = 1 / (2 * h)
    tilt = rows.low1 + inverse
    leaning = tilt > FLAT
    gain = np.where(leaning, inverse / np.where(leaning, tilt, 1.0), 0.0)
    base = np.where(leaning, -rows.low0 / np.where(leaning, tilt, 1.0), BIG)
    limit = np.minimum(most[:-1], rows.most)
    result = np.append(limit, min(b_end, float(most[-1])))
    holds = (np.min(gain * result[1:, None] + base, axis=1) >= limit) & (limit >= 0.0)
    breaks, listed, bounds = np.flatnonzero(~holds).tolist(), _Listed(gain, base), result.tolist()
    i, k = len(limit), float(result[-1])
    while i > 0:
        i -= 1
        if k == bounds[i + 1] and holds[i]:  # at the limit here and before, as far as that holds
            i = breaks[at - 1] + 1 if (at := bisect_left(breaks, i)) else 0
            k = bounds[i]
            continue
        least = bounds[i]
        for factor, constant in listed.at(i):
            value = factor * k + constant
            if value < least:
                least = value
        result[i] = k = max(least, 0.0)
    return result


def _forward(rows: _Rows, controllable: Array, h: float, b_start: float) -> Array:
    """The largest u at every point."""
    b, twice = controllable.copy(), 2 * h
    b[0] = now = b_start
    most = np.min(rows.high0 + rows.high1 * controllable[:-1, None], axis=1)
    holds = np.maximum(controllable[:-1] + twice * most, 0.0) >= controllable[1:]
    breaks, listed, bounds = np.flatnonzero(~holds).tolist(), _Listed(rows.high0, rows.high1), controllable.tolist()
    i, last = 0, len(bounds) - 1
    while i < last:
        if now == bounds[i] and holds[i]:
            i = breaks[at] if (at := bisect_left(breaks, i)) < len(breaks) else last
            now = bounds[i]
            continue
        u = inf
        for constant, slope in listed.at(i):
            value = constant + slope * now
            if value < u:
                u = value
        i += 1
        b[i] = now = min(max(now + twice * u, 0.0), bounds[i])
    return b


class _Listed:
    """Rows of two tables as pairs of plain numbers, made of a portion of the places when one of them is asked for."""

    def __init__(self, one: Array, two: Array) -> None:
        self._one, self._two, self._first = one, two, -1
        self._rows: list[tuple[list[float], list[float]]] = []

    def at(self, i: int) -> Iterator[tuple[float, float]]:
        first = i - i % PORTION
        if first != self._first:
            self._first, portion = first, slice(first, first + PORTION)
            self._rows = list(zip(self._one[portion].tolist(), self._two[portion].tolist(), strict=True))
        one, two = self._rows[i - first]
        return zip(one, two, strict=True)
