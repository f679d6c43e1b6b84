"""Limits along a chain of timed pieces, row by row on an even grid of tau (time at full speed).

With omega = dtau/dt, u = d omega/dt, c = du/dt an axis has the acceleration omega^2 q'' + u q' and the jerk omega^3 q''' +
3 omega u q'' + c q'.  A row holds, for every column, the coefficients that solve both for u and for c:

    |u + omega^2 bend| <= reach            bend = q''/q', reach = accel/|q'|
    |c + omega (omega^2 twist + u lean)| <= pull      lean = 3 q''/q', twist = q'''/q', pull = jerk/|q'|

Where places foreseen lie several periods apart, an axis may turn back (q' = 0) between two of them; its jerk limit there is kept:

    |u + omega^2 lift| <= edge / |omega|              lift = q'''/(3 q''), edge = jerk/(3 |q''|)
"""

from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Sequence
from enum import IntEnum
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motion.execution.timed import TimedPiece
from motion.timing.window import Window

Array = NDArray[np.float64]
ACCEL_TOP, JERK_TOP = 1.0165, 1.07  # shares of the limits allowed while omega changes
LEAST = 1e-9  # s or s^2: q' over its limit; below it the column does not limit u or c
FREE = 1e8  # a limit above it is none
BENT = 0.01  # of its acceleration: an axis that turns back with less leaves u as it is
COARSE_S = 1e-3  # between rows, at most
VIEW = 240  # rows kept in view after the requested ones
FAR = 320  # rows more, where the path is driven back
NEXT = 120  # rows in view in addition to VIEW in a steady period
SOME = 64  # rows that come at a time
STILL = 1e-9  # shares of the limits below which the path itself is at rest: omega is free


class Part(IntEnum):
    """Of a row."""

    REACH = 0
    BEND = 1
    PULL = 2
    LEAN = 3
    MEAN = 4  # twist on average, over as much as lies between places that a change of speed foresees
    TWIST = 5


class Turn(NamedTuple):
    """Where an axis reverses: no c helps its jerk there, nor within one distance of places before and after."""

    tau: float
    edge: float  # the least near there
    low: float  # lift, the least and the most
    high: float


class Rows(NamedTuple):
    """Rows of one piece: table[:, :, 0] is row `first` of the track; (parts, columns, rows)."""

    first: int
    table: NDArray[np.float32]
    resting: bytes  # a byte of each of its rows: the path itself is at rest
    turns: Sequence[Turn] = ()

    @property
    def size(self) -> int:
        return len(self.table[0, 0])


