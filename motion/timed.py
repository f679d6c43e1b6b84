"""Pieces of a path with its law: what the planner commits for LINEAR, CIRCULAR, splines, passed corners (record version 2).

A timed piece is q(tau) for 0 <= tau <= duration, tau = time at full speed: a quintic between nodes of position, speed and
acceleration of every axis, and of the way along the path.  At full speed it keeps all limits; it carries them, so that the stepper
can change speed along it (motion.follower) and never the path.  Pieces follow one another without a stop: one ends as the next
begins; only the last of a chain ends at rest, and the stepper takes a tail only when it is complete.

Record, little endian, as long as that of version 1: magic "AXPC", version u16 = 2, flags u16 (bit 0 ends at rest, bit 1 new tail), id
u32, mask u16, nodes u8, 0 u8, CRC-32 u32 over everything but itself; block f64; acceleration and jerk of the axes of the mask and
the way; nodes x (tau, then position, speed, acceleration of the same columns).
"""

import math
import struct
import zlib
from dataclasses import dataclass
from functools import cached_property

from motion.errors import PieceError
from motion.pieces import MAGIC, MAX_AXES, RECORD_SIZE, Piece, axes_of
from motion.pieces import VERSION as VERSION_1
from motion.pieces import decode as decode_1

VERSION = 2
ENDS_AT_REST, NEW_TAIL = 1, 2
MOST_AXES = 32  # of one piece: a team of kinematics; a record holds MAX_AXES
NO_RECORD = 6  # axes of which a longer piece has the nodes

Node = tuple[float, ...]  # 3 x columns: position, speed, acceleration of each
Quintic = tuple[float, float, float, float, float, float]  # highest power first

_HEAD = struct.Struct("<4sHHIHBBI")
_CRC_AT = _HEAD.size - 4
_NUMBERS = (RECORD_SIZE - _HEAD.size) // 8


def most_nodes(axes: int) -> int:
    """How many nodes one record holds for this number of axes; more axes than a record knows stay in memory, as long as six."""
    columns = (axes if axes <= MAX_AXES else NO_RECORD) + 1
    return (_NUMBERS - 1 - 2 * columns) // (1 + 3 * columns)


@dataclass(frozen=True)
class TimedPiece:
    """See the module; raises PieceError when it contradicts itself."""

    id: int  # 1 .. 2^32-1, rising along a chain
    mask: int  # bit n: axis n takes part
    block: int  # of the program, for displays and move ids
    times: tuple[float, ...]  # tau of the nodes, from 0
    nodes: tuple[Node, ...]
    accel: tuple[float, ...]  # per axis of the mask, then of the way; inf: no limit
    jerk: tuple[float, ...]
    ends_at_rest: bool = True
    new_tail: bool = False  # it and what follows replace all waiting pieces from this id on

    def __post_init__(self) -> None:
        columns = len(self.axes) + 1
        if not (1 <= self.id < 1 << 32 and 0 < self.mask < 1 << MOST_AXES and 0 <= self.block < 1 << 32):
            raise PieceError(f"piece {self.id}: id, mask {self.mask:#x} or block {self.block} out of range")
        if not 2 <= len(self.times) == len(self.nodes) <= most_nodes(columns - 1):
            raise PieceError(
                f"piece {self.id}: {len(self.times)} times, {len(self.nodes)} nodes; 2 .. {most_nodes(columns - 1)} fit a record"
            )
        if self.times[0] != 0.0 or not all(a < b < math.inf for a, b in zip(self.times, self.times[1:], strict=False)):
            raise PieceError(f"piece {self.id}: the times of its nodes do not rise from 0")
        if not all(len(node) == 3 * columns and all(map(math.isfinite, node)) for node in self.nodes):
            raise PieceError(f"piece {self.id}: a node has not {3 * columns} finite numbers")
        if not (len(self.accel) == len(self.jerk) == columns and all(value > 0 for value in (*self.accel, *self.jerk))):
            raise PieceError(f"piece {self.id}: {columns} limits > 0 of acceleration and of jerk are needed")
        if self.ends_at_rest and any(abs(v) > 1e-6 for k, v in enumerate(self.nodes[-1]) if k % 3 == 1):
            raise PieceError(f"piece {self.id}: says it ends at rest, but its last speed is not 0")

    @cached_property
    def axes(self) -> tuple[int, ...]:
        """Numbers of the axes that take part, rising."""
        return axes_of(self.mask)

    @property
    def duration(self) -> float:
        """Seconds at full speed."""
        return self.times[-1]

    def start(self) -> tuple[float, ...]:
        """Positions of the axes of the mask at tau = 0."""
        return self.nodes[0][:-3:3]

    def end(self) -> tuple[float, ...]:
        """Positions at the end."""
        return self.nodes[-1][:-3:3]

    @cached_property
    def quintics(self) -> tuple[tuple[Quintic, ...], ...]:
        """[interval][column] in tau - time of the interval's first node."""
        return tuple(
            tuple(_quintic(b - a, left[3 * k : 3 * k + 3], right[3 * k : 3 * k + 3]) for k in range(len(self.accel)))
            for a, b, left, right in zip(self.times, self.times[1:], self.nodes, self.nodes[1:], strict=False)
        )


