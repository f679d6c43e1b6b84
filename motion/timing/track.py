"""What the limits say along a chain of timed pieces, row by row on an even grid of tau (time at full speed).

With omega = dtau/dt, u = d omega/dt, c = du/dt an axis has the acceleration omega^2 q'' + u q' and the jerk omega^3 q''' +
3 omega u q'' + c q'.  A row holds, for every column, what solves both for u and for c:

    |u + omega^2 bend| <= reach            bend = q''/q', reach = accel/|q'|
    |c + omega (omega^2 twist + u lean)| <= pull      lean = 3 q''/q', twist = q'''/q', pull = jerk/|q'|
"""

from bisect import bisect_right
from collections import deque
from collections.abc import Sequence
from enum import IntEnum
from itertools import chain, islice
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motion.timed import TimedPiece

Array = NDArray[np.float64]
ACCEL_TOP, JERK_TOP = 1.0165, 1.07  # shares of the limits allowed while omega changes
LEAST = 1e-9  # s or s^2: q' over its limit; below it the column says nothing about u or c
FREE = 1e8  # a limit above it is none
VIEW = 240  # rows kept in view beside those asked for
FAR = 320  # rows more, the way a steady speed goes
NEXT = 120  # rows from the end of the view at which a steady period already looks further
STILL = 1e-9  # shares of the limits below which the path itself stands: omega may be anything


class Part(IntEnum):
    """Of a row."""

    REACH = 0
    BEND = 1
    PULL = 2
    LEAN = 3
    TWIST = 4


class Rows(NamedTuple):
    """Of one piece: table[:, :, 0] is row `first` of the track; (parts, columns, rows)."""

    first: int
    table: NDArray[np.float32]
    resting: list[bool]  # of its rows: the path itself stands

    @property
    def size(self) -> int:
        return len(self.table[0, 0])


class Span(NamedTuple):
    """Rows that follow one another: (parts, columns, rows)."""

    rows: Array

    def most(self, omega: float, left: float, u: float) -> tuple[float, float]:
        """Highest |u| that is lawful at all of them with any omega up to this one; highest |c| with any |u| that a change of omega by
        `left`, begun at u, then comes to."""
        reach, pull = self.rows[Part.REACH], self.rows[Part.PULL]
        bend, _, lean, twist = np.absolute(self.rows[Part.BEND :])
        bend *= omega * omega
        np.subtract(reach, bend, out=bend)
        most_u = float(np.minimum.reduce(bend, axis=None))
        twist *= omega * omega * omega
        np.subtract(pull, twist, out=twist)
        free = max(float(np.minimum.reduce(twist, axis=None)), 0.0)
        lean *= omega * min(most_u, sqrt(free * abs(left) + u * u))
        np.subtract(twist, lean, out=lean)
        return most_u, float(np.minimum.reduce(lean, axis=None))