class Span(NamedTuple):
    """Rows that follow one another: (parts, columns, rows)."""

    rows: Array

    def most(self, omega: float, left: float, u: float) -> tuple[float, float]:
        """Return the highest |u| that is legal at all of them with any omega up to this one, and the highest |c| with any |u| that a
        change of omega by `left`, begun at u, then reaches.
        """
        reach, pull = self.rows[Part.REACH], self.rows[Part.PULL]
        bend, lean, twist = (np.absolute(self.rows[part]) for part in (Part.BEND, Part.LEAN, Part.TWIST))
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
    """Grows at the end, loses rows at both ends; the examined rows are in a window of contiguous memory."""

    def __init__(self, columns: int, period_s: float) -> None:
        half = max(ceil(0.5 * period_s / COARSE_S), 2)
        self.step = step = 0.5 * period_s / half
        self.ramp = 0.0  # s from no to full acceleration, of the slowest column
        self.columns = columns
        self._period, self._half = period_s, half  # s; rows in half of it
        self._tables: deque[Rows] = deque()
        self._firsts: deque[int] = deque()  # of the tables: each holds from there to where the next one begins
        self.turns: list[Turn] = []  # of axes, where places foreseen lie several periods apart; their times rise
        self._seen = Window(len(Part), columns)
        self._to = 0  # earlier rows are in view, or never existed: the last row applies beyond the end
        self.inverse = 1.0 / step

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
        self._cut(rows.first)
        self.turns += rows.turns

    def pop(self) -> None:
        """Forget the last piece."""
        self._firsts.pop()
        self._cut(self._tables.pop().first)
        if self._tables:
            self._firsts[-1] = self._tables[-1].first
            self._settle()

    def forget(self) -> None:
        """Forget the first piece."""
        self._firsts.popleft()
        self._tables.popleft()
        del self.turns[: self._turn_at(self._firsts[0] * self.step) if self._firsts else None]

    def _cut(self, row: int) -> None:
        self._to = min(self._to, row)
        self._seen.cut(row)
        del self.turns[self._turn_at(row * self.step) :]

    def _turn_at(self, tau: float) -> int:
        return bisect_left(self.turns, (tau,))

    def _settle(self) -> None:
        """Settle a piece shorter than the window: it begins no later than the rows of the following pieces, which replace its own."""
        for k in range(len(self._firsts) - 2, -1, -1):
            first = min(self._tables[k].first, self._firsts[k + 1])
            if first == self._firsts[k]:
                return
            self._firsts[k] = first

    def rate(self, piece: TimedPiece) -> None:
        """What comes next may have slower axes."""
        self.ramp = max(self.ramp, *(a / j for a, j in zip(piece.accel, piece.jerk, strict=True) if a < FREE and j < FREE), 0.0)

    def prepared(self, piece: TimedPiece, before: Sequence[TimedPiece], begin: float, where: Sequence[int], apart: float) -> "Rows":
        """Return rows up to the piece's end, from shortly before its beginning where it continues others.

        before: the pieces that it continues, the last one first, four periods of them; where: column of each of its columns; apart: s,
        over which MEAN is one.
        The path's own acceleration and jerk are computed by differences over periods: what a judge of the set values sees.
        """
        h, half = self._period, self._half
        around = round(0.5 * apart / self.step)  # rows from the middle of what MEAN sees to its end
        wide = 2 * around if around > half else 0  # rows that a turn looks to both sides
        reach = max(3 * half, around + half)  # additional rows: a third difference is three periods wide
        going = [one for one in before if one.mask == piece.mask] if before and before[0].mask == piece.mask else []
        first = max(int((begin - (reach + half) * self.step if going else begin) / self.step + 1), 0) if begin > 0.0 else 0
        grid: Array = (np.arange(first, int((begin + piece.duration) / self.step) + 1, dtype=np.float64) + 0.5) * self.step - begin
        table = np.zeros((len(Part), self.columns, len(grid)), dtype=np.float32)
        table[Part.REACH], table[Part.PULL] = ACCEL_TOP / LEAST, JERK_TOP / LEAST
        if len(grid) == 0:
            return Rows(first, table, b"")
        accel, jerk = np.array(piece.accel), np.array(piece.jerk)
        values, slopes = _Chain(piece, going).at(grid[0] + self.step * np.arange(-reach - wide, len(grid) + reach + wide))
        count = len(grid) + 2 * wide
        at = {rows: slice(reach + rows, reach + rows + count) for rows in (0, *(k * half for k in (-3, -1, 1, 3)))}
        bends = (slopes[2 * half :] - slopes[: -2 * half]) / h  # from half a period after the first row on
        slope, second = slopes[at[0]], bends[reach - half : reach - half + count]
        third = (values[at[3 * half]] - 3.0 * (values[at[half]] - values[at[-half]]) - values[at[-3 * half]]) / h**3
        second, third = np.clip(second, -accel, accel), np.clip(third, -jerk, jerk)  # lawful it is
        mean, turns = third, []
        if wide:
            turns = self._turning(first, (slope, second, third), piece, wide)
            slope, second, third = (one[wide:-wide] for one in (slope, second, third))
            middle = reach - half + wide
            early, late = (bends[middle + rows : middle + rows + len(grid)] for rows in (-around, around))
            mean = np.clip((late - early) / (2 * around * self.step), -jerk, jerk)
        size, sign = np.abs(slope), np.where(slope < 0.0, -1.0, 1.0)
        by_accel, by_jerk = np.maximum(size / accel, LEAST), np.maximum(size / jerk, LEAST)
        found = {
            Part.REACH: ACCEL_TOP / by_accel,
            Part.BEND: sign * second / accel / by_accel,
            Part.PULL: JERK_TOP / by_jerk,
            Part.LEAN: 3.0 * sign * second / jerk / by_jerk,
            Part.MEAN: sign * mean / jerk / by_jerk,
            Part.TWIST: sign * third / jerk / by_jerk,
        }
        for part, numbers in found.items():
            table[part, list(where)] = numbers.T
        free = np.min(table[Part.REACH], axis=0) >= ACCEL_TOP / LEAST * (1 - 1e-6)
        resting = free & (np.max(np.abs(table[Part.BEND]), axis=0) * LEAST < STILL)
        return Rows(first, table, resting.tobytes(), turns)

    def _turning(self, first: int, own: tuple[Array, Array, Array], piece: TimedPiece, wide: int) -> list[Turn]:
        """Where axes turn back; own: q', q'', q''' of the table's rows and `wide` more at both ends."""
        slope, second, third = own
        back = (slope[wide:-wide] < 0.0) != (slope[wide - 1 : -wide - 1] < 0.0)
        back &= np.abs(second[wide:-wide]) > BENT * np.array(piece.accel)
        found: list[Turn] = []
        known = max(len(slope) - wide - 3 * self._half, 1)  # later third differences depend on the following piece
        for row, column in np.argwhere(back).tolist():
            near = slice(min(row, known - 1), min(row + 2 * wide + 1, known))
            most = 3.0 * float(np.max(np.abs(second[near, column])))
            bend = most if second[row + wide, column] > 0.0 else -most
            low, high = sorted((float(third[near, column].min()) / bend, float(third[near, column].max()) / bend))
            found.append(Turn((first + row) * self.step, JERK_TOP * piece.jerk[column] / most, low, high))
        return found

    def around(self, tau: Array, places: int, turning: bool) -> tuple[Array, Array]:
        """REACH and BEND at the first `places` of these times, PULL, LEAN and MEAN at the others, of those TWIST at the first one:
        (parts, columns, n), copies; beyond the ends the first or last row.  turning: times may rise first and fall then, or the other
        way round."""
        index = (tau * self.inverse).astype(np.intp)
        ends = index.tolist() if turning else (index.item(0), index.item(places - 1), index.item(-1))
        self.show(min(ends), max(ends))
        seen = self._seen
        np.minimum(index, seen.end - 1, out=index)
        index -= seen.low  # take() holds the other end
        here = seen.rows[: Part.PULL].take(index[:places], axis=2, mode="clip")
        rows = seen.rows[Part.PULL : Part.TWIST].take(index[places:], axis=2, mode="clip")
        rows[-1, :, 0] = seen.rows[Part.TWIST, :, max(index.item(places), 0)]
        return here, rows

    def between(self, low: float, high: float) -> list[Turn]:
        """The turns from time to time."""
        return self.turns[self._turn_at(low) : self._turn_at(high)]

    def span(self, low: float, high: float) -> Span:
        """All rows from time to time, not copied; beyond the ends the first or last row."""
        first, last = (int(max(tau, 0.0) * self.inverse) for tau in (low, high))
        self.show(first, last)
        seen = self._seen
        end = seen.end - seen.low
        begin = min(max(first - seen.low, 0), end - 1)
        return Span(seen.rows[:, :, begin : min(max(last + 1 - seen.low, begin + 1), end)])

    def here(self, tau: float) -> tuple[float, float]:
        """Highest |u| and |c| at this place if it were a straight line."""
        rows = self.span(tau, tau).rows
        return min(rows[Part.REACH, :, 0].tolist()), min(rows[Part.PULL, :, 0].tolist())

    def at_rest(self, tau: float) -> bool:
        """The path itself rests there."""
        row = int(tau * self.inverse)
        self.show(row, row)
        return self._seen.rests(row)

    def foresee(self, tau: float, omega: float) -> None:
        """Call while speed is steady: bring the rows that a change of speed would examine into view before they are needed."""
        row = int(tau * self.inverse)
        if row + VIEW + NEXT > self._to:
            self._more(row - VIEW, row + VIEW + NEXT + SOME)
        if omega < 0.0 and self._seen.low > row - NEXT >= self._firsts[0]:
            self._anew(row - VIEW - FAR, row + VIEW)

    @property
    def view(self) -> tuple[Window, int]:
        """Rows that are in view, and the first row that may not be."""
        return self._seen, self._to

    def show(self, low: int, high: int) -> None:
        """Bring these rows into view."""
        if self._seen.low > low >= self._firsts[0]:
            self._anew(low - VIEW, high)
        if high >= self._to:
            self._more(low - VIEW, high + SOME)

    def _anew(self, low: int, high: int) -> None:
        """Look from another row on: rows come at the end of a window only."""
        self._seen.begin(max(low, self._firsts[0]))
        self._to = self._seen.end
        self._more(low, high)

    def _more(self, low: int, high: int) -> None:
        """Rows up to `high` come into view; those before `low` may go."""
        seen, firsts = self._seen, self._firsts
        seen.room(low, high)
        at = max(bisect_right(firsts, seen.end) - 1, 0)
        while seen.end < high and at < len(firsts):
            rows, end = self._tables[at], firsts[at + 1] if at + 1 < len(firsts) else self.count
            part = slice(seen.end - firsts[at], max(min(end, high), seen.end) - firsts[at])
            seen.add(rows.table[:, :, part], rows.resting[part])
            at += 1
        self._to = seen.end if seen.end >= high else high


