"""Decodes the traffic of a 3964R line, character by character, into sentences: STX, DLE, NAK, blocks, RK512 telegrams.

Both sides or one side only (a tap in one wire): with both, a block begins when the other side has answered STX; with one, it begins
with whatever follows STX.  Order of the characters: serial-protocols 1.3, 1.4; telegrams: 2.1..2.4.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from protocols.base.machine import Damage, Ns, ms
from protocols.p3964r.characters import Char

GAP = ms(500)  # a block that pauses this long was abandoned (largest ZVZ/CDT of all profiles: 220 ms)
ALONE = ms(100)  # one side only: STX or NAK this long after STX is a repeat or an abandonment, not data
COMMANDS = {0x41: "SEND", 0x4F: "SEND (DX)", 0x45: "FETCH"}
TYPES = {0x44: "DB", 0x58: "DX", 0x45: "E", 0x41: "A", 0x4D: "M", 0x54: "T", 0x5A: "Z"}
IN_WORDS = (0x44, 0x58, 0x54, 0x5A)
SHOWN = 16  # data words of a telegram that are printed
ERRORS = {
    0x00: "no error",
    0x0A: "access not possible",
    0x0C: "type not valid",
    0x10: "header error",
    0x12: "type not supported",
    0x14: "block missing or too short",
    0x16: "command wrong",
    0x2A: "partner in STOP",
    0x32: "locked by coordination flag",
    0x34: "length wrong",
    0x36: "sequence",
}


@dataclass(frozen=True, slots=True)
class LineReport:
    """One line of the monitor; `stamp` is that of its last character."""

    stamp: Ns
    side: str
    kind: str  # STX DLE NAK BLOCK BROKEN STRAY DAMAGED
    text: str
    data: bytes = b""  # of a block: without doubling, end and check
    check_ok: bool | None = None
    check_difference: int = 0  # BCC as sent xor BCC by the rule
    first: Ns = 0


class Decoder(Protocol):
    """Decodes the characters of both sides of a line in the order received."""

    def take(self, stamp: Ns, side: str, what: int | Damage) -> Sequence[LineReport]:
        """Reports that this character completes."""


@dataclass(slots=True)
class _Block:
    """A block under way."""

    first: Ns
    last: Ns
    data: bytearray = field(default_factory=bytearray)
    check: int = 0
    escaped: bool = False
    ended: bool = False
    damaged: int = 0


class LineDecoder:
    """`take` returns the sentences that a character completes; `both`: both sides are received."""

    def __init__(self, both: bool = True, block_check: bool = True) -> None:
        self._both, self._check = both, block_check
        self._offered: dict[str, Ns] = {}  # side -> moment of its unanswered STX
        self._blocks: dict[str, _Block] = {}
        self._answer_of = ""  # side that has to answer the block before

    def take(self, stamp: Ns, side: str, what: int | Damage) -> list[LineReport]:
        """The next character of the line, in the order of the stamps."""
        reports = self._expire(stamp)
        block = self._blocks.get(side)
        if block is None and not self._both and side in self._offered and not self._is_repeat(stamp, side, what):
            del self._offered[side]
            block = self._blocks[side] = _Block(stamp, stamp)
        return reports + (self._inside(block, stamp, side, what) if block is not None else self._outside(stamp, side, what))

    def flush(self, now: Ns) -> list[LineReport]:
        """Blocks that pause too long at this moment."""
        return self._expire(now)

    def expected(self) -> str:
        """Side whose character comes next by the protocol, "" where either may begin: orders the characters of two taps."""
        if self._blocks:
            return next(iter(self._blocks))
        if len(self._offered) == 1:
            return _other(next(iter(self._offered)))
        return self._answer_of

    # ---- inside
    def _is_repeat(self, stamp: Ns, side: str, what: int | Damage) -> bool:
        return what in (Char.STX, Char.NAK) and stamp - self._offered[side] > ALONE

    def _expire(self, now: Ns) -> list[LineReport]:
        late = [side for side, block in self._blocks.items() if now - block.last > GAP]
        return [self._broken(side, "pause") for side in late]

    def _broken(self, side: str, why: str) -> LineReport:
        block = self._blocks.pop(side)
        text = f"block broken off ({why}) after {len(block.data)} characters: {block.data[:SHOWN].hex(' ')}"
        return LineReport(block.last, side, "BROKEN", text, bytes(block.data), first=block.first)

    def _outside(self, stamp: Ns, side: str, what: int | Damage) -> list[LineReport]:
        self._answer_of = ""
        if isinstance(what, Damage):
            return [LineReport(stamp, side, "DAMAGED", f"a damaged character ({what.name.lower()})", first=stamp)]
        reports: list[LineReport] = []
        match what:
            case Char.STX:
                text = "STX: requests to send"
                if self._both and any(other != side for other in self._offered):
                    text += ", at the same time as the other side (conflict)"
                self._offered[side] = stamp
                reports.append(LineReport(stamp, side, "STX", text, first=stamp))
            case Char.DLE:
                reports.append(LineReport(stamp, side, "DLE", self._acknowledged(stamp, side), first=stamp))
            case Char.NAK:
                reports += [self._broken(other, "NAK") for other in list(self._blocks) if other != side]
                self._offered.clear()
                reports.append(LineReport(stamp, side, "NAK", "NAK", first=stamp))
            case _:
                reports.append(LineReport(stamp, side, "STRAY", f"stray character {what:02X}h", bytes((what,)), first=stamp))
        return reports

    def _acknowledged(self, stamp: Ns, side: str) -> str:
        sender = next((other for other in self._offered if other != side), None)
        if sender is None:
            return "DLE: good"
        self._offered.clear()
        self._blocks[sender] = _Block(stamp, stamp)
        return "DLE: ready"

    def _inside(self, block: _Block, stamp: Ns, side: str, what: int | Damage) -> list[LineReport]:
        if not block.data and not block.escaped:
            block.first = stamp
        block.last = stamp
        if isinstance(what, Damage):
            block.damaged += 1
            return []
        if block.ended:
            return [self._close(block, side, block.check ^ what)]
        block.check ^= what
        if block.escaped:
            block.escaped = False
            if what in (Char.ETX, Char.ETB):
                block.ended = True
                return [] if self._check else [self._close(block, side, None)]
            block.data.append(what)
        elif what == Char.DLE:
            block.escaped = True
        else:
            block.data.append(what)
        return []

    def _close(self, block: _Block, side: str, difference: int | None) -> LineReport:
        del self._blocks[side]
        self._answer_of = _other(side)
        data = bytes(block.data)
        text = telegram_text(data)
        if block.damaged:
            text += f"; {block.damaged} damaged characters"
        if difference:
            text += f"; BCC wrong, off by {difference:02X}h" + (" (the sender includes STX)" if difference == Char.STX else "")
        return LineReport(
            block.last, side, "BLOCK", text, data, None if difference is None else not difference, difference or 0, block.first
        )


def _other(side: str) -> str:
    return "B" if side == "A" else "A"


@dataclass(frozen=True, slots=True)
class Telegram:
    """RK512 fields of a block; number None: a command."""

    job: str  # SEND FETCH REACTION FOLLOW-ON
    kind: str = ""
    db: int = 0
    word: int = 0
    amount: int = 0  # as in the header: words, or bytes of E A M
    data: bytes = b""
    number: int | None = None


def telegram_of(data: bytes) -> Telegram | None:
    """The telegram in a block, None where it is none of RK512."""
    if len(data) >= 4 and data[0] in (0x00, 0xFF) and data[1:3] == b"\x00\x00":
        return Telegram("REACTION", data=data[4:], number=data[3])
    if len(data) < 4 or data[1] != 0 or data[2] not in COMMANDS or data[3] not in TYPES:
        return None
    if data[0] == 0xFF:
        return Telegram("FOLLOW-ON", TYPES[data[3]], data=data[4:])
    if data[0] != 0x00 or len(data) < 10:
        return None
    return Telegram(COMMANDS[data[2]].split()[0], TYPES[data[3]], data[4], data[5], int.from_bytes(data[6:8], "big"), data[10:])


def telegram_text(data: bytes) -> str:
    """A block in words."""
    telegram = telegram_of(data)
    if telegram is None:
        return f"block of {len(data)}: {data[:32].hex(' ')}{' ...' if len(data) > 32 else ''}"
    match telegram.job:
        case "REACTION":
            number = telegram.number or 0
            head = f"reaction {number:02X}h {ERRORS.get(number, 'a number outside the tables')}"
        case "FOLLOW-ON":
            head = f"follow-on {telegram.kind}"
        case _ if telegram.kind in ("DB", "DX"):
            head = f"{telegram.job} {telegram.kind}{telegram.db}.DW{telegram.word}, {telegram.amount} words"
        case _:
            head = f"{telegram.job} {telegram.kind}{telegram.db << 8 | telegram.word}, amount {telegram.amount}"
    return f"{head}: {words_text(telegram.data)}" if telegram.data else head


def words_text(data: bytes) -> str:
    """Data words in KH."""
    words = [data[at : at + 2].hex().upper() for at in range(0, len(data), 2)]
    return " ".join(words[:SHOWN]) + (f" ... ({len(data)} bytes)" if len(words) > SHOWN else "")
