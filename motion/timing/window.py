"""The rows of a track that are looked at, in one run of memory: more come at its end, a few at a time, and old ones go when it is full."""

import numpy as np
from numpy.typing import NDArray

ROOM = 2056  # rows held before old ones go; 257 lines of 64 bytes: columns a power of two apart would share few places of a cache


class Window:
    """Rows low .. end - 1 are at 0 .. end - low - 1 of `rows`, (parts, columns, ROOM or more)."""

    def __init__(self, parts: int, columns: int) -> None:
        self.rows: NDArray[np.float64] = np.zeros((parts, columns, ROOM))
        self._resting = bytearray(ROOM)
        self.low = self.end = 0

    def begin(self, row: int) -> None:
        """Empty; the next row to come is this one."""
        self.low = self.end = row

    def cut(self, row: int) -> None:
        """Forget this row and the later ones."""
        self.end = min(self.end, row)
        self.low = min(self.low, self.end)

    def room(self, low: int, high: int) -> None:
        """Make room for rows up to `high`; those before `low` may go for it."""
        size = self.rows.shape[2]
        if high - self.low <= size:
            return
        low = max(self.low, min(low, self.end))
        while high - low > size:
            size += ROOM
        rows = self.rows if size == self.rows.shape[2] else np.zeros((*self.rows.shape[:2], size))
        rows[:, :, : self.end - low] = self.rows[:, :, low - self.low : self.end - self.low]
        self._resting = bytearray(self._resting[low - self.low : self.end - self.low]).ljust(size, b"\0")
        self.rows, self.low = rows, low

    def add(self, table: NDArray[np.float32], resting: bytes) -> None:
        """The next rows; there must be room for them."""
        at = self.end - self.low
        self.rows[:, :, at : at + len(resting)] = table
        self._resting[at : at + len(resting)] = resting
        self.end += len(resting)

    def rests(self, row: int) -> bool:
        """Whether the path itself is at rest at this row; beyond the ends at the first or last one."""
        return self._resting[max(min(row, self.end - 1) - self.low, 0)] != 0