def _quintic(h: float, start: Node, end: Node) -> Quintic:
    (a, b, c), (d, e, f) = start, end
    gap, slope, bend = d - a - b * h - 0.5 * c * h * h, (e - b - c * h) * h, (f - c) * h * h
    return (
        (6 * gap - 3 * slope + 0.5 * bend) / h**5,
        (-15 * gap + 7 * slope - bend) / h**4,
        (10 * gap - 4 * slope + 0.5 * bend) / h**3,
        0.5 * c,
        b,
        a,
    )


def encode_timed(piece: TimedPiece) -> bytes:
    """TimedPiece -> RECORD_SIZE bytes; PieceError for axes a record does not know."""
    if piece.mask >= 1 << MAX_AXES:
        raise PieceError(f"piece {piece.id}: mask {piece.mask:#x}; a record holds axes 1 .. {MAX_AXES}")
    numbers = [float(piece.block), *piece.accel, *piece.jerk]
    for time, node in zip(piece.times, piece.nodes, strict=True):
        numbers += (time, *node)
    body = struct.pack(f"<{_NUMBERS}d", *numbers, *[0.0] * (_NUMBERS - len(numbers)))
    flags = (ENDS_AT_REST if piece.ends_at_rest else 0) | (NEW_TAIL if piece.new_tail else 0)
    head = _HEAD.pack(MAGIC, VERSION, flags, piece.id, piece.mask, len(piece.times), 0, 0)[:_CRC_AT]
    return head + struct.pack("<I", zlib.crc32(body, zlib.crc32(head))) + body


def decode_any(record: bytes) -> Piece | TimedPiece:
    """RECORD_SIZE bytes -> the piece, of either version; PieceError on anything that is not a whole, legal piece."""
    if len(record) != RECORD_SIZE or _HEAD.unpack_from(record)[1] == VERSION_1:
        return decode_1(record)
    magic, version, flags, number, mask, nodes, spare, crc = _HEAD.unpack_from(record)
    if magic != MAGIC or version != VERSION:
        raise PieceError(f"piece record: starts with {record[:6].hex(' ')}, expected {MAGIC.hex(' ')} and version 1 or 2")
    if crc != zlib.crc32(record[_HEAD.size :], zlib.crc32(record[:_CRC_AT])):
        raise PieceError(f"piece record {number}: check sum {crc:08x} is wrong")
    if flags & ~(ENDS_AT_REST | NEW_TAIL) or spare or not 0 < mask < 1 << MAX_AXES or nodes > most_nodes(mask.bit_count()):
        raise PieceError(f"piece record {number}: flags {flags:#x}, {nodes} nodes, mask {mask:#x} do not fit")
    columns = mask.bit_count() + 1
    numbers = struct.unpack_from(f"<{_NUMBERS}d", record, _HEAD.size)
    if not 0 <= numbers[0] < 1 << 32:
        raise PieceError(f"piece record {number}: block {numbers[0]} is out of range")
    first, size = 1 + 2 * columns, 1 + 3 * columns
    rows = [numbers[first + k * size : first + (k + 1) * size] for k in range(nodes)]
    return TimedPiece(
        number,
        mask,
        int(numbers[0]),
        tuple(row[0] for row in rows),
        tuple(row[1:] for row in rows),
        numbers[1 : 1 + columns],
        numbers[1 + columns : first],
        bool(flags & ENDS_AT_REST),
        bool(flags & NEW_TAIL),
    )
