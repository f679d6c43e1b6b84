"""Cuts a trace of 3964R into the turns a person speaks of: STX, DLE, NAK, a block with its check, stray characters.

A listener that answers nothing: it follows both sides of the line, so that a 10h after STX is "ready", inside a block data, and after the
block check "block good".  Source of the order: rho 3 Releases part 1, section 7.1; serial-protocols 1.3, 1.4.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import IntEnum

from gateway.pure.lines.trace import Item
from protocols.base.machine import Damage, Ns, ms

STX, ETX, DLE, NAK, ETB = 0x02, 0x03, 0x10, 0x15, 0x17
GAP = ms(500)  # a block that pauses this long has ended, whatever its receiver assumed (character delay of all profiles: 220 ms at most)
FORGET = ms(5000)  # an STX unanswered for this long is void (acknowledgement delay: 2000 ms at most)


class Kind(IntEnum):
    """What a packet is; the number is in the pseudo header of the export."""

    STX = 1
    DLE = 2
    NAK = 3
    BLOCK = 4  # everything after STX: doubled DLE, end, check
    BROKEN = 5  # a block without its end
    STRAY = 6


class Flag(IntEnum):
    """Bits of the pseudo header's flags."""

    PARITY = 0x01
    FRAMING = 0x02
    OVERRUN = 0x04
    BREAK = 0x08
    NOT_ARRIVED = 0x10
    ALTERED = 0x20  # another character arrived, without a mark
    NO_CHECK = 0x40  # procedure 3964: no block check


_DAMAGE = {Damage.PARITY: Flag.PARITY, Damage.FRAMING: Flag.FRAMING, Damage.OVERRUN: Flag.OVERRUN, Damage.BREAK: Flag.BREAK}


@dataclass(slots=True)
class Turn:
    """One packet of the export."""

    first_ns: Ns
    last_ns: Ns
    side: str
    kind: Kind
    data: bytearray
    flags: int = 0
    remarks: list[str] = field(default_factory=list)


class Turns:
    """Accepts items in line order; `finish` returns the turns, ordered by their first character."""

    def __init__(self, block_check: bool = True, gap: Ns = GAP) -> None:
        self._check, self._gap = block_check, gap
        self._done: list[Turn] = []
        self._offers: set[str] = set()  # sides whose STX is not answered
        self._heard_ns: Ns = 0
        self._block: Turn | None = None
        self._escaped = False
        self._ended = False  # the end has come, the check has not
        self._stray: Turn | None = None
        self._touched: Turn | None = None  # the turn of the latest character

    def take(self, item: Item) -> None:
        """The next characters of the line."""
        if item.stamp_ns - self._heard_ns > FORGET:
            self._offers.clear()
        self._heard_ns = item.stamp_ns
        if self._block is not None and item.stamp_ns - self._block.last_ns > self._gap:
            self._broken()
        if self._stray is not None and item.stamp_ns - self._stray.last_ns > self._gap:
            self._stray = None
        flags = self._flags(item)
        if not item.data:
            self._char(item, None, flags)
        for byte in item.data:
            self._char(item, byte, flags)
        if item.remark:
            assert self._touched is not None  # every character, and every damage without one, has its turn
            self._touched.remarks.append(item.remark)

    def finish(self) -> list[Turn]:
        """All turns; a block under way is a broken one."""
        if self._block is not None:
            self._broken()
        return sorted(self._done, key=lambda turn: turn.first_ns)

    # ---- inside
    def _flags(self, item: Item) -> int:
        flags = 0 if item.damage is None else int(_DAMAGE[item.damage])
        return flags | (0 if item.arrived else Flag.NOT_ARRIVED) | (0 if item.altered is None else Flag.ALTERED)

    def _char(self, item: Item, byte: int | None, flags: int) -> None:
        side = item.side
        if self._block is not None and side == self._block.side:
            self._in_block(self._block, item, byte, flags)
        elif byte == STX and self._block is None:
            self._offers.add(side)
            self._add(item, Kind.STX, bytes((byte,)), flags)
        elif byte == DLE:
            self._add(item, Kind.DLE, bytes((byte,)), flags)
            self._ready(item)
        elif byte == NAK:
            if self._block is not None:
                self._broken()
            self._offers.clear()
            self._add(item, Kind.NAK, bytes((byte,)), flags)
        else:
            self._strays(item, byte, flags)

    def _ready(self, item: Item) -> None:
        """DLE: the other side may send its block, or its block was good."""
        sender = next((side for side in self._offers if side != item.side), "")
        self._offers.clear()
        if sender and self._block is None:
            self._block = Turn(0, item.stamp_ns, sender, Kind.BLOCK, bytearray())
            self._escaped = self._ended = False

    def _in_block(self, block: Turn, item: Item, byte: int | None, flags: int) -> None:
        self._stray, self._touched = None, block
        block.first_ns = block.first_ns or item.stamp_ns
        block.last_ns = item.stamp_ns
        block.flags |= flags
        if byte is None:
            return
        block.data.append(byte)
        if self._ended:
            self._close()
        elif self._escaped:
            self._escaped = False
            if byte in (ETX, ETB):
                self._ended = True
                if not self._check:
                    block.flags |= Flag.NO_CHECK
                    self._close()
        else:
            self._escaped = byte == DLE

    def _close(self) -> None:
        assert self._block is not None
        self._done.append(self._block)
        self._block = None

    def _broken(self) -> None:
        block, self._block = self._block, None
        if block is not None and (block.data or block.flags):
            block.kind = Kind.BROKEN
            self._done.append(block)

    def _strays(self, item: Item, byte: int | None, flags: int) -> None:
        data = b"" if byte is None else bytes((byte,))
        if self._stray is None or self._stray.side != item.side:
            self._stray = self._add(item, Kind.STRAY, data, flags)
            return
        self._touched = self._stray
        self._stray.data += data
        self._stray.last_ns = item.stamp_ns
        self._stray.flags |= flags

    def _add(self, item: Item, kind: Kind, data: bytes, flags: int) -> Turn:
        turn = Turn(item.stamp_ns, item.stamp_ns, item.side, kind, bytearray(data), flags)
        self._done.append(turn)
        self._stray, self._touched = None, turn
        return turn


def turns(items: Iterable[Item], block_check: bool = True) -> list[Turn]:
    """Return the turns of a complete trace."""
    cutter = Turns(block_check)
    for item in items:
        cutter.take(item)
    return cutter.finish()
