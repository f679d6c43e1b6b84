"""Drive parameters over the bus: one request, one answer.  The transport is axisgate's own (AX-266): no manual describes it.

Request 300 + 10 n, answer 700 + 10 n, 8 bytes little endian: number, kind (request) or status (answer), sequence, 0, value (4 bytes:
int32, float32, or 0 / 1).  The answer carries the present value in the drive.
"""

import math
import struct
from enum import IntEnum
from typing import NamedTuple

from protocols.base.errors import DecodeError, EncodeError
from protocols.base.machine import Frame
from protocols.servodyn.plan import SLOTS

Value = bool | int | float
NUMBERS = range(1, 57)  # the manual's table goes to 56 (L7552-7578)


class Kind(IntEnum):
    FLAG, COUNT, REAL = range(3)


class Status(IntEnum):
    """Answers of the drive."""

    TAKEN = 0
    UNKNOWN = 1  # no such parameter
    RANGE = 2  # not a value this drive can have
    DRIVES_ON = 3  # power is on: nothing is changed


class Request(NamedTuple):
    number: int
    value: Value
    sequence: int = 0


class Answer(NamedTuple):
    number: int
    status: Status
    value: Value
    sequence: int = 0


_HEAD = struct.Struct("<BBBx")
_INT, _REAL = struct.Struct("<i"), struct.Struct("<f")


def request_id(slot: int) -> int:
    """Identifier of requests to module `slot` (1..6)."""
    return 300 + 10 * slot


def answer_id(slot: int) -> int:
    """Identifier of answers of module `slot` (1..6)."""
    return 700 + 10 * slot


SLOT_OF_REQUEST = {request_id(slot): slot for slot in range(1, SLOTS + 1)}
SLOT_OF_ANSWER = {answer_id(slot): slot for slot in range(1, SLOTS + 1)}


def kind_of(value: Value) -> Kind:
    """How a value travels."""
    return Kind.FLAG if isinstance(value, bool) else Kind.COUNT if isinstance(value, int) else Kind.REAL


def encode_request(slot: int, request: Request) -> Frame:
    """Raises EncodeError for a number or value that does not fit."""
    head = _HEAD.pack(_number(request.number), kind_of(request.value), request.sequence & 0xFF)
    return Frame(request_id(slot), head + _pack(request.number, request.value))


def decode_request(frame: Frame) -> tuple[int, Request]:
    """Slot and request.  Raises DecodeError."""
    slot = SLOT_OF_REQUEST.get(frame.identifier)
    if slot is None or len(frame.data) != 8:
        raise DecodeError(f"identifier {frame.identifier}: no parameter request: {frame.data.hex(' ')}")
    number, kind, sequence = _HEAD.unpack_from(frame.data)
    return slot, Request(number, _unpack(kind, frame.data), sequence)


def encode_answer(slot: int, answer: Answer) -> Frame:
    """Status in the low, kind in the high half of byte 1.  Raises EncodeError for a value that does not fit."""
    head = _HEAD.pack(answer.number & 0xFF, kind_of(answer.value) << 4 | answer.status, answer.sequence & 0xFF)
    return Frame(answer_id(slot), head + _pack(answer.number, answer.value))


def decode_answer(frame: Frame) -> tuple[int, Answer]:
    """Slot and answer.  Raises DecodeError."""
    slot = SLOT_OF_ANSWER.get(frame.identifier)
    if slot is None or len(frame.data) != 8:
        raise DecodeError(f"identifier {frame.identifier}: no parameter answer: {frame.data.hex(' ')}")
    number, how, sequence = _HEAD.unpack_from(frame.data)
    if how & 15 > max(Status):
        raise DecodeError(f"status {how & 15} of parameter {number} is unknown: {frame.data.hex(' ')}")
    return slot, Answer(number, Status(how & 15), _unpack(how >> 4, frame.data), sequence)


def _number(number: int) -> int:
    if number not in NUMBERS:
        raise EncodeError(f"parameter number {number} is outside 1..56")
    return number


def _pack(number: int, value: Value) -> bytes:
    try:
        return _REAL.pack(value) if isinstance(value, float) else _INT.pack(value)
    except (struct.error, OverflowError) as error:
        raise EncodeError(f"parameter {number} = {value} does not fit four bytes") from error


def _unpack(kind: int, data: bytes) -> Value:
    if kind == Kind.FLAG:
        return bool(_INT.unpack_from(data, 4)[0])
    if kind == Kind.COUNT:
        return int(_INT.unpack_from(data, 4)[0])
    if kind != Kind.REAL:
        raise DecodeError(f"kind {kind} of parameter {data[0]} is unknown: {data.hex(' ')}")
    value = float(_REAL.unpack_from(data, 4)[0])
    if not math.isfinite(value):
        raise DecodeError(f"parameter {data[0]} is not a number: {data.hex(' ')}")
    return value
