"""Outputs of neutral blocks: each switches where the path is so far before the end of its block (blocks.Output)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from motion.errors import MotionError
from motion.program.blocks import Output

ROUNDING = 1e-9  # m or rad


class Switched(NamedTuple):
    """An output changes; share: where between the last cycle (0) and this one (1) the path passed the place."""

    number: int
    value: float
    share: float


@dataclass(slots=True)
class BlockOutputs:
    """Of one block.  length: m of its path (rad where only the orientation turns).  Each switches once: a stop, a lower
    override, a retrace and a second pass do not switch again."""

    outputs: tuple[Output, ...]
    length: float
    _at: float = field(default=0.0, init=False)
    _open: list[tuple[float, Output]] = field(init=False)

    def __post_init__(self) -> None:
        for output in self.outputs:
            if not 0.0 <= output.before <= self.length + ROUNDING:
                raise MotionError(f"output {output.number}: {output.before} before the end of a block of {self.length}")
        self._open = sorted(((max(self.length - o.before, 0.0), o) for o in self.outputs), key=lambda pair: pair[0])

    def step(self, way: float) -> Sequence[Switched]:
        """way: along the block at this cycle.  What switches in it, in the order of the places."""
        found: list[Switched] = []
        while self._open and way >= self._open[0][0] - ROUNDING:
            place, output = self._open.pop(0)
            share = (place - self._at) / (way - self._at) if way > self._at else 1.0
            found.append(Switched(output.number, output.value, min(max(share, 0.0), 1.0)))
        self._at = way
        return found
