"""What the corners of blocks of several kinematics are made of: each one's own route, and the pace on its own part of a corner."""

import copy
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import ClassVar

from motion.paths.joints import JointPath, joint_part
from motion.paths.together import State, repaced, rescaled
from motion.planner.block_paths import Leg, make_leg
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.planner.stretch import SMALLEST
from motion.program.blocks import Block, Slope
from motion.program.passing import passed


class Member(Route):
    """The route of one of several kinematics.  forced: shares of the blocks before and after that the next corner uses."""

    evens: ClassVar[bool] = False  # all go by one parameter

    def __init__(self, machine: Machine, start: Sequence[float]) -> None:
        super().__init__(machine, start)
        self.forced: tuple[float, float] | None = None

    def twin(self) -> "Member":
        """Another one at the same place."""
        made = copy.copy(self)
        made._now = replace(self._now)
        return made

    def number(self, next_: int) -> None:
        """Of the block that comes next."""
        self._now.number = next_ - 1

    def look(self, block: Block) -> tuple[float, float, float] | None:
        """Return (share of the last block, share of this one) for the corner between them, and the length of this one; None: it stops
        there.
        """
        last = self._now.last
        if last is None or last.block.slope is Slope.BLOCK:
            return None
        if not (last.block.blend.past_circles or passed(last.block.kind, block.kind, block_slope=False)):
            return None
        leg = make_leg(0, block, self._now.position, self._machine)
        if leg is None:
            return None
        leave, reach = super()._ranges(last, leg)
        return (leave / last.length, reach / leg.length, leg.length) if min(leave, reach) > SMALLEST else None

    def way(self, block: Block) -> float:
        """Length of its way from where the axes are; 0.0: none."""
        leg = make_leg(0, block, self._now.position, self._machine)
        return 0.0 if leg is None else leg.length

    def _ranges(self, last: Leg, leg: Leg) -> tuple[float, float]:
        if self.forced is None:
            return super()._ranges(last, leg)
        return self.forced[0] * last.length, self.forced[1] * leg.length


def cut(path: JointPath, at: float) -> tuple[JointPath, JointPath]:
    """In two."""
    return joint_part(path, 0.0, at), joint_part(path, at, path.length)


def paced(path: JointPath, rates: tuple[float, float], length: float) -> JointPath:
    """Lead from the rate (own s by common s) before a corner to the one after it, without a bend at both ends."""
    a, b = rates
    if abs(b - a) <= 1e-12 * max(a, b):
        return rescaled(path, length)
    if path.length < 0.5 * (a + b) * length * (1 - 1e-9):
        return repaced(path, _of_corner(rates, path.length, length), length)

    def pace(u: float) -> State:
        x, step = u / length, b - a
        return a * u + step * length * x**3 * (1 - 0.5 * x), a + step * x * x * (3 - 2 * x), step * 6 * x * (1 - x) / length

    return repaced(path, pace, length)


def _of_corner(rates: tuple[float, float], whole: float, length: float) -> Callable[[float], State]:
    """Of a corner between curves (motion.paths.corner), whose own s runs through a smooth step: its t from 0 to 1 is the even pace."""
    a, b = (1.0 / (rate * length) for rate in rates)  # t by s at both ends
    step = b - a

    def pace(u: float) -> State:
        t, x = u / length, 0.5
        low, high = 0.0, 1.0
        for _ in range(60):
            wrong = whole * (a * x + step * x**4 * (2.5 - 3 * x + x * x)) - t
            low, high = (low, x) if wrong > 0.0 else (x, high)
            x -= wrong / (whole * (a + step * x**3 * (10 - 15 * x + 6 * x * x)))
            if not low <= x <= high:
                x = 0.5 * (low + high)
            if abs(wrong) < 1e-15:
                break
        first = a + step * x**3 * (10 - 15 * x + 6 * x * x)
        second = step * 30 * x * x * (1 - x) ** 2 / whole
        rate = 1.0 / (length * first)
        return x * whole, rate, -second * rate * rate / first

    return pace
