"""Passive RK512 station: serves SEND and FETCH and answers each telegram with a reaction telegram.

A telegram is one block of the link layer below.  Faults of the partner are answered with an error number and reported, never raised.  A job
is passed to the store completely: a SEND with its last follow-on telegram, a FETCH with its first telegram (AX-222).  Source: SIMATIC CP
341 manual 09/2008; numbers: protocols.rk512.header; choices: AX-053..055, AX-222, AX-223.
"""

from dataclasses import dataclass, field
from typing import Protocol

from protocols.base.machine import Ns, ms
from protocols.rk512.dialects import STANDARD, Dialect
from protocols.rk512.flags import Flags
from protocols.rk512.header import (
    BLOCK_TYPE,
    FIRST,
    FOLLOW_ON,
    FOLLOW_ON_BYTES,
    HEADER_BYTES,
    KINDS,
    MOST_BYTES,
    OTHER_TYPES,
    Command,
    ErrorNumber,
    Header,
    Kind,
    decode_header,
    encode_reaction,
    is_reaction,
)

FOLLOW_ON_WAIT = ms(20_000)  # the longest reaction time of any source; a job left open longer is dropped silently


class DataBlocks(Protocol):
    """The data blocks of the line.  One call is one job: accepted or refused completely."""

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber: ...  # 2 x words bytes; block missing or too short: BLOCK
    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None: ...  # None: written


class Areas(Protocol):
    """All other types; `block` is 0 except for extended data blocks, `amount` in words or bytes as the type has it (Kind.unit)."""

    def read_area(self, kind: Kind, block: int, address: int, amount: int) -> bytes | ErrorNumber: ...
    def write_area(self, kind: Kind, block: int, address: int, data: bytes) -> ErrorNumber | None: ...


class NoAreas:
    """A station that serves data blocks only."""

    def read_area(self, kind: Kind, block: int, address: int, amount: int) -> bytes | ErrorNumber:
        return ErrorNumber.TYPE_NOT_SERVED

    def write_area(self, kind: Kind, block: int, address: int, data: bytes) -> ErrorNumber | None:
        return ErrorNumber.TYPE_NOT_SERVED


@dataclass(frozen=True, slots=True)
class Written:
    """A SEND was accepted completely; `word` is the address as its type counts it."""

    db: int
    word: int
    data: bytes
    kind: int = BLOCK_TYPE


@dataclass(frozen=True, slots=True)
class Fetched:
    """A FETCH was answered; for a long one this is the first telegram, the rest leaves on the partner's requests."""

    db: int
    word: int
    words: int
    kind: int = BLOCK_TYPE


@dataclass(frozen=True, slots=True)
class Continued:
    """One more telegram of a long job; so many of its data bytes are still missing."""

    missing: int


@dataclass(frozen=True, slots=True)
class Refused:
    """A command was refused with this number; `head` are the first bytes of the telegram."""

    number: int
    why: str
    head: bytes


@dataclass(frozen=True, slots=True)
class UnexpectedReaction:
    """A reaction telegram without a request; it is never answered (AX-054)."""

    head: bytes


__all__ = [
    "Areas",
    "Continued",
    "DataBlocks",
    "Dialect",
    "ErrorNumber",
    "Event",
    "Fetched",
    "Passive",
    "Refused",
    "UnexpectedReaction",
    "Written",
]

Event = Written | Fetched | Continued | Refused | UnexpectedReaction
Fault = tuple[int, str]  # error number, in words


@dataclass(slots=True)
class _Open:
    """A job of which follow-on telegrams are still to come."""

    header: Header
    missing: int  # bytes
    since: Ns
    data: bytearray = field(default_factory=bytearray)  # SEND: data so far; FETCH: data still to deliver


