"""Pieces of path: what planner and stepper agree on, and their record in the ring (design 6).

A piece is q(s) for 0 <= s <= length, polynomials in s per axis, with the highest legal sdot^2 on an even grid over s,
the highest |sddot| and |s jerk|, and its end condition.  It holds no time: override, stop and resume change time along
the path and never the path.  q in m or rad; s has any unit the planner likes (plan_ptp: travel of the longest axis).

Record, little endian: magic "AXPC", version u16, flags u16 (bit 0 ends at rest), id u32, mask u32, segments u8, table
points u8, 0 u16, CRC-32 u32 over everything but itself; length, accel, jerk f64; MAX_SEGMENTS x (end_s f64, room x
MAX_COEFFICIENTS f64, axes of the mask first, unused ones 0); MAX_TABLE f64, unused ones 0.  Room is ROOM axes, or as many
as the mask has where it has more: a record is as long as its piece needs, and never shorter than one of ROOM axes (AX-572).
"""

import math
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

from motion.errors import PieceError

MAX_AXES = 32  # of one piece
ROOM = 12  # axes every record has room for
MAX_SEGMENTS = 4
MAX_COEFFICIENTS = 6  # degree 5
MAX_TABLE = 33
JOIN = 1e-9  # m or rad (position), relative (slope): largest step where two segments meet


@dataclass(frozen=True)
class Segment:
    """One polynomial for each axis of the piece, up to s = end_s."""

    end_s: float
    coefficients: tuple[tuple[float, ...], ...]  # [axis of the mask][power], in (s - start of the segment)

    def position(self, u: float) -> tuple[float, ...]:
        """q per axis of the mask at u = s - start of the segment."""
        return tuple(_horner(row, u) for row in self.coefficients)

    def slope(self, u: float) -> tuple[float, ...]:
        """dq/ds per axis of the mask."""
        return tuple(_horner(tuple(k * c for k, c in enumerate(row))[1:], u) for row in self.coefficients)


def _horner(row: tuple[float, ...], u: float) -> float:
    value = 0.0
    for coefficient in reversed(row):
        value = value * u + coefficient
    return value


@dataclass(frozen=True)
class Piece:
    """See the module; raises PieceError when it contradicts itself."""

    id: int  # 1 .. 2^32-1
    mask: int  # bit n: axis n moves
    length: float  # >= 0; 0: a piece that is done at once
    segments: tuple[Segment, ...]
    table: tuple[float, ...]  # highest legal sdot^2 at s = k * length / (len - 1), linear between
    accel: float  # highest |sddot|
    jerk: float  # highest |s jerk|
    ends_at_rest: bool = True
    _starts: tuple[float, ...] = field(init=False, repr=False, compare=False, default=())

    def __post_init__(self) -> None:
        _check_head(self)
        _check_segments(self)
        object.__setattr__(self, "_starts", (0.0, *(segment.end_s for segment in self.segments[:-1])))
        _check_joins(self)

    @cached_property
    def axes(self) -> tuple[int, ...]:
        """Numbers of the moving axes, ascending."""
        return axes_of(self.mask)

    def start(self) -> tuple[float, ...]:
        """q at s = 0, per axis of the mask."""
        return self.segments[0].position(0.0)

    def end(self) -> tuple[float, ...]:
        """q at s = length, per axis of the mask."""
        return self.position(self.length)

    def position(self, s: float) -> tuple[float, ...]:
        """q at s, per axis of the mask."""
        index = self.segment_at(s)
        return self.segments[index].position(s - self._starts[index])

    def slope(self, s: float) -> tuple[float, ...]:
        """dq/ds at s, per axis of the mask."""
        index = self.segment_at(s)
        return self.segments[index].slope(s - self._starts[index])

    def segment_at(self, s: float) -> int:
        """Number of the segment s lies in; beyond the ends the first or last."""
        last = len(self.segments) - 1
        return next((i for i in range(last) if s < self.segments[i].end_s), last)


def axes_of(mask: int) -> tuple[int, ...]:
    """Bit numbers set in mask, rising."""
    return tuple(n for n in range(mask.bit_length()) if mask >> n & 1)


