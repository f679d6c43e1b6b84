"""Set machine position, reference path and latch as records of the pieces ring (AX-578, AX-579)."""

import struct
from dataclasses import dataclass

from gateway.pure.image.records.cell import MOST_AXES
from gateway.pure.image.records.planner import Part, PieceRecord
from motion.execution.pieces import RECORD_SIZE

_MACHINE, _TAPE = struct.Struct(f"=I{MOST_AXES}d"), struct.Struct("=QdId?I")
_RECALL, _LATCH = struct.Struct("=II"), struct.Struct("=QdiI4s")


@dataclass(frozen=True, slots=True)
class ReferencePathPoint:
    """SF 29 or SF 30 so long (s at full speed) after the beginning of a piece.  system: measuring system from 1, 0: off; distance: m, rad
    or with `cycles` a number of them; kinematic: whose path."""

    piece: int
    after: float
    system: int = 0
    distance: float = 0.0
    cycles: bool = False
    kinematic: int = 1


@dataclass(frozen=True, slots=True)
class LatchAt:
    """setLatch so long (s at full speed) after the beginning of a piece.  number: RC input of its wire; mask: axes (bit n-1 = axis n)
    whose positions are stored; name: fIn0 or fIn1."""

    piece: int
    after: float
    number: int
    mask: int
    name: str


def machine_record(job: int, generation: int, mask: int, values: tuple[float, ...]) -> PieceRecord:
    """SF 3, a part of its own: the axes of the mask stand at these places (m or rad), in their order."""
    rest = iter(values)
    places = [next(rest) if mask >> n & 1 else 0.0 for n in range(MOST_AXES)]
    return _record(Part.MACHINE, job, generation, _MACHINE.pack(mask, *places))


def machine_of(record: PieceRecord) -> dict[int, float]:
    """Place of each axis (from 0) that gets one."""
    mask, *places = _MACHINE.unpack_from(record.piece)
    return {n: place for n, place in enumerate(places) if mask >> n & 1}


def tape_record(job: int, generation: int, at: ReferencePathPoint) -> PieceRecord:
    """As a record of the pieces ring."""
    return _record(Part.TAPE, job, generation, _TAPE.pack(at.piece, at.after, at.system, at.distance, at.cycles, at.kinematic))


def tape_of(record: PieceRecord) -> ReferencePathPoint:
    """The reverse of tape_record."""
    return ReferencePathPoint(*_TAPE.unpack_from(record.piece))


def recall_record(job: int, generation: int, index: int, kinematic: int) -> PieceRecord:
    """SF 31, a part of its own: the entry of the kinematic's path becomes what was measured."""
    return _record(Part.RECALL, job, generation, _RECALL.pack(index, kinematic))


def recall_of(record: PieceRecord) -> tuple[int, int]:
    """Entry and kinematic."""
    index, kinematic = _RECALL.unpack_from(record.piece)
    return index, kinematic


def latch_record(job: int, generation: int, at: LatchAt) -> PieceRecord:
    """As a record of the pieces ring."""
    return _record(Part.LATCH, job, generation, _LATCH.pack(at.piece, at.after, at.number, at.mask, at.name.encode()))


def latch_of(record: PieceRecord) -> LatchAt:
    """The reverse of latch_record."""
    piece, after, number, mask, name = _LATCH.unpack_from(record.piece)
    return LatchAt(piece, after, number, mask, name.decode())


def _record(part: Part, job: int, generation: int, body: bytes) -> PieceRecord:
    return PieceRecord(part, job, generation, body.ljust(RECORD_SIZE, b"\0"))
