"""Synchronous parts through the pieces ring: parameters of one for the cycle, and of each block of types 2 and 3.

Numbers are doubles; NaN stands for what is not given.
"""

import struct

from gateway.pure.image.records.planner import Part, PieceRecord
from motion.execution.pieces import RECORD_SIZE
from motion.geometry.frames import Pose
from motion.program.blocks import Interpolation
from motion.sync.belts import Type
from motion.sync.facts import SynchronOrder
from motion.sync.pace import Pace
from motion.sync.synchronous_part import BeltBlock

COORDINATES = 24  # six of the tool and additional axes
_ORDER = struct.Struct("=BBBBI dd 12d")
_BLOCK = struct.Struct(f"=BBB 6d {COORDINATES}d {COORDINATES}d")
KINDS = tuple(Interpolation)


def synchron_record(job: int, generation: int, order: SynchronOrder) -> PieceRecord:
    """As a record of the pieces ring."""
    head = (order.belt, order.kind.value, order.tolerance, order.kinematic, order.block, order.at, order.reference)
    body = _ORDER.pack(*head, *order.tool.position, *order.tool.rotation)
    return PieceRecord(Part.SYNCHRON, job, generation, body.ljust(RECORD_SIZE, b"\0"))


def synchron_of(record: PieceRecord) -> SynchronOrder:
    """The reverse of synchron_record."""
    belt, kind, tolerance, kinematic, block, at, reference, *pose = _ORDER.unpack_from(record.piece)
    a, b, c, d, e, f, g, h, i = pose[3:]
    tool = Pose((pose[0], pose[1], pose[2]), (a, b, c, d, e, f, g, h, i))
    return SynchronOrder(belt, Type(kind), at, reference, block, tool, tolerance, kinematic)


def belt_block_record(job: int, generation: int, block: BeltBlock) -> PieceRecord:
    """As a record of the pieces ring."""
    target, via = block.target, block.via
    numbers = (block.belt, block.pace.top, block.pace.accel, block.pace.decel, block.first, block.third)
    padded = [*target, *[0.0] * (COORDINATES - len(target)), *via, *[0.0] * (COORDINATES - len(via))]
    body = _BLOCK.pack(KINDS.index(block.interpolation), len(target), len(via), *numbers, *padded)
    return PieceRecord(Part.BELT_BLOCK, job, generation, body.ljust(RECORD_SIZE, b"\0"))


def belt_block_of(record: PieceRecord) -> BeltBlock:
    """The reverse of belt_block_record."""
    kind, count, ways, belt, top, accel, decel, first, third, *values = _BLOCK.unpack_from(record.piece)
    pace = Pace(top, accel, decel)
    target, via = tuple(values[:count]), tuple(values[COORDINATES : COORDINATES + ways])
    return BeltBlock(target, belt, KINDS[kind], pace=pace, first=first, third=third, via=via)