class _Chain:
    """A piece and those that it continues."""

    def __init__(self, piece: TimedPiece, before: Sequence[TimedPiece]) -> None:
        self._piece, self._before = piece, before

    def at(self, tau: Array) -> tuple[Array, Array]:
        """Values and first derivatives, (n, columns), at these rising times of the piece; negative: before it."""
        values, slopes = _sampled(self._piece, np.clip(tau, 0.0, self._piece.duration))
        count, begin, start = int(np.searchsorted(tau, 0.0)), 0.0, np.array(self._piece.nodes[0][::3])
        for piece in self._before:
            if count == 0:
                break
            begin -= piece.duration
            values[:count], slopes[:count] = _sampled(piece, np.maximum(tau[:count] - begin, 0.0))
            start -= piece.nodes[-1][::3]  # the way may be counted anew
            values[:count] += start
            start += piece.nodes[0][::3]
            count = int(np.searchsorted(tau[:count], begin))
        return values, slopes


def _sampled(piece: TimedPiece, tau: Array) -> tuple[Array, Array]:
    times, quintics = piece.table
    index = np.minimum(np.maximum(times.searchsorted(tau, side="right") - 1, 0), len(times) - 2)
    rows = quintics[index]
    u = (tau - times[index])[:, None]
    f, e, d, c, b, a = (rows[:, :, k] for k in range(6))
    return ((((f * u + e) * u + d) * u + c) * u + b) * u + a, (((5 * f * u + 4 * e) * u + 3 * d) * u + 2 * c) * u + b
