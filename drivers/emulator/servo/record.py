"""The emulator's own record: the true motion of every axis, written by a side without influence on it (the witness of the figures).

File: one header line of JSON ending in a newline, then rows of fixed size, little endian, without padding: int64 bus stamp ns, uint32
number of the SYNC, then for each axis of the header's "axes" in order: int32 position_inc (latched), int32 set_inc, float64
position_rad, float64 speed_rad_s, float64 torque_nm, uint8 state, uint8 fault, uint16 flags.

`set_inc` is the demanded position of the axis at this SYNC: the value the previous SYNC activated, reached by interpolation.  So
the lag of a row is set_inc - position_inc (int32, wraps).  There is one row per SYNC; while SYNC is lost and anything still moves there is
one every P5 with the last SYNC's number and the flag NO_SYNC.  A row cut short by the death of the writer is left out by `read`.
"""

import json
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import IntFlag
from typing import NamedTuple

from protocols.base.errors import DecodeError

FORMAT = "axisgate servo record 1"
_HEAD = struct.Struct("<qI")
_AXIS = struct.Struct("<iidddBBH")


class Flag(IntFlag):
    NO_SYNC = 1  # row between SYNCs, made because SYNC is lost
    NEW_SET = 2  # a set value was received since the SYNC before
    ENABLED = 4
    BRAKE_OPEN = 8
    REFERENCE_SWITCH = 16
    LIMIT = 32
    WARNING = 64
    POWER_ON = 128


class AxisRow(NamedTuple):
    position_inc: int
    set_inc: int
    position_rad: float  # at the motor shaft
    speed_rad_s: float
    torque_nm: float
    state: int  # drivers.emulator.servodyn.axis.State
    fault: int  # drivers.emulator.servodyn.axis.Fault
    flags: int


class Row(NamedTuple):
    stamp_ns: int
    sync: int
    axes: tuple[AxisRow, ...]


@dataclass(frozen=True, slots=True)
class Record:
    axes: tuple[int, ...]  # modules, in the order of Row.axes
    header: Mapping[str, object]
    rows: tuple[Row, ...]


def header(axes: tuple[int, ...], settings: Mapping[str, object]) -> bytes:
    """First line of a record; `settings` as of drivers.emulator.servo.settings.to_dict."""
    return json.dumps({"format": FORMAT, "axes": list(axes), "row_bytes": row_bytes(len(axes)), "settings": settings}).encode() + b"\n"


def row_bytes(axes: int) -> int:
    return _HEAD.size + axes * _AXIS.size


def pack(stamp_ns: int, sync: int, axes: list[AxisRow]) -> bytes:
    return _HEAD.pack(stamp_ns, sync & 0xFFFFFFFF) + b"".join([_AXIS.pack(*axis) for axis in axes])


def read(data: bytes) -> Record:
    """Read a complete record.  Raises DecodeError when the header is a foreign one."""
    line, found, body = data.partition(b"\n")
    try:
        head = json.loads(line)
    except ValueError:
        head = None
    if not found or not isinstance(head, dict) or head.get("format") != FORMAT:
        raise DecodeError(f'"{FORMAT}" expected in the first line, found {line[:60]!r}')
    axes = tuple(int(axis) for axis in head["axes"])
    return Record(axes, head, tuple(_rows(body, len(axes))))


def _rows(body: bytes, axes: int) -> Iterator[Row]:
    size = row_bytes(axes)
    for start in range(0, len(body) - size + 1, size):
        stamp, sync = _HEAD.unpack_from(body, start)
        places = range(start + _HEAD.size, start + size, _AXIS.size)
        yield Row(stamp, sync, tuple(AxisRow(*_AXIS.unpack_from(body, place)) for place in places))
