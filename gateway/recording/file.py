"""A recording as a file: written block by block by the recorder, read again up to its last complete block (AX-483)."""

import json
import os
import pathlib
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from gateway.pure.image.records.cell import CELL_STATE_LAYOUT
from gateway.pure.recording.blocks import MAGIC, Kind, Scan, decode, encode, whole_length
from gateway.pure.recording.messages import Message, What, unpack
from protocols.base.errors import DecodeError

FORMAT = "axisgate-record/1"
WRITE_BYTES = 1 << 16


class RecordError(Exception):
    """A file that is not a recording, or one this version cannot read; the message names the file and the remedy."""


class Writer:
    """Appends to one file.  Accepted data are on their way to the disk after `flush`."""

    def __init__(self, path: pathlib.Path, head: Mapping[str, Any], cell: bytes) -> None:
        """Begin a new file, or continue after the last complete block of one; `resumed` reports which."""
        self.resumed = path.exists() and path.stat().st_size > 0
        self._waiting, self._asides = bytearray(), bytearray()
        self._first: int | None = None
        self._last = self.sequence = 0
        self.goes_on_with: int | None = None  # the cycle that continues the file; None: it begins with a start
        if self.resumed:
            content = path.read_bytes()
            self.sequence, self.goes_on_with = _position(path, content, str(head["run"]))
            self._file = path.open("r+b")
            self._file.truncate(whole_length(content))
            self._file.seek(0, os.SEEK_END)
        else:
            self._file = path.open("w+b")
            self._file.write(MAGIC)
            self._block(Kind.HEAD, json.dumps(head).encode())
            self._block(Kind.CELL, cell)
        self.bytes = self._file.tell()

    def cycle(self, number: int, messages: bytes, sequence: int) -> None:
        """The messages of one cycle, complete up to this record of the ring."""
        self._first = number if self._first is None else self._first
        self._last, self.sequence = number, sequence
        self._waiting += self._asides + messages
        self._asides.clear()
        if len(self._waiting) >= WRITE_BYTES:
            self.flush()

    def aside(self, message: bytes) -> None:
        """No input of a cycle, but of this moment: it precedes the next one."""
        self._asides += message

    def start(self, cycle: int, tree: Any) -> None:
        """A state at rest, after this cycle."""
        self.flush()
        self._block(Kind.START, zlib.compress(json.dumps({"cycle": cycle, **tree}).encode(), 1))

    def lost(self, what: Mapping[str, Any]) -> None:
        """Something is missing from here on; the next start continues."""
        self.flush()
        self._block(Kind.LOST, json.dumps(what).encode())

    def flush(self) -> None:
        """Write the waiting records as a block."""
        if self._first is not None:
            head = json.dumps({"first": self._first, "last": self._last, "sequence": self.sequence}).encode()
            body = zlib.compress(bytes(self._waiting), 1)
            self._block(Kind.CYCLES, len(head).to_bytes(4, "little") + head + body)
            self._waiting.clear()
            self._first = None
        self._file.flush()
        self.bytes = self._file.tell()

    def end(self, why: Mapping[str, Any]) -> None:
        """On purpose."""
        self.flush()
        self._block(Kind.END, json.dumps(why).encode())
        self.close()

    def close(self) -> None:
        self._file.close()

    def _block(self, kind: Kind, payload: bytes) -> None:
        self._file.write(encode(kind, payload))


def _position(path: pathlib.Path, content: bytes, run: str) -> tuple[int, int | None]:
    """Record of the ring up to which the file of this run is complete, and the cycle that continues it; RecordError: not this run's."""
    found = _scanned(path, content)
    if found.head.get("run") != run:
        raise RecordError(f"{path}: contains another run ({found.head.get('cell', 'no cell')}); name another file")
    return found.sequence, found.segments[-1].last + 1 if found.continues else None


