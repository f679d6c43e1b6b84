"""Passive RK512 station: serves SEND and FETCH on data blocks and answers each with a reaction telegram.

A telegram is one block of the link layer below.  What the partner does wrong is answered with an error number and reported,
never raised.  Source: SIMATIC CP 341 manual 09/2008; numbers: protocols.rk512.header; choices: AX-053..055.
"""

from dataclasses import dataclass
from typing import Protocol

from protocols.base.machine import Ns
from protocols.rk512.header import (
    BLOCK_TYPE,
    FIRST,
    FOLLOW_ON,
    HEADER_BYTES,
    MOST_WORDS,
    OTHER_TYPES,
    Command,
    ErrorNumber,
    Header,
    decode_header,
    encode_reaction,
    is_reaction,
)


class DataBlocks(Protocol):
    """The data blocks behind the line.  One call is one telegram: taken or refused as a whole."""

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber: ...  # 2 x words bytes; block missing or too short: BLOCK
    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None: ...  # None: written


@dataclass(frozen=True, slots=True)
class PassiveSettings:
    """One line's settings; names as in the cell file."""

    db_address_unit: str = "word"  # what byte 6 of the header counts: word | byte
    reaction: bool = True  # False: the partner expects no reaction telegram
    unknown_block: int = ErrorNumber.BLOCK  # what this partner is told where the store answers BLOCK
    coordination_flag: str = "refuse"  # a job that names one (there are none here): refuse (32h) | ignore
    follow_on_reaction: bool = True  # refusals of a follow-on begin with FF, as CP 341 has it; False: 00


@dataclass(frozen=True, slots=True)
class Written:
    """A SEND was taken; `data` are 2 x words bytes."""

    db: int
    word: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Fetched:
    """A FETCH was answered with so many words."""

    db: int
    word: int
    words: int


@dataclass(frozen=True, slots=True)
class Refused:
    """A command was refused with this number; `head` are the first bytes of the telegram."""

    number: int
    why: str
    head: bytes


@dataclass(frozen=True, slots=True)
class UnexpectedReaction:
    """A reaction telegram came though nothing was asked; it is never answered (AX-054)."""

    head: bytes


__all__ = ["DataBlocks", "ErrorNumber", "Event", "Fetched", "Passive", "PassiveSettings", "Refused", "UnexpectedReaction", "Written"]

Event = Written | Fetched | Refused | UnexpectedReaction
Fault = tuple[int, str]  # error number, in words


class Passive:
    """Answers one telegram after another."""

    def __init__(self, blocks: DataBlocks, settings: PassiveSettings | None = None) -> None:
        self._blocks, self._settings = blocks, settings or PassiveSettings()
        self._output: bytes | None = None

    def telegram(self, data: bytes, now: Ns) -> list[Event]:
        """Serve one block of the link; its reaction waits in take_output."""
        if is_reaction(data):
            return [UnexpectedReaction(data[:HEADER_BYTES])]
        fault = self._form(data)
        if fault is not None:
            return [self._refuse(fault, data)]
        header = decode_header(data)
        fault = self._faults_of(header, data)
        if fault is not None:
            return [self._refuse(fault, data)]
        return [self._write(header, data) if header.command == Command.SEND else self._fetch(header, data)]

    def take_output(self) -> bytes | None:
        """The reaction telegram to hand to the link, once; None: nothing to say."""
        output, self._output = self._output, None
        return output

    # ---- checks, in the order in which the bytes stand
    def _form(self, data: bytes) -> Fault | None:
        if not data or data[0] not in (FIRST, FOLLOW_ON):
            return ErrorNumber.HEADER, "byte 1 is neither 00 nor FF"
        if data[0] == FOLLOW_ON:
            return ErrorNumber.SEQUENCE, "follow-on telegram without a first one"
        if len(data) < HEADER_BYTES:
            return ErrorNumber.LENGTH, f"{len(data)} bytes are too short for a header of {HEADER_BYTES}"
        if data[1] != 0:
            return ErrorNumber.HEADER, "byte 2 is not 00"
        return None

    def _faults_of(self, header: Header, data: bytes) -> Fault | None:
        return self._wrong_kind(header) or self._wrong_amount(header, len(data) - HEADER_BYTES) or self._wrong_target(header)

    def _wrong_kind(self, header: Header) -> Fault | None:
        if header.command not in tuple(Command):
            return ErrorNumber.COMMAND, f"command {header.command:02X}h is neither A, O nor E"
        if header.kind != BLOCK_TYPE and header.kind not in OTHER_TYPES:
            return ErrorNumber.TYPE_INVALID, f"type {header.kind:02X}h is unknown"
        if header.kind != BLOCK_TYPE or header.command == Command.SEND_EXTENDED:
            return ErrorNumber.TYPE_NOT_SERVED, f"{chr(header.command)}{chr(header.kind)} is not served, only AD and ED"
        return None

    def _wrong_amount(self, header: Header, data_bytes: int) -> Fault | None:
        if header.amount > MOST_WORDS:
            return ErrorNumber.HEADER, f"{header.amount} words need follow-on telegrams, at most {MOST_WORDS} are served"
        expected = 2 * header.amount if header.command == Command.SEND else 0
        if header.amount == 0 or data_bytes != expected:
            return ErrorNumber.LENGTH, f"header announces {header.amount} words, {data_bytes} data bytes came"
        return None

    def _wrong_target(self, header: Header) -> Fault | None:
        if header.flag is not None and self._settings.coordination_flag != "ignore":
            return ErrorNumber.LOCKED, f"coordination flag {header.flag.byte}.{header.flag.bit}: none here"
        if self._settings.db_address_unit == "byte" and header.address % 2:
            return ErrorNumber.BLOCK, f"byte address {header.address} is odd"
        return None

    # ---- the two jobs
    def _write(self, header: Header, data: bytes) -> Event:
        word, content = self._word(header), data[HEADER_BYTES:]
        number = self._blocks.write(header.db, word, content)
        if number is not None:
            return self._refuse((self._told(number), f"DB {header.db} DW {word}, {header.amount} words: not written"), data)
        self._answer(encode_reaction(ErrorNumber.NONE))
        return Written(header.db, word, content)

    def _fetch(self, header: Header, data: bytes) -> Event:
        word = self._word(header)
        content = self._blocks.read(header.db, word, header.amount)
        if isinstance(content, ErrorNumber):
            return self._refuse((self._told(content), f"DB {header.db} DW {word}, {header.amount} words: not read"), data)
        self._answer(encode_reaction(ErrorNumber.NONE, content))
        return Fetched(header.db, word, header.amount)

    def _word(self, header: Header) -> int:
        return header.address // 2 if self._settings.db_address_unit == "byte" else header.address

    def _told(self, number: ErrorNumber) -> int:
        return self._settings.unknown_block if number == ErrorNumber.BLOCK else number

    def _refuse(self, fault: Fault, data: bytes) -> Refused:
        number, why = fault
        follow_on = self._settings.follow_on_reaction and data[:1] == bytes((FOLLOW_ON,))
        self._answer(encode_reaction(number, follow_on=follow_on))
        return Refused(number, why, data[:HEADER_BYTES])

    def _answer(self, reaction: bytes) -> None:
        if self._settings.reaction:
            self._output = reaction
