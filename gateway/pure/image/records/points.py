"""Set machine position, reference path and latch as records of the pieces ring (AX-578, AX-579)."""

from dataclasses import dataclass
from typing import Annotated

from gateway.pure.image.records.cell import MOST_AXES
from gateway.pure.image.records.layout import F64, I32, U32, U64, Code, Layout, Yes
from gateway.pure.image.records.planner import Part, PieceRecord
from motion.execution.pieces import RECORD_SIZE


@dataclass(frozen=True, slots=True)
class ReferencePathPoint:
    """SF 29 or SF 30 this long (s at full speed) after the beginning of a piece.  system: measuring system from 1, 0: off; distance: m, rad
    or with `cycles` a number of them; kinematic: whose path."""

    piece: U64
    after: F64
    system: U32 = 0
    distance: F64 = 0.0
    cycles: Yes = False
    kinematic: U32 = 1


@dataclass(frozen=True, slots=True)
class LatchAt:
    """setLatch this long (s at full speed) after the beginning of a piece.  number: RC input of its wire; mask: axes (bit n-1 = axis n)
    whose positions are stored; name: fIn0 or fIn1."""

    piece: U64
    after: F64
    number: I32
    mask: U32
    name: Annotated[str, Code("4s", bytes.decode, str.encode)]


@dataclass(frozen=True, slots=True)
class _Machine:
    """Axes (bit n-1 = axis n) and the places of all."""

    mask: U32
    places: Annotated[tuple[float, ...], Code(f"{MOST_AXES}d")]


@dataclass(frozen=True, slots=True)
class _Recall:
    """An entry of the reference path of a kinematic."""

    index: U32
    kinematic: U32


_MACHINE, _TAPE, _RECALL, _LATCH = Layout(_Machine), Layout(ReferencePathPoint), Layout(_Recall), Layout(LatchAt)


def machine_record(job: int, generation: int, mask: int, values: tuple[float, ...]) -> PieceRecord:
    """SF 3, a separate part: assign these positions (m or rad) to the axes of the mask, in their order."""
    rest = iter(values)
    places = tuple(next(rest) if mask >> n & 1 else 0.0 for n in range(MOST_AXES))
    return _record(Part.MACHINE, job, generation, _MACHINE.pack(_Machine(mask, places)))


def machine_of(record: PieceRecord) -> dict[int, float]:
    """Place of each axis (from 0) that gets one."""
    held = _MACHINE.unpack(record.piece)
    return {n: place for n, place in enumerate(held.places) if held.mask >> n & 1}


def tape_record(job: int, generation: int, at: ReferencePathPoint) -> PieceRecord:
    """As a record of the pieces ring."""
    return _record(Part.TAPE, job, generation, _TAPE.pack(at))


def tape_of(record: PieceRecord) -> ReferencePathPoint:
    """The reverse of tape_record."""
    return _TAPE.unpack(record.piece)


def recall_record(job: int, generation: int, index: int, kinematic: int) -> PieceRecord:
    """SF 31, a part of its own: the entry of the kinematic's path becomes what was measured."""
    return _record(Part.RECALL, job, generation, _RECALL.pack(_Recall(index, kinematic)))


def recall_of(record: PieceRecord) -> tuple[int, int]:
    """Entry and kinematic."""
    held = _RECALL.unpack(record.piece)
    return held.index, held.kinematic


def latch_record(job: int, generation: int, at: LatchAt) -> PieceRecord:
    """As a record of the pieces ring."""
    return _record(Part.LATCH, job, generation, _LATCH.pack(at))


def latch_of(record: PieceRecord) -> LatchAt:
    """The reverse of latch_record."""
    return _LATCH.unpack(record.piece)


def _record(part: Part, job: int, generation: int, body: bytes) -> PieceRecord:
    return PieceRecord(part, job, generation, body.ljust(RECORD_SIZE, b"\0"))