@dataclass(slots=True)
class Segment:
    """Cycles from one start on, without a gap."""

    start: Mapping[str, Any]
    blocks: list[bytes] = field(default_factory=list)
    cycles: int = 0
    last: int = 0

    def played(self) -> Iterator[tuple[int, list[Message]]]:
        """(cycle, its messages); messages outside a cycle (those of the start) are left out.  DecodeError."""
        script: list[Message] = []
        number = int(self.start["cycle"])
        for block in self.blocks:
            for message in unpack(_inflated(block)):
                if message.what is What.BEGIN and script:
                    yield number, script
                    script = []
                if message.what is What.BEGIN:
                    number += 1
                script.append(message)
        if script:
            yield number, script


@dataclass(slots=True)
class Found:
    """Content of a file."""

    head: Mapping[str, Any] = field(default_factory=dict)
    cell: bytes = b""
    segments: list[Segment] = field(default_factory=list)
    lost: list[Mapping[str, Any]] = field(default_factory=list)  # named by the recorder
    spoiled: Sequence[int] = ()  # places of blocks whose CRC is wrong
    cut: int = 0  # bytes of a half block at the end
    ended: bool = False
    continues: bool = False  # the following block may continue the last segment
    sequence: int = 0

    @property
    def cycles(self) -> int:
        return sum(segment.cycles for segment in self.segments)


def read(path: pathlib.Path) -> Found:
    """RecordError, OSError."""
    return _scanned(path, path.read_bytes())


def _scanned(path: pathlib.Path, content: bytes) -> Found:
    if not content.startswith(MAGIC):
        raise RecordError(f"{path}: no recording; axisgate record CELL -o {path.name} makes one")
    found, scan, open_segment, good = Found(), Scan(), None, 0
    try:
        for at, kind, payload in decode(content, scan):
            if len(scan.spoiled) > good:  # blocks are missing before this one
                good, open_segment = len(scan.spoiled), None
            if kind is Kind.HEAD:
                found.head = json.loads(payload)
            elif kind is Kind.CELL:
                found.cell = payload
            elif kind is Kind.START:
                open_segment = Segment(json.loads(_inflated(payload)))
                open_segment.last = int(open_segment.start["cycle"])
                found.segments.append(open_segment)
            elif kind is Kind.CYCLES:
                open_segment = _more(found, open_segment, payload, at)
            elif kind is Kind.LOST:
                found.lost.append(json.loads(payload))
                open_segment = None
            else:
                found.ended = True
    except (ValueError, KeyError, zlib.error) as error:
        raise RecordError(f"{path}: a complete block has content that this version does not know ({error})") from error
    if found.head.get("format") != FORMAT:
        raise RecordError(f"{path}: format {found.head.get('format', 'unknown')}; this version reads {FORMAT}")
    if found.head.get("state") != CELL_STATE_LAYOUT:
        by = found.head.get("version", "unknown")
        raise RecordError(
            f"{path}: recorded by axisgate {by}, whose records of a cycle differ from this version's; replay it there, or record it again"
        )
    found.continues = open_segment is not None
    found.spoiled, found.cut = scan.spoiled, scan.cut
    return found


def _more(found: Found, segment: Segment | None, payload: bytes, at: int) -> Segment | None:
    size = int.from_bytes(payload[:4], "little")
    head = json.loads(payload[4 : 4 + size])
    found.sequence = int(head["sequence"])
    if segment is None or head["first"] not in (segment.last, segment.last + 1):
        if segment is not None:
            found.lost.append({"after_cycle": segment.last, "why": f"cycles up to {head['first'] - 1} are not in the file (at {at})"})
        return None  # it continues no existing segment
    segment.blocks.append(payload[4 + size :])
    segment.cycles += int(head["last"]) - segment.last
    segment.last = int(head["last"])
    return segment


def _inflated(octets: bytes) -> bytes:
    try:
        return zlib.decompress(octets)
    except zlib.error as error:
        raise DecodeError(f"a block cannot be unpacked ({error})") from error
