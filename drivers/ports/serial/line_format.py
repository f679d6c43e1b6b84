"""Pure forms of a byte line: format, character time, PARMRK marks in the stream, drain, and the record of the line process.

PARMRK form (termios(3)): FF FF = the character FF, FF 00 00 = BREAK, FF 00 xx = xx came with a parity or framing error.
The line process also uses FF 01 xx = framing and FF 02 xx = overrun, which no kernel sends (AX-060).

Record of the line process, one line for each run of characters of one side that left the line at one moment:

    <ns> <A|B> <hex> [mark]      stamp: end of the last character of the run, CLOCK_MONOTONIC; A or B: who sent it; hex: as it was sent
    # <ns> <what happened>       a command or an event at the line: unplug, plug, remove A, insert A, damage ..., ready <key>=<value> ...

Marks: `lost` at the broken cable, `gone` no adapter at the receiving side, `overflow` no reader there; `parity`, `framing`, `overrun`,
`break` delivered damaged; `flip=<hex>` delivered as that other character without any mark; `drop` vanished.  No mark: delivered as sent.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from protocols.base.errors import DecodeError
from protocols.base.machine import Damage, Ns

FF = b"\xff"
MARK_OF = {Damage.PARITY: 0, Damage.FRAMING: 1, Damage.OVERRUN: 2}  # second byte of a mark
KIND_OF = {second: kind for kind, second in MARK_OF.items()}


@dataclass(frozen=True, slots=True)
class LineFormat:
    """Meaning of "9600 8E1".  baud 0: the line has no pace of its own (a pty without line process, a TCP partner without serial line)."""

    baud: int
    data_bits: int = 8
    parity: str = "E"  # N, E, O
    stop_bits: int = 1

    @property
    def char_bits(self) -> int:
        """Bits of one character on the line: start, data, parity, stop."""
        return 1 + self.data_bits + (self.parity != "N") + self.stop_bits

    @property
    def char_ns(self) -> Ns:
        """Time of one character on the line, rounded up; 0 without a pace."""
        return -(-self.char_bits * 1_000_000_000 // self.baud) if self.baud else 0

    def __str__(self) -> str:
        return f"{self.baud} {self.data_bits}{self.parity}{self.stop_bits}"


def parse_format(text: str) -> LineFormat:
    """ "9600 8E1" or "9600" (8E1, the usual frame of 3964R) or "0" (no pace).  Raises ValueError naming the text and the valid forms."""
    found = re.fullmatch(r"\s*(\d{1,7})(?:\s+([5-8])([NEO])([12]))?\s*", text, re.IGNORECASE)
    if not found:
        raise ValueError(f'line format "{text}": baud rate, data bits 5..8, parity N|E|O, stop bits 1|2 expected, e.g. "9600 8E1"')
    baud, data, parity, stop = found.groups()
    if (data, stop) == ("5", "2"):
        raise ValueError(f'line format "{text}": a UART makes one and a half stop bits of two where there are 5 data bits; 1 expected')
    return LineFormat(int(baud), int(data or 8), (parity or "E").upper(), int(stop or 1))


class Drain:
    """When bytes on a line without a drain signal will have left it: computed from count and character time."""

    def __init__(self, char_ns: Ns) -> None:
        self.char_ns = char_ns
        self._empty_at: Ns = 0

    def took(self, count: int, now: Ns) -> None:
        """The line accepted `count` bytes at `now`; they leave one by one after those still on it."""
        self._empty_at = max(self._empty_at, now) + count * self.char_ns

    def answered(self, now: Ns) -> None:
        """The far end answered, and no line is known that delays what it receives: nothing is on the way any more (AX-652)."""
        self._empty_at = min(self._empty_at, now)

    def left(self, now: Ns) -> int:
        """How many characters are not out yet (a character under way counts)."""
        return -(-(self._empty_at - now) // self.char_ns) if self._empty_at > now else 0


def escape(data: bytes) -> bytes:
    """Good characters in PARMRK form."""
    return data.replace(FF, b"\xff\xff") if FF in data else data


def mark(kind: Damage, byte: int = 0) -> bytes:
    """A damaged character in PARMRK form; for parity, `byte` must not be 0, which would read as BREAK."""
    return b"\xff\x00\x00" if kind is Damage.BREAK else bytes((0xFF, MARK_OF[kind], byte))


class MarkReader:
    """Decodes the PARMRK form; a mark may be split over several reads.  Never raises on received bytes."""

    def __init__(self) -> None:
        self._torn = b""

    def read(self, data: bytes) -> list[bytes | Damage]:
        """Good runs and damages in line order."""
        if self._torn:
            data, self._torn = self._torn + data, b""
        at = data.find(FF)
        if at < 0:
            return [data]
        items: list[bytes | Damage] = []
        good = bytearray()
        start = 0
        while at >= 0:
            good += data[start:at]
            piece = data[at : at + 3]
            if len(piece) < 2 or (len(piece) < 3 and piece[1] in KIND_OF):
                self._torn, start = piece, len(data)
                break
            if piece[1] in KIND_OF:
                if good:
                    items.append(bytes(good))
                    good.clear()
                items.append(Damage.BREAK if piece == b"\xff\x00\x00" else KIND_OF[piece[1]])
                start = at + 3
            else:
                good += FF
                start = at + (2 if piece[1] == 0xFF else 1)  # FF and another byte: a writer that does not escape; both count
            at = data.find(FF, start)
        good += data[start:]
        if good:
            items.append(bytes(good))
        return items


class Run(NamedTuple):
    """Characters of one side that left the line at one moment."""

    stamp_ns: Ns
    side: str  # "A" or "B": who sent them
    data: bytes  # as sent
    mark: str = ""  # "": delivered as sent

    def line(self) -> str:
        """The record's line."""
        return f"{self.stamp_ns} {self.side} {self.data.hex()}{' ' if self.mark else ''}{self.mark}\n"


