"""One direction of a simulated serial cable: characters leave on a grid of character times, damaged on command.  Pure: no clock, no device.

Character k of a burst leaves at start + (k + 1) * bits / baud, rounded up; the grid is absolute, so a late caller catches up without drift.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from drivers.ports.serial.line_format import FF, escape, mark
from protocols.base.machine import Damage, Ns

PENDING_LIMIT = 4096  # characters read from a sender and not yet on the line; beyond it the sender's pty fills, as a UART's buffer would


class Fault(Enum):
    """Effect on a character on its way."""

    PARITY = "parity"  # a bit is wrong and the receiver's UART sees it
    FRAMING = "framing"
    OVERRUN = "overrun"  # lost in the receiver's UART, which reports it
    BREAK = "break"
    FLIP = "flip"  # a wrong character, undetected
    DROP = "drop"  # gone without a trace


DAMAGE_OF = {Fault.PARITY: Damage.PARITY, Fault.FRAMING: Damage.FRAMING, Fault.OVERRUN: Damage.OVERRUN, Fault.BREAK: Damage.BREAK}


class Delivery(NamedTuple):
    """A run of characters that has left the line."""

    data: bytes  # as sent
    wire: bytes  # bytes for the receiving pty
    mark: str  # the record's mark


@dataclass(slots=True)
class Chance:
    """Every character is damaged with this probability; the same seed damages the same characters."""

    fault: Fault
    probability: float
    seed: int


def always() -> bool:
    """A receiver that reads marks."""
    return True


class Direction:
    """Characters on their way from one side to the other.  baud 0: they leave at once.

    marks: does the receiver decode marks (AX-060)?  Checked at every FF and every damaged character: its program may change.
    """

    def __init__(self, baud: int, bits: int = 11, *, marks: Callable[[], bool] = always) -> None:
        self._baud, self._bits, self._marks = baud, bits, marks
        self._pending = bytearray()
        self._start: Ns = 0
        self._left = 0  # characters of this burst that have left
        self._planned: dict[int, Fault] = {}  # number of the character (counted over all) -> its fault
        self._chance: Chance | None = None
        self._random = 1
        self.count = 0  # characters that have left, delivered or not

    @property
    def waiting(self) -> int:
        """Characters read and not yet on the line."""
        return len(self._pending)

    @property
    def full(self) -> bool:
        """Nothing more is read from the sender for now."""
        return len(self._pending) >= PENDING_LIMIT

    def offer(self, data: bytes, now: Ns) -> None:
        """The sender wrote `data` at `now`."""
        if not self._pending:
            self._start, self._left = now, 0
        self._pending += data

    def due(self) -> Ns | None:
        """When the next character has left; None: the line is quiet."""
        if not self._pending:
            return None
        return self._end(self._left) if self._baud else self._start

    def take(self, now: Ns) -> list[Delivery]:
        """Everything that has left by `now`."""
        count = self._gone_by(now)
        if not count:
            return []
        data = bytes(self._pending[:count])
        del self._pending[:count]
        self._left += count
        first, self.count = self.count + 1, self.count + count
        if self._chance is None and not self._planned:
            return [Delivery(data, self._wire(data), "")]
        return self._spoil(data, first)

    def spoil_next(self, fault: Fault, n: int = 1) -> None:
        """The n-th character from now on (1 = the next one to leave) is damaged."""
        self._planned[self.count + n] = fault

    def spoil_some(self, fault: Fault, probability: float, seed: int) -> None:
        """From now on every character is damaged with this probability."""
        self._chance = Chance(fault, probability, seed)
        self._random = seed * 2 + 1

    def calm(self) -> None:
        """No more damage."""
        self._chance = None
        self._planned.clear()

    def forget(self) -> None:
        """The sender's side is gone with its unsent characters."""
        self._pending.clear()

    def _end(self, index: int) -> Ns:
        return self._start - (-(index + 1) * self._bits * 1_000_000_000 // self._baud)

    def _gone_by(self, now: Ns) -> int:
        if not self._baud:
            return len(self._pending)
        over = (now - self._start) * self._baud // (self._bits * 1_000_000_000) - self._left
        count = max(0, min(over, len(self._pending)))
        if count < len(self._pending) and self._end(self._left + count) <= now:
            count += 1  # the ends are rounded up; at most one character lies between the rounded and the exact one
        return count

    def _spoil(self, data: bytes, first: int) -> list[Delivery]:
        deliveries: list[Delivery] = []
        good_from = 0
        for index, byte in enumerate(data):
            fault = self._planned.pop(first + index, None) or self._drawn()
            if fault is None:
                continue
            self._append_good(deliveries, data[good_from:index])
            good_from = index + 1
            deliveries.append(self._spoilt(fault, byte))
        self._append_good(deliveries, data[good_from:])
        return deliveries

    def _append_good(self, deliveries: list[Delivery], data: bytes) -> None:
        if data:
            deliveries.append(Delivery(data, self._wire(data), ""))

    def _wire(self, data: bytes) -> bytes:
        """Good characters as the receiver reads them."""
        return escape(data) if FF in data and self._marks() else data

    def _drawn(self) -> Fault | None:
        if self._chance is None or self._draw() >= self._chance.probability:
            return None
        return self._chance.fault

    def _draw(self) -> float:
        """0 <= number < 1; splitmix64, so that a seed causes the same damage on every machine."""
        self._random = (self._random + 0x9E3779B97F4A7C15) & 0xFFFFFFFFFFFFFFFF
        z = self._random
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 & 0xFFFFFFFFFFFFFFFF
        z = (z ^ (z >> 27)) * 0x94D049BB133111EB & 0xFFFFFFFFFFFFFFFF
        return ((z ^ (z >> 31)) >> 11) / (1 << 53)

    def _spoilt(self, fault: Fault, byte: int) -> Delivery:
        bit = int(self._draw() * 8)
        wrong = byte ^ (1 << bit) or byte ^ (1 << (bit + 1) % 8)  # never 0: it would read as BREAK
        sent = bytes((byte,))
        if fault is Fault.DROP:
            return Delivery(sent, b"", "drop")
        if fault is Fault.FLIP or not self._marks():
            other = bytes((wrong,))
            return Delivery(sent, self._wire(other), f"flip={other.hex()}")
        return Delivery(sent, mark(DAMAGE_OF[fault], wrong), fault.value)