class Track:
    """Grows at the end, loses rows at both ends; what is looked at lies in a window, in one run of memory."""

    def __init__(self, columns: int, step: float, window: float) -> None:
        self.step = step
        self.ramp = 0.0  # s from no to full acceleration, of the slowest column
        self.columns = columns
        self._window = window  # over which the acceleration's change is told: what a judge of the set values sees
        self._tables: deque[Rows] = deque()
        self._firsts: deque[int] = deque()  # of the tables: each holds from there to where the next one begins
        self._seen: Array = np.zeros((len(Part), columns, 0))  # rows _from .. _to, as (parts, columns, rows)
        self._resting: list[bool] = []  # of these rows: the path itself stands
        self._from = self._to = 0
        self._inverse = 1.0 / step

    @property
    def count(self) -> int:
        """One more than the number of the last row."""
        return self._tables[-1].first + self._tables[-1].size if self._tables else 0

    def append(self, rows: "Rows") -> None:
        """Rows that `prepared` made for what comes next."""
        rows = rows._replace(first=min(rows.first, self.count)) if self._tables else rows
        self._tables.append(rows)
        self._firsts.append(rows.first)
        self._settle()
        self._to = min(self._to, rows.first)

    def pop(self) -> None:
        """Forget the last piece."""
        self._firsts.pop()
        self._to = min(self._to, self._tables.pop().first)
        if self._tables:
            self._firsts[-1] = self._tables[-1].first
            self._settle()

    def forget(self) -> None:
        """Forget the first piece."""
        self._firsts.popleft()
        self._tables.popleft()

    def _settle(self) -> None:
        """A piece shorter than the window begins no later than the rows of those behind it, which take the place of its own."""
        for k in range(len(self._firsts) - 2, -1, -1):
            first = min(self._tables[k].first, self._firsts[k + 1])
            if first == self._firsts[k]:
                return
            self._firsts[k] = first

    def prepared(self, piece: TimedPiece, before: Sequence[TimedPiece], begin: float, where: Sequence[int]) -> "Rows":
        """Rows up to the piece's end, from shortly before its beginning where it goes on from others.

        before: the pieces it goes on from, the last one first, as many as the window is long; where: column of each of its columns.
        """
        h = self._window
        going = [one for one in before if one.mask == piece.mask] if before and before[0].mask == piece.mask else []
        first = max(int((begin - h if going else begin) / self.step + 1), 0) if begin > 0.0 else 0
        grid: Array = (np.arange(first, int((begin + piece.duration) / self.step) + 1, dtype=np.float64) + 0.5) * self.step - begin
        table = np.zeros((len(Part), self.columns, len(grid)), dtype=np.float32)
        table[Part.REACH], table[Part.PULL] = ACCEL_TOP / LEAST, JERK_TOP / LEAST
        if len(grid) == 0:
            return Rows(first, table, [])
        accel, jerk = np.array(piece.accel), np.array(piece.jerk)
        self.ramp = max(self.ramp, *(float(a / j) for a, j in zip(accel, jerk, strict=True) if a < FREE and j < FREE), 0.0)
        chain = _Chain(piece, going)
        (early, bend), (late, bent) = (chain.at(grid + k * h) for k in (-0.5, 0.5))
        slope, second, third = chain.at(grid)[0], (late - early) / h, (bent - bend) / h
        second = np.clip(second, -accel, accel)  # full speed itself is lawful, whatever rounding says
        third = np.clip(third, -jerk, jerk)
        size, sign = np.abs(slope), np.where(slope < 0.0, -1.0, 1.0)
        by_accel, by_jerk = np.maximum(size / accel, LEAST), np.maximum(size / jerk, LEAST)
        found = {
            Part.REACH: ACCEL_TOP / by_accel,
            Part.BEND: sign * second / accel / by_accel,
            Part.PULL: JERK_TOP / by_jerk,
            Part.LEAN: 3.0 * sign * second / jerk / by_jerk,
            Part.TWIST: sign * third / jerk / by_jerk,
        }
        for part, values in found.items():
            table[part, list(where)] = values.T
        free = np.min(table[Part.REACH], axis=0) >= ACCEL_TOP / LEAST * (1 - 1e-6)
        return Rows(first, table, (free & (np.max(np.abs(table[Part.BEND]), axis=0) * LEAST < STILL)).tolist())

    def around(self, tau: Array, places: int) -> tuple[Array, Array]:
        """REACH and BEND at the first `places` of these times, PULL, LEAN and TWIST at the others: (parts, columns, n), copies; beyond
        the ends the first or last row."""
        index = (tau * self._inverse).astype(np.intp)
        self._show(int(np.minimum.reduce(index)), int(np.maximum.reduce(index)))
        index -= self._from
        here, rows = self._seen[: Part.PULL], self._seen[Part.PULL :]
        return here.take(index[:places], axis=2, mode="clip"), rows.take(index[places:], axis=2, mode="clip")

    def span(self, low: float, high: float) -> Span:
        """All rows from time to time, not copied; beyond the ends the first or last row."""
        first, last = (int(max(tau, 0.0) * self._inverse) for tau in (low, high))
        self._show(first, last)
        end = self._seen.shape[2]
        begin = min(max(first - self._from, 0), end - 1)
        return Span(self._seen[:, :, begin : max(last + 1 - self._from, begin + 1)])

    def here(self, tau: float) -> tuple[float, float]:
        """Highest |u| and |c| at this place if it were a straight line."""
        reach, _, pull, _, _ = self.span(tau, tau).rows[:, :, 0].tolist()
        return min(reach), min(pull)

    def stands(self, tau: float) -> bool:
        """The path itself rests there."""
        row = int(tau * self._inverse)
        self._show(row, row)
        return self._resting[min(max(row - self._from, 0), len(self._resting) - 1)]

    def foresee(self, tau: float, omega: float) -> None:
        """To be called while speed is steady: what a change of speed would look at is brought into view before it is needed, and so
        much more the way omega goes that this is seldom."""
        row = int(tau * self._inverse)
        if (row - NEXT < self._from and row - NEXT >= self._firsts[0]) or row + VIEW + NEXT > self._to:
            self._look(row - (FAR if omega < 0.0 else 0), row + VIEW + (FAR if omega > 0.0 else 0))

    def _show(self, low: int, high: int) -> None:
        if (low < self._from and low >= self._firsts[0]) or high >= self._to:
            self._look(low, high)

    def _look(self, low: int, high: int) -> None:
        """Bring these rows into the window, and some more, so that it is not moved in every period."""
        low, high = low - VIEW, high + VIEW
        first = max(bisect_right(self._firsts, low) - 1, 0)
        last = max(bisect_right(self._firsts, high), first + 1)
        begins = [*islice(self._firsts, first, last), self._firsts[last] if last < len(self._firsts) else self.count]
        seen = list(zip(islice(self._tables, first, last), begins, begins[1:], strict=False))
        self._seen = np.concatenate([rows.table[:, :, : end - begin] for rows, begin, end in seen], axis=2, dtype=np.float64)
        self._resting = list(chain.from_iterable(rows.resting[: end - begin] for rows, begin, end in seen))
        self._from, self._to = begins[0], begins[-1]
        if last == len(self._firsts):
            self._to = max(self._to, high + 1)  # beyond the end the last row holds, until more comes


class _Chain:
    """A piece and those it goes on from."""

    def __init__(self, piece: TimedPiece, before: Sequence[TimedPiece]) -> None:
        self._piece, self._before = piece, before

    def at(self, tau: Array) -> tuple[Array, Array]:
        """First and second derivatives, (n, columns), at these rising times of the piece; negative: before it."""
        first, second = _derivatives(self._piece, np.clip(tau, 0.0, self._piece.duration))
        count, begin = int(np.searchsorted(tau, 0.0)), 0.0
        for piece in self._before:
            if count == 0:
                break
            begin -= piece.duration
            first[:count], second[:count] = _derivatives(piece, np.maximum(tau[:count] - begin, 0.0))
            count = int(np.searchsorted(tau[:count], begin))
        return first, second


def _derivatives(piece: TimedPiece, tau: Array) -> tuple[Array, Array]:
    times = np.array(piece.times)
    index = np.clip(np.searchsorted(times, tau, side="right") - 1, 0, len(times) - 2)
    rows = np.array(piece.quintics)[index]
    u = (tau - times[index])[:, None]
    f, e, d, c, b = (rows[:, :, k] for k in range(5))
    first = (((5 * f * u + 4 * e) * u + 3 * d) * u + 2 * c) * u + b
    second = ((20 * f * u + 12 * e) * u + 6 * d) * u + 2 * c
    return first, second
