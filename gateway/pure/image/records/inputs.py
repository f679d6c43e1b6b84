"""Fast start-off and flying measurement as records of the pieces ring (AX-328, AX-329)."""

import struct
from dataclasses import dataclass

from gateway.pure.image.records.planner import Part, PieceRecord
from motion.execution.pieces import RECORD_SIZE

_START, _FLYING = struct.Struct("=i?d"), struct.Struct("=QdiiI??I")


@dataclass(frozen=True, slots=True)
class StartOrder:
    """The part that follows begins when RC input `number` has this value, and so long (s) after it."""

    number: int
    level: bool
    delay_s: float = 0.0


@dataclass(frozen=True, slots=True)
class FlyingAt:
    """SF 43 or SF 44 so long (s at full speed) after the beginning of a piece.  channel: probe 6x0; number: RC input of its wire; mask:
    axes (bit n-1 = axis n) whose positions are stored; edge: True positive, None: switched off; drives: axes whose drives catch it."""

    piece: int
    after: float
    channel: int
    number: int
    mask: int
    edge: bool | None
    drives: int = 0


def start_record(job: int, generation: int, order: StartOrder) -> PieceRecord:
    """As a record of the pieces ring."""
    return _record(Part.START, job, generation, _START.pack(order.number, order.level, order.delay_s))


def start_of(record: PieceRecord) -> StartOrder:
    """The reverse of start_record."""
    return StartOrder(*_START.unpack_from(record.piece))


def flying_record(job: int, generation: int, at: FlyingAt) -> PieceRecord:
    """As a record of the pieces ring."""
    on, positive = at.edge is not None, at.edge is True
    return _record(Part.FLYING, job, generation, _FLYING.pack(at.piece, at.after, at.channel, at.number, at.mask, on, positive, at.drives))


def flying_of(record: PieceRecord) -> FlyingAt:
    """The reverse of flying_record."""
    piece, after, channel, number, mask, on, positive, drives = _FLYING.unpack_from(record.piece)
    return FlyingAt(piece, after, channel, number, mask, positive if on else None, drives)


def _record(part: Part, job: int, generation: int, body: bytes) -> PieceRecord:
    return PieceRecord(part, job, generation, body.ljust(RECORD_SIZE, b"\0"))
