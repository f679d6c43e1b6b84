"""Blocks of an alterable part before they run: faults in the words of VAL 3 (13.1), and what the cycle must know.

Source: VAL 3 reference L6259-6294 (alterable paths), L6355-6392 (alterBegin); AX-547.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from motion.geometry.frames import IDENTITY, Pose
from motion.geometry.limits import AxisLimits
from motion.program.blocks import Alteration, Block, Frame, Tool, Until
from motion.program.errors import BlockError
from motion.sync.alter import NO_OPTION, AlterLimits, Reference

SOURCE = "VAL 3"
OPTION = "alterBegin: option not enabled; the cell has no [alter] for the robot"


@dataclass(frozen=True, slots=True)
class AlterOrder:
    """alterBegin for the cycle.  frame: the reference on the base, or the tool on the flange; limits.joints: shares of the axis speeds
    (one number); tool: tool centre point whose speed is judged; block: number of the first block; kinematic: of the
    cell, from 1."""

    reference: Reference
    frame: Pose
    speed: float
    path: float
    turn: float
    accel: float
    decel: float
    tool: Pose = IDENTITY
    until: Until | None = None
    block: int = 1
    kinematic: int = 1

    def limits(self, axes: Sequence[AxisLimits]) -> AlterLimits:
        """axes: of the arm; nothing is let faster than an axis can be."""
        share = min(self.speed, 1.0)
        return AlterLimits(tuple(share * axis.speed for axis in axes), self.path, self.turn, self.accel, self.decel)


def order_of(part: Alteration, tool: Tool, block: int, kinematic: int) -> AlterOrder:
    """Of a part whose blocks have this tool."""
    kind = Reference.FRAME if isinstance(part.reference, Frame) else Reference.TOOL
    limits = (part.speed, part.path, part.turn, part.accel, part.decel)
    return AlterOrder(kind, part.reference.pose, *limits, tool.pose, part.until, block, kinematic)


def check_alterable(block: Block, before: Block | None, number: int, *, option: bool) -> None:
    """before: the block before it in the program; option: the robot has a correction.  Raises BlockError."""
    part = block.alteration
    if part is None:
        return
    if not option:
        raise BlockError(OPTION, code=NO_OPTION, block=number, source=SOURCE)
    if block.synchron is not None:
        raise BlockError("an alterable part and a belt-synchronous part cannot be one", block=number)
    if block.until is not None or block.label:
        raise BlockError("until= and labels have no place in an alterable part", block=number)
    if before is not None and before.alteration == part and before.tool.pose != block.tool.pose:
        raise BlockError("the tool cannot change in an alterable part", block=number)
