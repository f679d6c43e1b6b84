"""Which program the cycle runs: a job is ordered once, only its pieces are taken, and it is over once (AX-322).  Pure."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

from gateway.pure.image.records.inputs import FlyingAt
from gateway.pure.image.records.planner import VOID, FunctionAt, SwitchAt
from gateway.pure.image.records.points import LatchAt, ReferencePathPoint

Entry = SwitchAt | FunctionAt | FlyingAt | ReferencePathPoint | LatchAt
REACHED = 1e-9  # s at full speed


@dataclass(slots=True)
class ProgramRun:
    """job: ordered and not over, 0: none; mask: axes it may move (bit n-1 = axis n); begun: a piece of it was taken; complete: nothing more
    comes."""

    job: int = 0
    mask: int = 0
    begun: bool = False
    complete: bool = False
    switches: deque[Entry] = field(default_factory=deque)  # outputs to come, in the order of the way
    met: bool = False  # the input that ends the part came: its remaining records are dropped
    rests: bool = False  # nothing more comes of the part
    failed: bool = False  # its committed part still runs
    held: bool = False  # by an order to the stream: what comes waits
    backward: bool = False  # it goes back along its path as soon as the axes rest
    flushed: bool = False  # the part was ended by an order, not by its input
    late: bool = False  # the part was ended by its time, not by its input

    def order(self, job: int, mask: int = 0) -> None:
        """From now on pieces of this job are taken."""
        self.job, self.mask = job, mask
        self.begun, self.complete, self.failed = False, False, False
        self.held, self.backward = False, False
        self.part_over()

    def clear(self) -> None:
        """End it; its remaining records are dropped."""
        self.order(0)

    @property
    def waits(self) -> bool:
        """More of it has to come before it is done."""
        return self.job != 0 and not self.complete

    def part_over(self) -> None:
        """The next part begins from rest."""
        self.met, self.rests, self.flushed, self.late = False, False, False, False
        self.switches.clear()

    def switch(self, entry: Entry) -> None:
        """One more output, or call, to come."""
        if not isinstance(entry, SwitchAt) or entry.number != VOID:
            self.switches.append(entry)
            return
        while self.switches and self.switches[-1].piece >= entry.piece:
            self.switches.pop()

    def passed(self, piece: int, after: float, *, over: bool = False) -> Iterator[Entry]:
        """Yield the outputs whose place the set values have passed, each once, even when the path is run back and forth.  over: the path
        has reached its end.
        """
        waiting = self.switches
        while waiting and (over or waiting[0].piece < piece or (waiting[0].piece == piece and after >= waiting[0].after - REACHED)):
            yield waiting.popleft()
