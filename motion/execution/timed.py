"""Pieces of a path with its law: what the planner commits for LINEAR, CIRCULAR, splines, passed corners (record version 4).

A timed piece is q(tau) for 0 <= tau <= duration, tau = time at full speed: a quintic between nodes of position, speed and
acceleration of every axis, and of the way along the path.  At full speed it keeps all limits; it carries them, so that the stepper
can change speed along it (motion.execution.follower) and never the path.  Pieces follow one another without a stop: one ends as the next
begins; only the last of a chain ends at rest, and the stepper takes a tail only when it is complete.

Record: as in motion.execution.pieces, with the same size per number of axes; version 4, flags bit 0 ends at rest, bit 1 new tail, nodes
u8, 0 u8; after the head: block f64; acceleration and jerk of the axes of the mask and the way; nodes x (tau, then position, speed,
acceleration of the same columns).
"""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from operator import lt

import numpy as np
from numpy.typing import NDArray

from motion.errors import PieceError
from motion.execution.pieces import MAX_AXES, Head, Piece, axes_of, decode, numbers_of, read_record, version_of, write_record
from motion.execution.pieces import VERSION as OF_POLYNOMIALS

VERSION = 4
ENDS_AT_REST, NEW_TAIL = 1, 2

Node = tuple[float, ...]  # 3 x columns: position, speed, acceleration of each
Quintic = tuple[float, float, float, float, float, float]  # highest power first


def most_nodes(axes: int) -> int:
    """How many nodes the record of a piece of this number of axes holds."""
    columns = axes + 1
    return (numbers_of(axes) - 1 - 2 * columns) // (1 + 3 * columns)


@dataclass(frozen=True)
class TimedPiece:
    """See the module; raises PieceError when it contradicts itself."""

    id: int  # 1 .. 2^32-1, rising along a chain
    mask: int  # bit n: axis n moves
    block: int  # of the program, for displays and move ids
    times: tuple[float, ...]  # tau of the nodes, from 0
    nodes: tuple[Node, ...]
    accel: tuple[float, ...]  # per axis of the mask, then of the way; inf: no limit
    jerk: tuple[float, ...]
    ends_at_rest: bool = True
    new_tail: bool = False  # it and what follows replace all waiting pieces from this id on

    def __post_init__(self) -> None:
        columns = len(self.axes) + 1
        if not (1 <= self.id < 1 << 32 and 0 < self.mask < 1 << MAX_AXES and 0 <= self.block < 1 << 32):
            raise PieceError(f"piece {self.id}: id, mask {self.mask:#x} or block {self.block} out of range")
        if not 2 <= len(self.times) == len(self.nodes) <= most_nodes(columns - 1):
            raise PieceError(
                f"piece {self.id}: {len(self.times)} times, {len(self.nodes)} nodes; 2 .. {most_nodes(columns - 1)} fit a record"
            )
        if self.times[0] != 0.0 or not (all(map(lt, self.times, self.times[1:])) and self.times[-1] < math.inf):
            raise PieceError(f"piece {self.id}: the times of its nodes do not rise from 0")
        if set(map(len, self.nodes)) != {3 * columns} or not all(map(math.isfinite, chain.from_iterable(self.nodes))):
            raise PieceError(f"piece {self.id}: a node has not {3 * columns} finite numbers")
        if not (len(self.accel) == len(self.jerk) == columns and all(value > 0 for value in (*self.accel, *self.jerk))):
            raise PieceError(f"piece {self.id}: {columns} limits > 0 of acceleration and of jerk are needed")
        if self.ends_at_rest and any(abs(v) > 1e-6 for k, v in enumerate(self.nodes[-1]) if k % 3 == 1):
            raise PieceError(f"piece {self.id}: marked as ending at rest, but its last speed is not 0")

    @cached_property
    def axes(self) -> tuple[int, ...]:
        """Numbers of the moving axes, ascending."""
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
            _quintics(b - a, left, right) for a, b, left, right in zip(self.times, self.times[1:], self.nodes, self.nodes[1:], strict=False)
        )

    @cached_property
    def table(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(nodes,) times of the nodes in s, and (intervals, columns, 6) the quintics."""
        return np.array(self.times), np.array(self.quintics)


def _quintics(h: float, start: Node, end: Node) -> tuple[Quintic, ...]:
    """Of each column over an interval of h seconds."""
    third, fourth, fifth = h**3, h**4, h**5
    made = []
    for a, b, c, d, e, f in zip(start[::3], start[1::3], start[2::3], end[::3], end[1::3], end[2::3], strict=True):
        half = 0.5 * c
        gap, slope, bend = d - a - b * h - half * h * h, (e - b - c * h) * h, (f - c) * h * h
        made.append(
            (
                (6 * gap - 3 * slope + 0.5 * bend) / fifth,
                (-15 * gap + 7 * slope - bend) / fourth,
                (10 * gap - 4 * slope + 0.5 * bend) / third,
                half,
                b,
                a,
            )
        )
    return tuple(made)


def encode_timed(piece: TimedPiece) -> bytes:
    """TimedPiece -> record_size(its axes) bytes."""
    numbers = [float(piece.block), *piece.accel, *piece.jerk]
    for time, node in zip(piece.times, piece.nodes, strict=True):
        numbers += (time, *node)
    flags = (ENDS_AT_REST if piece.ends_at_rest else 0) | (NEW_TAIL if piece.new_tail else 0)
    return write_record(Head(VERSION, flags, piece.id, piece.mask, len(piece.times)), numbers)


def decode_any(record: bytes) -> Piece | TimedPiece:
    """Decode a record of either version.  Raise PieceError on anything but a complete, legal piece."""
    if version_of(record) == OF_POLYNOMIALS:
        return decode(record)
    head, numbers = read_record(record, VERSION)
    columns, nodes = head.mask.bit_count() + 1, head.first
    if head.flags & ~(ENDS_AT_REST | NEW_TAIL) or head.second or nodes > most_nodes(columns - 1):
        raise PieceError(f"piece record {head.id}: flags {head.flags:#x}, {nodes} nodes do not fit")
    if not 0 <= numbers[0] < 1 << 32:
        raise PieceError(f"piece record {head.id}: block {numbers[0]} is out of range")
    first, size = 1 + 2 * columns, 1 + 3 * columns
    rows = [numbers[first + k * size : first + (k + 1) * size] for k in range(nodes)]
    return TimedPiece(
        head.id,
        head.mask,
        int(numbers[0]),
        tuple(row[0] for row in rows),
        tuple(row[1:] for row in rows),
        numbers[1 : 1 + columns],
        numbers[1 + columns : first],
        bool(head.flags & ENDS_AT_REST),
        bool(head.flags & NEW_TAIL),
    )