def _check_head(piece: Piece) -> None:
    if not 1 <= piece.id < 1 << 32:
        raise PieceError(f"piece id {piece.id} is outside 1 .. {(1 << 32) - 1}")
    if not 0 < piece.mask < 1 << MAX_AXES:
        raise PieceError(f"piece {piece.id}: axis mask {piece.mask:#x} is outside 1 .. {(1 << MAX_AXES) - 1:#x}")
    if not (math.isfinite(piece.length) and piece.length >= 0):
        raise PieceError(f"piece {piece.id}: length {piece.length} is not a number >= 0")
    for name, value in (("sddot limit", piece.accel), ("s jerk limit", piece.jerk)):
        if not (math.isfinite(value) and value > 0):
            raise PieceError(f"piece {piece.id}: {name} {value} is not a number > 0")
    if not 2 <= len(piece.table) <= MAX_TABLE:
        raise PieceError(f"piece {piece.id}: {len(piece.table)} points in the sdot^2 table, 2 .. {MAX_TABLE} allowed")
    if not all(math.isfinite(value) and value > 0 for value in piece.table):
        raise PieceError(f"piece {piece.id}: the sdot^2 table contains a value that is not a number > 0")


def _check_segments(piece: Piece) -> None:
    if not 1 <= len(piece.segments) <= MAX_SEGMENTS:
        raise PieceError(f"piece {piece.id}: {len(piece.segments)} segments, 1 .. {MAX_SEGMENTS} allowed")
    before = 0.0
    for number, segment in enumerate(piece.segments):
        if not (segment.end_s > before or (len(piece.segments) == 1 and segment.end_s == 0.0)):
            raise PieceError(f"piece {piece.id}: segment {number} ends at s = {segment.end_s}, not after {before}")
        before = segment.end_s
        if len(segment.coefficients) != len(axes_of(piece.mask)):
            raise PieceError(f"piece {piece.id}: {len(segment.coefficients)} polynomials for {len(axes_of(piece.mask))} axes")
        for row in segment.coefficients:
            if not (1 <= len(row) <= MAX_COEFFICIENTS and all(map(math.isfinite, row))):
                raise PieceError(f"piece {piece.id}: segment {number} holds a polynomial of {len(row)} coefficients or no numbers: {row}")
    if before != piece.length:
        raise PieceError(f"piece {piece.id}: the last segment ends at s = {before}, the piece at {piece.length}")


def _check_joins(piece: Piece) -> None:
    """Where segments meet, position and slope must agree: the stepper would jump otherwise."""
    starts = piece._starts
    for number in range(1, len(piece.segments)):
        left, right = piece.segments[number - 1], piece.segments[number]
        u = left.end_s - starts[number - 1]
        for axis, a, b in zip(piece.axes, left.position(u), right.position(0.0), strict=True):
            if not abs(a - b) <= JOIN:
                raise PieceError(f"piece {piece.id}: axis {axis} jumps from {a} to {b} at s = {left.end_s}")
        for axis, a, b in zip(piece.axes, left.slope(u), right.slope(0.0), strict=True):
            if not abs(a - b) <= JOIN * (1 + abs(a)):
                raise PieceError(f"piece {piece.id}: axis {axis} has a corner at s = {left.end_s}, slope {a} before and {b} after")


# ---- the record

MAGIC = b"AXPC"
VERSION = 3
ENDS_AT_REST = 1

_HEAD = struct.Struct("<4sHHIIBBHI")
_ROW = MAX_COEFFICIENTS
_HEAD_END = _HEAD.size - 4  # the CRC covers what precedes its own field, and the body


@dataclass(frozen=True, slots=True)
class Head:
    """What every record begins with.  first, second: two small numbers whose meaning depends on the version."""

    version: int
    flags: int
    id: int
    mask: int
    first: int
    second: int = 0


def _size_of_segment(axes: int) -> int:
    return 1 + max(ROOM, axes) * _ROW


def numbers_of(axes: int) -> int:
    """Return how many f64 values follow the head of a record with this number of axes."""
    return 3 + MAX_SEGMENTS * _size_of_segment(axes) + MAX_TABLE


def record_size(axes: int) -> int:
    """Return the record size in bytes for this number of axes."""
    return _HEAD.size + 8 * numbers_of(axes)


RECORD_SIZE = record_size(ROOM)  # of up to ROOM axes


