"""Fast start-off and flying measurement as records of the pieces ring (AX-328, AX-329)."""

from dataclasses import dataclass

from gateway.pure.image.records.layout import F64, I32, U32, U64, Layout, Yes
from gateway.pure.image.records.planner import Part, PieceRecord
from motion.execution.pieces import RECORD_SIZE


@dataclass(frozen=True, slots=True)
class StartOrder:
    """The following part begins this time (s) after RC input `number` has this value."""

    number: I32
    level: Yes
    delay_s: F64 = 0.0


@dataclass(frozen=True, slots=True)
class FlyingAt:
    """SF 43 or SF 44 this long (s at full speed) after the beginning of a piece.  channel: probe 6x0; number: RC input of its wire; mask:
    axes (bit n-1 = axis n) whose positions are stored; edge: True positive, None: switched off; drives: axes whose drives catch it."""

    piece: int
    after: float
    channel: int
    number: int
    mask: int
    edge: bool | None
    drives: int = 0


@dataclass(frozen=True, slots=True)
class _Flying:
    """A FlyingAt as the ring holds it."""

    piece: U64
    after: F64
    channel: I32
    number: I32
    mask: U32
    on: Yes
    positive: Yes
    drives: U32


_START, _FLYING = Layout(StartOrder), Layout(_Flying)


def start_record(job: int, generation: int, order: StartOrder) -> PieceRecord:
    """As a record of the pieces ring."""
    return _record(Part.START, job, generation, _START.pack(order))


def start_of(record: PieceRecord) -> StartOrder:
    """The reverse of start_record."""
    return _START.unpack(record.piece)


def flying_record(job: int, generation: int, at: FlyingAt) -> PieceRecord:
    """As a record of the pieces ring."""
    on, positive = at.edge is not None, at.edge is True
    held = _Flying(at.piece, at.after, at.channel, at.number, at.mask, on, positive, at.drives)
    return _record(Part.FLYING, job, generation, _FLYING.pack(held))


def flying_of(record: PieceRecord) -> FlyingAt:
    """The reverse of flying_record."""
    held = _FLYING.unpack(record.piece)
    edge = held.positive if held.on else None
    return FlyingAt(held.piece, held.after, held.channel, held.number, held.mask, edge, held.drives)


def _record(part: Part, job: int, generation: int, body: bytes) -> PieceRecord:
    return PieceRecord(part, job, generation, body.ljust(RECORD_SIZE, b"\0"))
