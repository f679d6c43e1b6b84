"""How a drive judges SYNC: a phase-locked loop with a tolerance, and a time-out.

Real drives permit from 50 us of jitter (Parker Compax3 manual, p. 323) to a missing SYNC now and then; here both are parameters (AX-287).
"""

from protocols.base.machine import Ns

LOCK_COUNT = 5  # SYNCs in a row, each in time after the one before, until the loop judges
LOCK_TRIES = 20  # SYNCs after which it judges in any case
GAIN_SHIFT = 2  # a quarter of the phase error is corrected at each SYNC


class SyncWatch:
    """Phase error of each SYNC against the drive's own grid; `period` is the period set in the drive."""

    def __init__(self, period: Ns) -> None:
        self.period = period
        self.tolerance: Ns = period // 4
        self.error: Ns = 0
        self.worst: Ns = 0
        self.outside = self.in_a_row = self.missing = 0
        self._seen = self._tries = 0
        self._left_out = False  # the last SYNC was counted as the second one after the one before it
        self._grid: Ns = 0

    @property
    def locked(self) -> bool:
        return self._seen >= LOCK_COUNT

    @property
    def time_out(self) -> Ns:
        """One SYNC may be missing, with jitter (as AX-081)."""
        return 2 * self.period + self.period // 4

    def unlock(self) -> None:
        self._seen = self._tries = self.in_a_row = 0

    def clear(self) -> None:
        self.worst = self.outside = self.missing = 0

    def heard(self, stamp: Ns) -> None:
        """A SYNC; `error` and `in_a_row` report its phase."""
        if self._seen == 0:
            self._grid, self._seen = stamp, 1
            return
        cycles = (stamp - self._grid + self.period // 2) // self.period
        if cycles < 1 and self._left_out:  # the one before was that one, late by more than half a period
            self._grid -= self.period
            self.missing -= 1
        cycles = max(1, cycles)
        self._left_out = cycles > 1
        expected = self._grid + cycles * self.period
        error = self.error = stamp - expected
        self._grid = expected + (error >> GAIN_SHIFT)
        if self._seen < LOCK_COUNT:
            self._grid, self._tries, self._left_out = stamp, self._tries + 1, False
            fits = -self.tolerance <= error <= self.tolerance
            self._seen = self._seen + 1 if fits else LOCK_COUNT if self._tries >= LOCK_TRIES else 1
            return
        self.missing += cycles - 1
        size = error if error >= 0 else -error
        if size > self.worst:
            self.worst = size
        if size > self.tolerance:
            self.outside += 1
            self.in_a_row += 1
        else:
            self.in_a_row = 0