def write_record(head: Head, numbers: Sequence[float]) -> bytes:
    """Return a complete record; missing `numbers` become 0."""
    count = numbers_of(head.mask.bit_count())
    body = struct.pack(f"<{count}d", *numbers, *[0.0] * (count - len(numbers)))
    begin = _HEAD.pack(MAGIC, head.version, head.flags, head.id, head.mask, head.first, head.second, 0, 0)[:_HEAD_END]
    return begin + struct.pack("<I", zlib.crc32(body, zlib.crc32(begin))) + body


def version_of(record: bytes) -> int:
    """Version in the record; 0: the record is too short."""
    return int(_HEAD.unpack_from(record)[1]) if len(record) >= _HEAD.size else 0


def read_record(record: bytes, version: int) -> tuple[Head, tuple[float, ...]]:
    """Reverse write_record.  Raise PieceError on anything but a complete record of this version."""
    if len(record) < _HEAD.size:
        raise PieceError(f"piece record: {RECORD_SIZE} bytes expected, {len(record)} received")
    magic, found, flags, number, mask, first, second, spare, crc = _HEAD.unpack_from(record)
    if magic != MAGIC or found != version:
        raise PieceError(f"piece record: starts with {record[:6].hex(' ')}, expected {MAGIC.hex(' ')} and version {version}")
    size = record_size(mask.bit_count())
    if len(record) != size:
        raise PieceError(f"piece record {number}: {size} bytes expected for mask {mask:#x}, {len(record)} received")
    if crc != zlib.crc32(record[_HEAD.size :], zlib.crc32(record[:_HEAD_END])):
        raise PieceError(f"piece record {number}: check sum {crc:08x} is wrong")
    if not mask or spare:
        raise PieceError(f"piece record {number}: mask {mask:#x}, spare {spare:#x} do not fit")
    return Head(found, flags, number, mask, first, second), struct.unpack_from(f"<{numbers_of(mask.bit_count())}d", record, _HEAD.size)


def encode(piece: Piece) -> bytes:
    """Piece -> record_size(its axes) bytes."""
    room = max(ROOM, len(piece.axes))
    numbers = [piece.length, piece.accel, piece.jerk]
    for segment in piece.segments:
        numbers.append(segment.end_s)
        for row in segment.coefficients:
            numbers += (*row, *[0.0] * (_ROW - len(row)))
        numbers += [0.0] * (_ROW * (room - len(segment.coefficients)))
    numbers += [0.0] * (_size_of_segment(room) * (MAX_SEGMENTS - len(piece.segments)))
    flags = ENDS_AT_REST if piece.ends_at_rest else 0
    return write_record(Head(VERSION, flags, piece.id, piece.mask, len(piece.segments), len(piece.table)), (*numbers, *piece.table))


def decode(record: bytes) -> Piece:
    """Decode a record.  Raise PieceError on anything but a complete, legal piece."""
    head, numbers = read_record(record, VERSION)
    segments, points, axes = head.first, head.second, head.mask.bit_count()
    if head.flags & ~ENDS_AT_REST or segments > MAX_SEGMENTS or points > MAX_TABLE:
        raise PieceError(f"piece record {head.id}: flags {head.flags:#x}, {segments} segments, {points} points do not fit")
    size = _size_of_segment(axes)
    table_at = 3 + MAX_SEGMENTS * size
    return Piece(
        head.id,
        head.mask,
        numbers[0],
        tuple(_segment(numbers, 3 + i * size, axes) for i in range(segments)),
        numbers[table_at : table_at + points],
        numbers[1],
        numbers[2],
        bool(head.flags & ENDS_AT_REST),
    )


def _segment(numbers: tuple[float, ...], at: int, axes: int) -> Segment:
    rows = (numbers[at + 1 + i * _ROW : at + 1 + (i + 1) * _ROW] for i in range(axes))
    return Segment(numbers[at], tuple(_shortened(row) for row in rows))


def _shortened(row: tuple[float, ...]) -> tuple[float, ...]:
    """Without trailing zeros: a straight line costs the stepper two coefficients, not six."""
    count = len(row)
    while count > 1 and row[count - 1] == 0.0:
        count -= 1
    return row[:count]
