"""A program in the planner: all state that is reset for the next one."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from gateway.pure.planning.parts import Coming, Measuring, apart
from gateway.pure.planning.trial import Trial
from motion.planner.file_plan import FilePlan
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.planner.team import Team
from motion.program.blocks import Block, Called, Output
from motion.program.factors import FULL, Factors
from motion.program.text.reader import Reader
from motion.program.text.team import TeamReader
from motion.sync.planned import BeltPlan


@dataclass(slots=True)
class Job:
    """Owned by Programs."""

    trial: Trial  # of parts to come
    measuring: Measuring
    planner: Planner | FilePlan | None = None
    reader: Reader | TeamReader = field(default_factory=Reader)
    number: int = 0  # of the program of the cell; 0: a stream
    factors: Factors = FULL
    whole: list[str] | None = None  # lines of a stream that is read completely before it moves
    lines: Iterator[tuple[int, str]] | None = None  # of a program of the cell, not read yet
    line_of: list[int] = field(default_factory=list)  # block - 1 -> line
    ended: bool = False
    start: Sequence[float] = ()  # of the axes where a part on a belt began
    part_start: Sequence[float] = ()  # of all robots, where the part under way began
    blocks: int = 0  # of the part under way
    handed: bool = False  # the current part is handed on completely, and another one follows
    measured: Sequence[float | None] = ()
    error: str = ""  # label at which to continue when the input of the current part does not come
    last: Block | None = None  # looked at
    before: int = 0  # blocks before the part under way
    robots: Machine | Team | None = None  # that the text names; None: nothing has asked as yet
    under_way: Coming | None = None  # the part that has begun; None: one of plain consecutive blocks
    open: bool = False  # it has begun and accepts blocks until another part follows
    streams: bool = True  # its blocks move on arrival; actions of the last ones without way are done at the end of their part
    arrived: bool = False  # the cycle has reported its end
    riding: BeltPlan | None = None  # it follows a belt of type 1: the plan that converts its blocks into the belt's frame
    held: bool = False  # the next part must be handed on completely, and is not known to its end yet
    skipping: str = ""  # label everything is left out up to
    cut_behind: int = 0  # block after which numbers are missing: following blocks do not belong to its part
    heard: int = 0  # statements and orders that have been read
    off: int = 0  # axes (bit n-1 = axis n) that are not commanded on, as the program was ordered

    @property
    def bound(self) -> str:
        """What the current part follows in addition to its path."""
        part = self.under_way
        if part is None or not (self.handed or self.planner is not None):
            return ""
        if part.tried is not None or part.inside is not None or part.act is not None:
            return "a belt"
        return "a correction (alter)" if part.alteration is not None else ""

    def over(self) -> None:
        """It failed, or was dropped: nothing of it comes any more."""
        self.planner, self.ended, self.lines, self.held = None, True, None, False

    # ---- parts of a stream -------------------------------------------------------------------------------------------------
    @property
    def apart(self) -> bool:
        """What is read is looked at only, for a part to come."""
        return self.trial.begun or self.handed

    @property
    def closed(self) -> bool:
        """Return whether the current part accepts no further block."""
        return self.ended or (self.trial.begun and not self.open)

    @property
    def last_part(self) -> bool:
        """The job ends with the part under way; of a stream one that ends with an input is answered first."""
        asks = self.streams and self.under_way is not None and self.under_way.asks_met
        return self.ended and not self.trial.later and not asks

    def divides(self, block: Block) -> bool:
        """Whether this block does not belong to the part under way, which is not looked at apart."""
        altered = self.under_way is not None and self.under_way.alteration is not None
        return not self.under_way.holds(block) if self.under_way is not None and altered else apart(block)

    def close(self) -> None:
        """End the current part: another part follows it."""
        if self.open and isinstance(self.planner, Planner):
            self.planner.finish()
        self.open = False

    def left(self) -> tuple[Called | Output, ...]:
        """Calls and outputs of blocks without way in a part that is run on arrival."""
        return self.planner.left() if isinstance(self.planner, Planner) and not self.streams else ()

    def left_out(self, label: str) -> bool:
        """Return whether to skip a block after an input that never came, before the label at which the program continues."""
        if self.skipping and label == self.skipping:
            self.skipping = ""
        return self.skipping != ""

    def skip(self, label: str) -> None:
        """Skip everything up to this label, including blocks that have not arrived yet."""
        if not self.trial.skip(label):
            self.skipping = label

    def coming(self, unmeasured: Callable[[Coming], bool]) -> Coming | None:
        """The next part."""
        part = self.trial.coming(unmeasured)
        self.skipping = self.trial.skipping or self.skipping
        if self.skipping:
            self.before = len(self.line_of)  # all that was read is left out
        return part

    def begins(self, part: Coming) -> None:
        """The part is under way; the last one that is known stays open, where what comes may belong to it."""
        self.under_way, self.riding = part, None
        cut = part.number + max(len(part.blocks), len(part.shared)) - 1 == self.cut_behind
        self.open = part.open = not (self.ended or self.trial.later or cut) and part.goes_on
        self.trial.under_way = part
        if self.open and part.tried is None:
            self.trial = self.trial.anew()

    def rests(self) -> None:
        """Reset to no known blocks: following ones are tried from the present position of the axes."""
        self.planner, self.under_way, self.riding, self.open = None, None, None, False
        self.trial = self.trial.anew()
