"""What the limits say along a chain of timed pieces, row by row on an even grid of tau (time at full speed).

With omega = dtau/dt, u = d omega/dt, c = du/dt an axis has the acceleration omega^2 q'' + u q' and the jerk omega^3 q''' +
3 omega u q'' + c q'.  A row holds, for every column, what solves both for u and for c:

    |u + omega^2 bend| <= reach            bend = q''/q', reach = accel/|q'|
    |c + omega (omega^2 twist + u lean)| <= pull      lean = 3 q''/q', twist = q'''/q', pull = jerk/|q'|
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motion.timed import TimedPiece

Array = NDArray[np.float64]
ACCEL_TOP, JERK_TOP = 1.01, 1.015  # shares of the limits allowed while omega changes
LEAST = 1e-9  # s or s^2: q' over its limit; below it the column says nothing about u or c
FREE = 1e8  # a limit above it is none
STILL = 1e-9  # shares of the limits below which the path itself stands: omega may be anything


class Part(IntEnum):
    """Of a row."""

    REACH = 0
    BEND = 1
    PULL = 2
    LEAN = 3
    TWIST = 4


class Rows(NamedTuple):
    """Of one piece: table[0] is row `first` of the track."""

    first: int
    table: Array


class Track:
    """Grows at the end, can be cut there."""

    def __init__(self, columns: int, step: float, window: float) -> None:
        self.step, self.count = step, 0
        self.ramp = 0.0  # s from no to full acceleration, of the slowest column
        self.columns = columns
        self._window = window  # over which the acceleration's change is told: what a judge of the set values sees
        self._store = np.zeros((1024, len(Part), columns))
        self._inverse = 1.0 / step

    def cut(self, tau: float) -> None:
        """Forget what lies behind tau."""
        self.count = min(self.count, int(tau / self.step) + 1)

    def prepared(self, piece: TimedPiece, before: Sequence[TimedPiece], begin: float, where: Sequence[int]) -> "Rows":
        """Rows up to the piece's end, from shortly before its beginning where it goes on from others.

        before: the pieces it goes on from, the last one first, as many as the window is long; where: column of each of its columns.
        """
        h = self._window
        going = [one for one in before if one.mask == piece.mask] if before and before[0].mask == piece.mask else []
        first = max(int((begin - h if going else begin) / self.step + 1), 0) if begin > 0.0 else 0
        grid: Array = (np.arange(first, int((begin + piece.duration) / self.step) + 1, dtype=np.float64) + 0.5) * self.step - begin
        table = np.zeros((len(grid), len(Part), self.columns))
        table[:, Part.REACH], table[:, Part.PULL] = ACCEL_TOP / LEAST, JERK_TOP / LEAST
        if len(grid) == 0:
            return Rows(first, table)
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
            table[:, part, list(where)] = values
        return Rows(first, table)

    def append(self, rows: "Rows") -> None:
        """Rows that `prepared` made for what comes next."""
        first = min(rows.first, self.count)
        last = first + len(rows.table)
        while last > len(self._store):
            self._store = np.concatenate([self._store, np.zeros_like(self._store)])
        self._store[first:last] = rows.table
        self.count = last

    def at(self, tau: Array) -> Array:
        """(n, parts, columns)."""
        index = np.minimum((tau * self._inverse).astype(np.intp), self.count - 1)
        return self._store.take(index, axis=0, mode="clip")

    def stands(self, tau: float) -> bool:
        """The path itself rests there."""
        row = self._store[min(max(int(tau * self._inverse), 0), self.count - 1)]
        return bool((row[Part.REACH] >= ACCEL_TOP / LEAST * (1 - 1e-6)).all() and np.abs(row[Part.BEND]).max() * LEAST < STILL)


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
