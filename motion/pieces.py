"""Pieces of path: what planner and stepper agree on, and their record in the ring (design 6).

A piece is q(s) for 0 <= s <= length, polynomials in s per axis, with the highest legal sdot^2 on an even grid over s,
the highest |sddot| and |s jerk|, and its end condition.  It holds no time: override, stop and resume change time along
the path and never the path.  q in m or rad; s has any unit the planner likes (plan_ptp: travel of the longest axis).

Record, little endian: magic "AXPC", version u16, flags u16 (bit 0 ends at rest), id u32, mask u16, segments u8, table
points u8, CRC-32 u32 over everything but itself; length, accel, jerk f64; MAX_SEGMENTS x (end_s f64, MAX_AXES x
MAX_COEFFICIENTS f64, axes of the mask first, unused ones 0); MAX_TABLE f64, unused ones 0.
"""

import math
import struct
import zlib
from dataclasses import dataclass, field
from functools import cached_property

from motion.errors import PieceError

MAX_AXES = 12
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
    mask: int  # bit n: axis n takes part
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
        """Numbers of the axes that take part, rising."""
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
        raise PieceError(f"piece {piece.id}: the sdot^2 table holds a value that is not a number > 0")


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
VERSION = 1
ENDS_AT_REST = 1

_HEAD = struct.Struct("<4sHHIHBBI")
_ROW = MAX_COEFFICIENTS
_SEGMENT = 1 + MAX_AXES * _ROW
_NUMBERS = 3 + MAX_SEGMENTS * _SEGMENT + MAX_TABLE
_BODY = struct.Struct(f"<{_NUMBERS}d")
RECORD_SIZE = _HEAD.size + _BODY.size  # bytes
_HEAD_END = _HEAD.size - 4  # the CRC covers what precedes its own field, and the body


def encode(piece: Piece) -> bytes:
    """Piece -> RECORD_SIZE bytes."""
    numbers = [piece.length, piece.accel, piece.jerk]
    for segment in piece.segments:
        numbers.append(segment.end_s)
        for row in segment.coefficients:
            numbers += (*row, *[0.0] * (_ROW - len(row)))
        numbers += [0.0] * (_ROW * (MAX_AXES - len(segment.coefficients)))
    numbers += [0.0] * (_SEGMENT * (MAX_SEGMENTS - len(piece.segments)))
    numbers += (*piece.table, *[0.0] * (MAX_TABLE - len(piece.table)))
    body = _BODY.pack(*numbers)
    flags = ENDS_AT_REST if piece.ends_at_rest else 0
    head = _HEAD.pack(MAGIC, VERSION, flags, piece.id, piece.mask, len(piece.segments), len(piece.table), 0)[:_HEAD_END]
    return head + struct.pack("<I", zlib.crc32(body, zlib.crc32(head))) + body


def decode(record: bytes) -> Piece:
    """RECORD_SIZE bytes -> Piece; raises PieceError on anything that is not a whole, legal piece."""
    if len(record) != RECORD_SIZE:
        raise PieceError(f"piece record: {RECORD_SIZE} bytes expected, {len(record)} received")
    magic, version, flags, number, mask, segments, points, crc = _HEAD.unpack_from(record)
    if magic != MAGIC or version != VERSION:
        raise PieceError(f"piece record: starts with {record[:6].hex(' ')}, expected {MAGIC.hex(' ')} and version {VERSION}")
    if crc != zlib.crc32(record[_HEAD.size :], zlib.crc32(record[:_HEAD_END])):
        raise PieceError(f"piece record {number}: check sum {crc:08x} is wrong")
    if flags & ~ENDS_AT_REST or segments > MAX_SEGMENTS or points > MAX_TABLE or not 0 < mask < 1 << MAX_AXES:
        raise PieceError(f"piece record {number}: flags {flags:#x}, {segments} segments, {points} points, mask {mask:#x} do not fit")
    numbers = _BODY.unpack_from(record, _HEAD.size)
    table_at = 3 + MAX_SEGMENTS * _SEGMENT
    return Piece(
        number,
        mask,
        numbers[0],
        tuple(_segment(numbers, 3 + i * _SEGMENT, len(axes_of(mask))) for i in range(segments)),
        numbers[table_at : table_at + points],
        numbers[1],
        numbers[2],
        bool(flags & ENDS_AT_REST),
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