class Passive:
    """Answers one telegram after another."""

    def __init__(self, blocks: DataBlocks, dialect: Dialect | None = None, areas: Areas | None = None, flags: Flags | None = None) -> None:
        self._blocks, self._dialect, self._areas = blocks, dialect or STANDARD, areas or NoAreas()
        self.flags = flags or Flags()
        self.stopped = False  # True: every job is answered with 2Ah
        self._open: _Open | None = None
        self._output: bytes | None = None

    def telegram(self, data: bytes, now: Ns) -> list[Event]:
        """Serve one block of the link; its reaction waits in take_output."""
        if is_reaction(data):
            return [UnexpectedReaction(data[:HEADER_BYTES])]
        if self._open is not None and now - self._open.since > FOLLOW_ON_WAIT:
            self._open = None
        fault = self._form(data)
        if fault is not None:
            return [self._refuse(fault, data)]
        return [self._follow_on(data, now) if data[0] == FOLLOW_ON else self._first(data, now)]

    def take_output(self) -> bytes | None:
        """The reaction telegram for the link, once; None: no reaction."""
        output, self._output = self._output, None
        return output

    def forget(self) -> None:
        """An incomplete job has no effect: its partner restarts it."""
        self._open = None

    def lost(self) -> None:
        """The port is lost: an incomplete job has no effect."""
        self._open = self._output = None

    # ---- checks, in the order of the bytes
    def _form(self, data: bytes) -> Fault | None:
        if not data or data[0] not in (FIRST, FOLLOW_ON):
            return ErrorNumber.HEADER, "byte 1 is neither 00 nor FF"
        if data[0] == FOLLOW_ON:
            return self._form_of_follow_on(data)
        if self._open is not None:
            return ErrorNumber.SEQUENCE, f"a first telegram, follow-on expected: {self._open.missing} bytes are missing"
        if len(data) < HEADER_BYTES:
            return ErrorNumber.LENGTH, f"{len(data)} bytes are too short for a header of {HEADER_BYTES}"
        if data[1] != 0:
            return ErrorNumber.HEADER, "byte 2 is not 00"
        return None

    def _form_of_follow_on(self, data: bytes) -> Fault | None:
        if self._open is None:
            return ErrorNumber.SEQUENCE, "follow-on telegram without a first one"
        if len(data) < FOLLOW_ON_BYTES:
            return ErrorNumber.LENGTH, f"{len(data)} bytes are too short for a follow-on telegram"
        if data[1] != 0:
            return ErrorNumber.HEADER, "byte 2 is not 00"
        if (data[2], data[3]) != (self._open.header.command, self._open.header.kind):
            return ErrorNumber.SEQUENCE, "follow-on telegram of another command or type than the first one"
        return None

    def _faults_of(self, header: Header, data_bytes: int) -> Fault | None:
        if self.stopped:
            return ErrorNumber.STOPPED, "stopped"
        return self._wrong_kind(header) or self._wrong_amount(header, data_bytes) or self._wrong_target(header)

    def _wrong_kind(self, header: Header) -> Fault | None:
        if header.command not in tuple(Command):
            return ErrorNumber.COMMAND, f"command {header.command:02X}h is neither A, O nor E"
        if header.kind not in KINDS and header.kind not in OTHER_TYPES:
            return ErrorNumber.TYPE_INVALID, f"type {header.kind:02X}h is unknown"
        kind = _target(header)
        if kind is None:
            return ErrorNumber.TYPE_NOT_SERVED, f"{chr(header.command)}{chr(header.kind)} is not served"
        if header.command != Command.FETCH and kind not in self._dialect.send_kinds:
            return ErrorNumber.TYPE_NOT_SERVED, f"SEND to {chr(kind)} is not served"
        return None

    def _wrong_amount(self, header: Header, data_bytes: int) -> Fault | None:
        total = _total(header)
        if total > self._dialect.served_bytes:
            return ErrorNumber.HEADER, f"{total} bytes, at most {self._dialect.served_bytes} are served in one job"
        expected = 0 if header.command == Command.FETCH else min(total, MOST_BYTES)
        if total == 0 or data_bytes != expected:
            return ErrorNumber.LENGTH, f"header announces {total} bytes, {data_bytes} data bytes received, {expected} expected"
        return None

    def _wrong_target(self, header: Header) -> Fault | None:
        flag = header.flag
        if flag is not None and self._dialect.coordination_flag == "refuse":
            return ErrorNumber.LOCKED, f"coordination flag {flag.byte}.{flag.bit}: none here"
        if self._dialect.coordination_flag == "serve" and self.flags.locks(flag):
            return ErrorNumber.LOCKED, "the coordination flag is set: the previous data have not been used yet"
        if _kind(header).in_blocks and self._dialect.db_address_unit == "byte" and header.address % 2:
            return ErrorNumber.BLOCK, f"byte address {header.address} is odd"
        return None

    # ---- jobs
    def _first(self, data: bytes, now: Ns) -> Event:
        header = decode_header(data)
        fault = self._faults_of(header, len(data) - HEADER_BYTES)
        if fault is not None:
            return self._refuse(fault, data)
        if header.command == Command.FETCH:
            return self._fetch(header, data, now)
        total = _total(header)
        if total <= MOST_BYTES:
            return self._write(header, data[HEADER_BYTES:], data)
        there = self._read(header)  # a block that is not there is reported at once, not after the last telegram
        if isinstance(there, ErrorNumber):
            return self._refuse((self._reported(there), f"{self._place(header)}: not there"), data)
        self._open = _Open(header, total - MOST_BYTES, now, bytearray(data[HEADER_BYTES:]))
        self._answer(encode_reaction(ErrorNumber.NONE))
        return Continued(self._open.missing)

    def _follow_on(self, data: bytes, now: Ns) -> Event:
        job, piece = self._open, data[FOLLOW_ON_BYTES:]
        assert job is not None  # _form_of_follow_on
        fetch = job.header.command == Command.FETCH
        amount = min(job.missing, MOST_BYTES)
        if len(piece) != (0 if fetch else amount):
            return self._refuse((ErrorNumber.LENGTH, f"{len(piece)} data bytes in a follow-on telegram, {amount} are next"), data)
        job.missing, job.since = job.missing - amount, now
        self._open = job if job.missing else None
        if fetch:
            self._answer(encode_reaction(ErrorNumber.NONE, bytes(job.data[:amount]), self._dialect.follow_on_reaction))
            del job.data[:amount]
            return Continued(job.missing)
        job.data += piece
        if job.missing == 0:
            return self._write(job.header, bytes(job.data), data)
        self._answer(encode_reaction(ErrorNumber.NONE, follow_on=self._dialect.follow_on_reaction))
        return Continued(job.missing)

    def _write(self, header: Header, content: bytes, data: bytes) -> Event:
        kind, block, address = self._where(header)
        in_block = kind is Kind.BLOCK
        number = self._blocks.write(block, address, content) if in_block else self._areas.write_area(kind, block, address, content)
        if number is not None:
            return self._refuse((self._reported(number), f"{self._place(header)}: not written"), data)
        self.flags.take(header.flag if self._dialect.coordination_flag == "serve" else None)
        self._answer(encode_reaction(ErrorNumber.NONE, follow_on=self._dialect.follow_on_reaction and data[0] == FOLLOW_ON))
        return Written(block, address, content, kind)

    def _fetch(self, header: Header, data: bytes, now: Ns) -> Event:
        kind, block, address = self._where(header)
        content = self._read(header)
        if isinstance(content, ErrorNumber):
            return self._refuse((self._reported(content), f"{self._place(header)}: not read"), data)
        self.flags.take(header.flag if self._dialect.coordination_flag == "serve" else None)
        self._answer(encode_reaction(ErrorNumber.NONE, content[:MOST_BYTES]))
        if len(content) > MOST_BYTES and self._dialect.reaction:
            self._open = _Open(header, len(content) - MOST_BYTES, now, bytearray(content[MOST_BYTES:]))
        return Fetched(block, address, header.amount, kind)

    def _read(self, header: Header) -> bytes | ErrorNumber:
        kind, block, address = self._where(header)
        in_block = kind is Kind.BLOCK
        return self._blocks.read(block, address, header.amount) if in_block else self._areas.read_area(kind, block, address, header.amount)

    def _where(self, header: Header) -> tuple[Kind, int, int]:
        """Type, block, and word, byte or number."""
        kind = _kind(header)
        if not kind.in_blocks:
            return kind, 0, header.db << 8 | header.address
        return kind, header.db, header.address // 2 if self._dialect.db_address_unit == "byte" else header.address

    def _place(self, header: Header) -> str:
        kind, block, address = self._where(header)
        return (
            f"{chr(kind)} {block} {address}, amount {header.amount}" if kind.in_blocks else f"{chr(kind)} {address}, amount {header.amount}"
        )

    def _reported(self, number: ErrorNumber) -> int:
        return self._dialect.unknown_block if number == ErrorNumber.BLOCK else number

    def _refuse(self, fault: Fault, data: bytes) -> Refused:
        """Any refusal also ends a job that is open: its sender begins again."""
        number, why = fault
        self._open = None
        follow_on = self._dialect.follow_on_reaction and data[:1] == bytes((FOLLOW_ON,))
        self._answer(encode_reaction(number, follow_on=follow_on))
        return Refused(number, why, data[:HEADER_BYTES])

    def _answer(self, reaction: bytes) -> None:
        if self._dialect.reaction:
            self._output = reaction


def _target(header: Header) -> Kind | None:
    """The target of the job: a SEND to DX is OX or OD (AX-223); None: no station has such a pair."""
    if header.command == Command.SEND_EXTENDED:
        return Kind.EXTENDED if header.kind in (Kind.BLOCK, Kind.EXTENDED) else None
    if header.kind not in KINDS or (header.command == Command.SEND and header.kind == Kind.EXTENDED):
        return None
    return Kind(header.kind)


def _kind(header: Header) -> Kind:
    kind = _target(header)
    assert kind is not None  # _wrong_kind has refused it
    return kind


def _total(header: Header) -> int:
    return header.amount * _kind(header).unit
