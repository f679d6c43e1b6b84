"""Encoders of the belts: last values, supervision, and offsets of counters that are kept over a restart.  Pure."""

from dataclasses import dataclass
from math import isnan, nan

from motion.sync.belts import Belt, Belts


@dataclass(frozen=True, slots=True)
class Zero:
    """First reading of an encoder."""

    raw: int
    span: int  # its counts are 0..span-1

    def says(self, count: int) -> int:
        """Its present reading, `count` increments further."""
        return (self.raw + count) % self.span


class BeltEncoders:
    """By the place of their belt in the cell."""

    def __init__(self, belts: int) -> None:
        self.counts = [0] * belts  # last received
        self.heard = [False] * belts  # since the last cycle
        self.silent = [0] * belts  # cycles
        self._present = [False] * belts
        self._zeros: list[Zero | None] = [None] * belts  # of those that have spoken
        self._kept: dict[int, float] = {}  # offsets as they were kept, until their encoder speaks
        self._restored = [False] * belts  # the counter has its retained value, or none was retained

    def expect(self, place: int) -> None:
        """It is on a bus."""
        self._present[place] = True

    def begins(self, place: int, raw: int, span: int) -> None:
        """The first telegram has `raw` of 0..span-1; from here on counting begins at 0."""
        self._zeros[place] = Zero(raw, span)

    def count(self, place: int, value: int) -> None:
        """A telegram."""
        self.counts[place], self.heard[place] = value, True

    def keep(self, place: int, offset: float) -> None:
        """Offset of the counter as it was kept (m or rad), NaN: none; taken once, when the encoder has spoken (AX-480)."""
        if 0 <= place < len(self.counts) and not self._restored[place]:
            self._kept[place] = offset

    def offset(self, place: int, belt: Belt) -> float:
        """Counter minus encoder value, m or rad: it stays while the belt runs.  NaN: nothing to keep yet."""
        zero = self._zeros[place]
        if zero is None or not self._restored[place]:
            return nan
        return belt.counter - zero.says(self.counts[place]) * belt.data.increment

    def listen(self, belts: Belts) -> None:
        """Call once a cycle, after the counters have been updated with the received values."""
        if self._kept:
            self._restore(belts)
        for n, present in enumerate(self._present):
            self.silent[n] = 0 if self.heard[n] or not present or belts.simulated else self.silent[n] + 1
            self.heard[n] = False

    def _restore(self, belts: Belts) -> None:
        for place in [place for place in self._kept if self._zeros[place] is not None]:
            zero, belt, offset = self._zeros[place], belts.all[place], self._kept.pop(place)
            self._restored[place] = True
            if zero is not None and not isnan(offset):
                belt.set_counter(offset + zero.says(self.counts[place]) * belt.data.increment)