class Note(NamedTuple):
    """A command or event at the line."""

    stamp_ns: Ns
    text: str

    def line(self) -> str:
        """The record's line."""
        return f"# {self.stamp_ns} {self.text}\n"


@dataclass(frozen=True, slots=True)
class Record:
    """A complete record."""

    runs: list[Run] = field(default_factory=list)
    notes: list[Note] = field(default_factory=list)

    def between(self, start_ns: Ns, end_ns: Ns) -> list[Run]:
        """Runs with start_ns <= stamp <= end_ns."""
        return [run for run in self.runs if start_ns <= run.stamp_ns <= end_ns]

    def sent_by(self, side: str) -> bytes:
        """Everything a side sent, delivered or not."""
        return b"".join(run.data for run in self.runs if run.side == side)

    def stamps(self, side: str) -> list[Ns]:
        """One stamp for each character of a side."""
        return [run.stamp_ns for run in self.runs if run.side == side for _ in run.data]

    def characters(self) -> int:
        """Characters of both sides."""
        return sum(len(run.data) for run in self.runs)


def parse_record(lines: Iterable[str]) -> Record:
    """Reads a record; a torn last line (a writer killed) is left out.  Raises DecodeError naming the line that does not fit."""
    record = Record()
    for number, line in enumerate(lines, 1):
        if not line.endswith("\n"):
            break
        words = line.split()
        try:
            if words[0] == "#":
                record.notes.append(Note(int(words[1]), " ".join(words[2:])))
            elif words[1] in ("A", "B") and len(words) <= 4:
                record.runs.append(Run(int(words[0]), words[1], bytes.fromhex(words[2]), words[3] if len(words) > 3 else ""))
            else:
                raise ValueError(words[1])
        except (ValueError, IndexError) as error:
            raise DecodeError(f"line record, line {number}: {line[:60]!r}") from error
    return record
