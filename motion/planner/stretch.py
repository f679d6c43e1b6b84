"""A part of the path of the axes: of one block, or of the corner between two."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import Enum

from motion.paths.even import evened
from motion.paths.joints import JointPath
from motion.planner.path_checks import Slowed
from motion.planner.robot import Machine
from motion.program.blocks import Block, Called, Output, Shape
from motion.program.slopes import Clock

EMPTY = 1e-9  # of a block: less is nothing left to run
SMALLEST = 1e-7  # m or rad: a smaller corner is none


class Kind(Enum):
    MAIN = "main"
    CORNER = "corner"


@dataclass(frozen=True)
class Stretch:
    """Path of the axes between two places of the route.

    block: number of the block (of a corner: the one before it); share: how much of that block's way is done at its start and at its end
    (for a corner: of the following block).
    """

    path: JointPath
    block: int
    kind: Kind
    source: Block
    share: tuple[float, float]
    following: Block | None = None  # of a corner
    stop: bool = False  # the axes rest at its end
    way: float = 0.0  # full length of the block (of a corner: of the one before)
    square: Callable[[], tuple[JointPath, JointPath]] | None = field(
        default=None, compare=False
    )  # of a corner: to the point, and on from it
    clock: Clock | None = field(default=None, compare=False)  # block slope with sine squares: when it is where
    slowed: Slowed | None = None  # an axis cannot keep the programmed speed all along
    ending: tuple[Called | Output, ...] = ()  # of blocks without way after it: done at its end
    even: bool = False  # its parameter is not the way: the axes move faster than the tool (motion.paths.even)

    @property
    def last(self) -> int:
        """Number of the last block it needs."""
        return self.block + (self.kind is Kind.CORNER)


def shaped(block: Block, machine: Machine) -> Block:
    """Return the block with the robot's ramps where it sets none."""
    return replace(block, shape=machine.shape) if block.shape is Shape.ROBOT and machine.shape is Shape.SIN2 else block


def evenly(stretch: Stretch) -> Stretch:
    """Return the stretch with a parameter that advances while the axes swing.  Stretches whose timing uses the way itself are unchanged."""
    blocks = [each for each in (stretch.source, stretch.following) if each is not None]
    if stretch.clock is not None or any(each.pace.time is not None for each in blocks):
        return stretch
    path = evened(stretch.path)
    return stretch if path is None else replace(stretch, path=path, even=True)
