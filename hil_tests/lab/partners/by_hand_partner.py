"""A small 3964R station written straight from the text of the manual (rho 3 Releases part 1, section 7.1), for tests of ours against it.

It shares nothing with protocols.p3964r: no import, no table, another shape.  One generator is the whole station: `yield` asks for the
next character, at most so long (ns; None: for ever), and gives it back, or SILENCE, or SPOILED.  It always has priority or always not.
"""

from collections.abc import Generator
from dataclasses import dataclass

from protocols.base.machine import Damage, Ns

SILENCE, SPOILED, WAKE = -1, -2, -3
MILLISECOND = 1_000_000
Script = Generator[Ns | None, int, int]


@dataclass(frozen=True)
class Got:
    """A block came in."""

    data: bytes


@dataclass(frozen=True)
class Gave:
    """A block was acknowledged, or not after six attempts."""

    data: bytes
    acknowledged: bool


class ByHandPartner:
    """A byte machine for benches and the virtual line."""

    def __init__(self, priority: bool) -> None:
        self.priority = priority
        self.to_send: list[bytes] = []
        self._events: list[Got | Gave] = []
        self._say = b""
        self._station = self._forever()
        self._limit: Ns | None = next(self._station)
        self._until: Ns | None = None
        self._on_its_way = False

    def give(self, block: bytes, now: Ns) -> None:
        self.to_send.append(block)
        if self._limit is None:
            self._feed(WAKE, now)

    # ---- the station, as the manual tells it
    def _forever(self) -> Script:
        while True:
            if self.to_send:
                yield from self._send(self.to_send[0])
                continue
            character = yield None
            if character == 0x02:
                yield from self._receive()

    def _send(self, block: bytes) -> Script:
        tries = 0
        for _ in range(6):  # "the block transmitter repeats the block a maximum of 5 times (for a total of 6 attempts)"
            connected = False
            while tries < 6 and not connected:  # "repeats the character STX a maximum of 5 times"
                self._say += b"\x02"
                answer = yield 550 * MILLISECOND
                while answer == 0x02 and self.priority:
                    answer = yield 550 * MILLISECOND
                if answer == 0x02:  # "the end without priority must wait"
                    yield from self._receive()
                    return 0
                connected = answer == 0x10
                tries += not connected
            if not connected:
                break
            wire = b""
            for byte in block:
                wire += b"\x10\x10" if byte == 0x10 else bytes([byte])
            wire += b"\x10\x03"
            check = 0
            for byte in wire:
                check ^= byte
            self._say += wire + bytes([check])
            if (yield 550 * MILLISECOND) == 0x10:
                self._events.append(Gave(self.to_send.pop(0), True))
                return 1
        self._say += b"\x15"
        self._events.append(Gave(self.to_send.pop(0), False))
        return 0

    def _receive(self) -> Script:
        self._say += b"\x10"
        data, check, spoiled = b"", 0, False
        while True:
            character = yield 220 * MILLISECOND
            if character == 0x10:
                check ^= 0x10
                character = yield 220 * MILLISECOND
                if character == 0x03:
                    check ^= 0x03
                    last = yield 220 * MILLISECOND
                    return self._close(data, last == check and not spoiled)
                spoiled = spoiled or character != 0x10
            if character == SILENCE:  # "otherwise, it aborts reception, transmits the character NAK"
                return self._close(data, False)
            if character == SPOILED:
                spoiled = True
                continue
            check ^= character
            data += bytes([character])

    def _close(self, data: bytes, good: bool) -> int:
        good = good and len(data) <= 138
        self._say += b"\x10" if good else b"\x15"
        if good:
            self._events.append(Got(data))
        return int(good)

    # ---- the machine around it
    def _feed(self, character: int, now: Ns) -> None:
        self._limit = self._station.send(character)
        self._until = None if self._limit is None or self._say else now + self._limit

    def _told(self) -> list[Got | Gave]:
        events, self._events = self._events, []
        return events

    def receive(self, data: bytes, now: Ns) -> list[Got | Gave]:
        for byte in data:
            self._feed(byte, now)
        return self._told()

    def damaged(self, kind: Damage, now: Ns) -> list[Got | Gave]:
        self._feed(SPOILED, now)
        return self._told()

    def sent(self, now: Ns) -> list[Got | Gave]:
        self._on_its_way = False
        if self._limit is not None:
            self._until = now + self._limit
        return []

    def wake(self, now: Ns) -> list[Got | Gave]:
        if self._until is not None and now >= self._until:
            self._feed(SILENCE, now)
        return self._told()

    def deadline(self) -> Ns | None:
        return None if self._on_its_way else self._until

    def take_output(self) -> bytes:
        said, self._say = self._say, b""
        self._on_its_way = self._on_its_way or bool(said)
        return said

    def lost(self, now: Ns) -> list[Got | Gave]:
        return []
