"""alterBegin through the pieces ring: parameters of an alter section for the cycle.  NaN-free doubles; until: -1 none."""

import struct

from gateway.pure.image.records.planner import Part, PieceRecord
from motion.execution.pieces import RECORD_SIZE
from motion.geometry.frames import Pose
from motion.program.blocks import Until
from motion.sync.alter import Reference
from motion.sync.alterable import AlterOrder

FREEZE = -2  # number of an output mark that is none: from this place on the correction stays as it is
_ORDER = struct.Struct("=?i?IB 5d 12d 12d")


def alter_record(job: int, generation: int, order: AlterOrder) -> PieceRecord:
    """As a record of the pieces ring."""
    until = order.until
    head = (
        order.reference is Reference.TOOL,
        -1 if until is None else until.number,
        until is not None and until.value,
        order.block,
        order.kinematic,
    )
    numbers = (order.speed, order.path, order.turn, order.accel, order.decel)
    body = _ORDER.pack(*head, *numbers, *_flat(order.frame), *_flat(order.tool))
    return PieceRecord(Part.ALTER, job, generation, body.ljust(RECORD_SIZE, b"\0"))


def alter_of(record: PieceRecord) -> AlterOrder:
    """The reverse of alter_record."""
    of_tool, number, value, block, kinematic, speed, path, turn, accel, decel, *poses = _ORDER.unpack_from(record.piece)
    kind = Reference.TOOL if of_tool else Reference.FRAME
    until = None if number < 0 else Until(number, value)
    return AlterOrder(kind, _pose(poses[:12]), speed, path, turn, accel, decel, _pose(poses[12:]), until, block, kinematic)


def _flat(pose: Pose) -> tuple[float, ...]:
    return (*pose.position, *pose.rotation)


def _pose(values: list[float]) -> Pose:
    x, y, z, a, b, c, d, e, f, g, h, i = values
    return Pose((x, y, z), (a, b, c, d, e, f, g, h, i))
