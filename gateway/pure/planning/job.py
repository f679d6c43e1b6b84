"""A program under way in the planner: everything that begins anew with the next one."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from gateway.pure.planning.parts import Measuring
from gateway.pure.planning.trial import Trial
from motion.planner.file_plan import FilePlan
from motion.planner.planner import Planner
from motion.program.blocks import Block
from motion.program.factors import FULL, Factors
from motion.program.text.reader import Reader
from motion.program.text.team import TeamReader


@dataclass(slots=True)
class Job:
    """Owned by Programs."""

    trial: Trial  # of parts to come
    measuring: Measuring
    planner: Planner | FilePlan | None = None
    reader: Reader | TeamReader = field(default_factory=Reader)
    number: int = 0  # of the program of the cell; 0: a stream
    factors: Factors = FULL
    whole: list[str] | None = None  # lines of a stream that is read whole
    lines: Iterator[tuple[int, str]] | None = None  # of a program of the cell, not read yet
    line_of: list[int] = field(default_factory=list)  # block - 1 -> line
    ended: bool = False
    start: Sequence[float] = ()  # of the axes where a part on a belt began
    blocks: int = 0  # of the part under way
    handed: bool = False  # the part under way is handed on whole, and another one follows
    measured: Sequence[float | None] = ()
    error: str = ""  # label to go on at when the input of the part under way does not come
    last: Block | None = None  # looked at
    before: int = 0  # blocks before the part under way
    off: int = 0  # axes (bit n-1 = axis n) that are not commanded on, as the program was ordered

    def over(self) -> None:
        """It failed, or was dropped: nothing of it comes any more."""
        self.planner, self.ended, self.lines = None, True, None
