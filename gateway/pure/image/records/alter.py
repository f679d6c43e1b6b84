"""alterBegin through the pieces ring: parameters of an alter section for the cycle.  NaN-free doubles; until: -1 none."""

from dataclasses import dataclass
from typing import Annotated

from gateway.pure.image.records.layout import F64, I32, U8, U32, Code, Layout, Yes
from gateway.pure.image.records.planner import Part, PieceRecord
from motion.execution.pieces import RECORD_SIZE
from motion.geometry.frames import Pose
from motion.program.blocks import Until
from motion.sync.alter import Reference
from motion.sync.alterable import AlterOrder

FREEZE = -2  # number of an output mark that is none: from this place on the correction stays as it is
Numbers = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class _Altered:
    """An AlterOrder as the ring holds it."""

    of_tool: Yes
    number: I32  # of the input that ends it, -1: none
    level: Yes
    block: U32
    kinematic: U8
    speed: F64
    path: F64
    turn: F64
    accel: F64
    decel: F64
    frame: Annotated[Numbers, Code("12d")]
    tool: Annotated[Numbers, Code("12d")]


_ORDER = Layout(_Altered)


def alter_record(job: int, generation: int, order: AlterOrder) -> PieceRecord:
    """As a record of the pieces ring."""
    until = order.until
    altered = _Altered(
        order.reference is Reference.TOOL,
        -1 if until is None else until.number,
        until is not None and until.value,
        order.block,
        order.kinematic,
        *(order.speed, order.path, order.turn, order.accel, order.decel),
        frame=_flat(order.frame),
        tool=_flat(order.tool),
    )
    return PieceRecord(Part.ALTER, job, generation, _ORDER.pack(altered).ljust(RECORD_SIZE, b"\0"))


def alter_of(record: PieceRecord) -> AlterOrder:
    """The reverse of alter_record."""
    at = _ORDER.unpack(record.piece)
    kind = Reference.TOOL if at.of_tool else Reference.FRAME
    until = None if at.number < 0 else Until(at.number, at.level)
    numbers = (at.speed, at.path, at.turn, at.accel, at.decel)
    return AlterOrder(kind, _pose(at.frame), *numbers, _pose(at.tool), until, at.block, at.kinematic)


def _flat(pose: Pose) -> Numbers:
    return (*pose.position, *pose.rotation)


def _pose(values: Numbers) -> Pose:
    x, y, z, a, b, c, d, e, f, g, h, i = values
    return Pose((x, y, z), (a, b, c, d, e, f, g, h, i))
