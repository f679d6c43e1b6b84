"""What the cell itself, and not the robot, refuses of a block of a program.  Pure."""

from collections.abc import Container, Sequence
from dataclasses import dataclass

from gateway.pure.cycle.path_outputs import Places, check_function
from gateway.pure.image.records.cell import RC_BYTES
from gateway.pure.planning.parts import Measuring
from motion.axes.errors import DRIVE_ON_NOT_AVAILABLE
from motion.axes.interruptible import MOVES
from motion.errors import MotionError
from motion.outputs.function import Function
from motion.planner.block_paths import block_fault
from motion.planner.robot import Machine
from motion.program.blocks import Block
from motion.program.errors import BlockError

OUTPUTS_ARE = "programs switch RC outputs to 0 or 1, and none that axisgate itself writes (ready, drives on, in position ..)"


@dataclass(frozen=True, slots=True)
class OfCell:
    """functions, outputs: those the cell has, and that programs may switch; mask: axes of the robot; kinematic: its number in the cell."""

    functions: Places
    outputs: Container[int]
    measuring: Measuring
    mask: int
    kinematic: int = 1

    def check(self, block: Block, number: int, machine: Machine) -> None:
        """Raises BlockError."""
        for key, asked in (("until", block.until), ("wait", block.wait)):
            if asked is not None and asked.number not in range(8 * RC_BYTES):
                raise BlockError(f"{key}={asked.number}: an RC input is needed, 0 .. {8 * RC_BYTES - 1}", block=number)
        try:
            self.measuring.check(block, self.mask, machine)
            for function in block.functions:
                if block.synchron is not None:
                    raise MotionError("functions must be outside synchronous parts")
                if isinstance(function, Function):
                    check_function(function, self.functions, self.kinematic)
        except MotionError as error:
            raise block_fault(error, number, machine) from error
        for output in block.outputs:
            if output.number not in self.outputs or output.value not in (0.0, 1.0):
                raise BlockError(f"output {output.number}:{output.value:g}: {OUTPUTS_ARE}", block=number)


@dataclass(frozen=True, slots=True)
class Away:
    """Axes (bit n-1 = axis n of the cell) not commanded on as a program is ordered; windows: of the axes of the cell, in position."""

    axes: int = 0
    windows: Sequence[float] = ()

    def check(self, before: Sequence[float], behind: Sequence[float], number: int, machine: Machine, mask: int) -> None:
        """Check a block that moves one of them.  Raise BlockError before any motion if it leaves the window.  before, behind: (axes,)
        positions of the robot's axes, which are those of `mask`, before and after the block.
        """
        if not self.axes:
            return
        own = [n for n in range(mask.bit_length()) if mask >> n & 1]
        for axis, (place, start, end) in enumerate(zip(own, before, behind, strict=True)):
            least = self.windows[place] if place < len(self.windows) else MOVES
            if self.axes >> place & 1 and abs(end - start) > least:
                raise BlockError(DRIVE_ON_NOT_AVAILABLE, block=number, axis=machine.name(axis), source="rho 3")
