"""A scope that rolls: the last records of some channels, in bounded memory, until it is stopped."""

from array import array
from collections.abc import Sequence

from gateway.pure.scope.channels import Channel, stamp_ns
from gateway.pure.scope.trigger import Rows


class Rolling:
    """Like Capture, without a trigger and without an end: records older than the last `keep` are dropped."""

    full = False
    triggered_at: int | None = 0  # time 0 is the oldest record kept

    def __init__(self, channels: Sequence[Channel], keep: int) -> None:
        self._reads = [each.read for each in channels]
        self.keep = max(2, keep)
        self.rows = Rows(len(self._reads))
        self.stamps = array("q")
        self.lost = 0
        self._last = 0

    def take(self, sequence: int, record: bytes) -> None:
        """The next record of the ring."""
        if self._last and sequence != self._last + 1:
            self.lost += sequence - self._last - 1
        self._last = sequence
        self.stamps.append(stamp_ns(record))
        self.rows.append(read(record) for read in self._reads)
        if len(self.stamps) >= 2 * self.keep:  # rarely, and then half of it: each record is moved once
            self.trim()

    def trim(self) -> None:
        """To the last `keep` records."""
        del self.stamps[: -self.keep]
        del self.rows.flat[: -self.keep * self.rows.width]

    def picture(self, pieces: int) -> tuple[list[float], list[list[float]]]:
        """Times in s before the newest record, and per channel least and greatest of each piece, so that no peak is missed."""
        count = min(len(self.stamps), self.keep)
        if not count:
            return [], [[] for _ in self._reads]
        first, step = len(self.stamps) - count, max(1, -(-2 * count // pieces))
        starts = range(first, len(self.stamps), step)
        times: list[float] = []
        for start in starts:
            end = min(start + step, len(self.stamps)) - 1
            times += [(self.stamps[place] - self.stamps[-1]) / 1e9 for place in ((start, end) if end > start else (start,))]
        return times, [self._extremes(column, starts, step) for column in range(self.rows.width)]

    def _extremes(self, column: int, starts: range, step: int) -> list[float]:
        values = self.rows.flat[column :: self.rows.width]
        found: list[float] = []
        for start in starts:
            piece = values[start : start + step]
            if len(piece) == 1:
                found.append(piece[0])
                continue
            low, high = min(piece), max(piece)
            found += [low, high] if piece.index(low) <= piece.index(high) else [high, low]
        return found
