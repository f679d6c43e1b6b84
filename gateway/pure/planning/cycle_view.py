"""The last state published by the cycle, in the planner's form."""

from collections.abc import Sequence
from typing import NamedTuple

ALWAYS = 1 << 62


class CycleView(NamedTuple):
    """Of one turn; a tuple, since one is made in each."""

    generation: int = 0
    piece: int = 0  # under way; 0: none
    position: Sequence[float] = ()  # where the axes are; m and rad
    moving: bool = False
    taken: int = ALWAYS  # the last order the cycle took: nothing is handed on before it knows of the job
    failed: int = 0  # the job that failed last
    parts: int = 0  # that are over
    engaged: float = 0.0  # belt value at which the robot got onto a belt
    met: bool = True  # the last part with an input ended by it
    measured: Sequence[float | None] = ()  # where the axes were measured last; None: they were not
    off: int = 0  # axes (bit n-1 = axis n) not commanded on
    override: float = 1.0
    waiting: int = 0  # records that the cycle has not yet read from the ring, of all lanes
    reached: int = ALWAYS  # record of the ring that the cycle took last, as the planner counts them
    way: float = 0.0  # m along the path, as the piece under way counts it
