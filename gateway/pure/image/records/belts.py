"""Synchronous parts through the pieces ring: parameters of one for the cycle, and of each block of types 2 and 3.

Numbers are doubles; NaN marks a missing value.
"""

from dataclasses import dataclass
from typing import Annotated

from gateway.pure.image.records.layout import F64, U8, U32, Code, Layout
from gateway.pure.image.records.planner import Part, PieceRecord
from motion.execution.pieces import RECORD_SIZE
from motion.geometry.frames import Pose
from motion.program.blocks import Interpolation
from motion.sync.belts import Type
from motion.sync.facts import SynchronOrder
from motion.sync.pace import Pace
from motion.sync.synchronous_part import BeltBlock

COORDINATES = 24  # six of the tool and additional axes
KINDS = tuple(Interpolation)
Numbers = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class _Synchron:
    """A SynchronOrder as the ring holds it."""

    belt: U8
    kind: U8
    tolerance: U8
    kinematic: U8
    block: U32
    at: F64
    reference: F64
    position: Annotated[tuple[float, float, float], Code("3d")]  # of the tool
    rotation: Annotated[tuple[float, float, float, float, float, float, float, float, float], Code("9d")]


@dataclass(frozen=True, slots=True)
class _Block:
    """A BeltBlock as the ring holds it."""

    kind: U8
    count: U8  # of the target's coordinates
    ways: U8  # and of the point on the way
    belt: F64
    top: F64
    accel: F64
    decel: F64
    first: F64
    third: F64
    target: Annotated[Numbers, Code(f"{COORDINATES}d")]
    via: Annotated[Numbers, Code(f"{COORDINATES}d")]


_ORDER, _BLOCK = Layout(_Synchron), Layout(_Block)


def synchron_record(job: int, generation: int, order: SynchronOrder) -> PieceRecord:
    """As a record of the pieces ring."""
    head = (order.belt, order.kind.value, order.tolerance, order.kinematic, order.block, order.at, order.reference)
    body = _ORDER.pack(_Synchron(*head, order.tool.position, order.tool.rotation))
    return PieceRecord(Part.SYNCHRON, job, generation, body.ljust(RECORD_SIZE, b"\0"))


def synchron_of(record: PieceRecord) -> SynchronOrder:
    """The reverse of synchron_record."""
    held = _ORDER.unpack(record.piece)
    tool = Pose(held.position, held.rotation)
    return SynchronOrder(held.belt, Type(held.kind), held.at, held.reference, held.block, tool, held.tolerance, held.kinematic)


def belt_block_record(job: int, generation: int, block: BeltBlock) -> PieceRecord:
    """As a record of the pieces ring."""
    target, via = block.target, block.via
    numbers = (block.belt, block.pace.top, block.pace.accel, block.pace.decel, block.first, block.third)
    held = _Block(KINDS.index(block.interpolation), len(target), len(via), *numbers, target=_padded(target), via=_padded(via))
    body = _BLOCK.pack(held)
    return PieceRecord(Part.BELT_BLOCK, job, generation, body.ljust(RECORD_SIZE, b"\0"))


def belt_block_of(record: PieceRecord) -> BeltBlock:
    """The reverse of belt_block_record."""
    held = _BLOCK.unpack(record.piece)
    pace = Pace(held.top, held.accel, held.decel)
    target, via = held.target[: held.count], held.via[: held.ways]
    return BeltBlock(target, held.belt, KINDS[held.kind], pace=pace, first=held.first, third=held.third, via=via)


def _padded(numbers: Numbers) -> Numbers:
    return (*numbers, *[0.0] * (COORDINATES - len(numbers)))
