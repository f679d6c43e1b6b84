"""Programs that also accept orders to a stream: flush, cut after a block, single step (AX-1080).  Pure.

Dropped blocks count as completed: blocks keep their numbers.  Hold, continue and retrace are orders to the cycle and need nothing here.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from gateway.pure.image.records.planner import BlockRecord, Part, PieceRecord, Say
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.handing_on import QUIET_TURNS
from gateway.pure.planning.planner import Programs
from motion.errors import MotionError
from motion.planner.planner import Planner
from motion.program.blocks import Block
from motion.program.team import Shared
from motion.sync.facts import BeltFacts
from motion.timing.slices import Work

ORDERS = (Say.FLUSH, Say.CUT, Say.SINGLE, Say.STEP)


@dataclass(frozen=True, slots=True)
class _Read:
    """A block that is not completed, as in the text, and the state after it."""

    number: int
    block: Block | Shared
    position: Sequence[float]
    belts: Sequence[BeltFacts]
    measured: int
    last: Block | None


@dataclass(slots=True)
class _Orders:
    """Orders of one stream.  dropped: last dropped block; stops_behind: the axes come to rest now and continue to the end of this block,
    -1: of none; ending: nothing follows the waiting blocks.
    """

    read: deque[_Read] = field(default_factory=deque)
    single: bool = False
    withheld: deque[tuple[int, Block | Shared]] = field(default_factory=deque)
    ending: bool = False
    dropped: int = 0
    stops_behind: int | None = None


class StreamPrograms(Programs):
    """See the module."""

    def __init__(self, cell: CellPrograms, lane: str = "") -> None:
        super().__init__(cell, lane)
        self._orders = _Orders()

    def _begin(self, job: int) -> None:
        super()._begin(job)
        self._chain.began()
        self._orders = _Orders()

    def _drop(self) -> None:
        super()._drop()
        self._orders = _Orders()

    # ---- statements --------------------------------------------------------------------------------------------------------
    def _obey(self, record: BlockRecord) -> Work[None]:
        orders = self._orders
        if record.say in ORDERS:
            self.state = replace(self.state, order_fault="")
            try:
                yield from self._ordered(record)
            except MotionError as error:
                self.state = replace(self.state, order_fault=str(error))
        elif record.say in (Say.FINISH, Say.END) and orders.withheld:
            orders.ending = orders.ending or record.say is Say.END
        else:
            yield from super()._obey(record)

    def _ordered(self, record: BlockRecord) -> Work[None]:
        orders = self._orders
        if not self._job.streams or (self._job.ended and record.say is not Say.FLUSH):
            raise MotionError("this stream has ended: it accepts no orders")
        if record.say is Say.FLUSH:
            self._flush()
        elif record.say is Say.CUT:
            under_way = max(self.state.block, min(self.state.passed + 1, len(self._job.line_of)))
            if int(record.text) < under_way:
                raise MotionError(f"block {record.text} is over: the axes are in block {under_way}")
            yield from self._cut(int(record.text), keep=False)
        elif record.say is Say.STEP:
            if not orders.withheld:
                raise MotionError("no block waits for its step" if orders.single else "the stream is not in single step")
            yield from self._step()
        elif record.text == "on":
            yield from self._cut(max(self.state.block, self.state.passed), keep=True)
            orders.single = True
        else:
            orders.single = False
            while orders.withheld:
                yield from self._released()
            yield from self._ended()

    def _read(self, read: Block | Shared, number: int) -> Work[None]:
        if self._orders.single:
            self._orders.withheld.append((number, read))
        else:
            yield from self._taken(read, number)

    def _taken(self, read: Block | Shared, number: int) -> Work[None]:
        yield from super()._read(read, number)
        job, orders = self._job, self._orders
        if not job.streams:
            return
        position: Sequence[float] | None = job.trial.position
        if position is None:
            position = self._behind_all(job.planner).position if isinstance(job.planner, Planner) else self._seen.position
        orders.read.append(_Read(number, read, position, job.trial.belts, job.measuring.last, job.last))
        while orders.read and orders.read[0].number < self.state.passed:
            orders.read.popleft()

    # ---- single step -------------------------------------------------------------------------------------------------------
    def _released(self) -> Work[None]:
        number, read = self._orders.withheld.popleft()
        yield from self._taken(read, number)

    def _step(self) -> Work[None]:
        """The next block that waits, to its end."""
        yield from self._released()
        if self._orders.withheld:
            if isinstance(self._job.planner, Planner) and not self._job.apart:
                yield from self._job.planner.ending()
                self._job.planner.finish()
            self._quiet = QUIET_TURNS
        else:
            yield from self._pause()
        yield from self._ended()

    def _ended(self) -> Work[None]:
        """Execute the end of the stream, which was received while blocks waited."""
        if self._orders.ending and not self._orders.withheld:
            self._orders.ending = False
            yield from super()._obey(BlockRecord(Say.END, self.state.job))

    # ---- dropped blocks ----------------------------------------------------------------------------------------------------
    def _flush(self) -> None:
        """Rest the axes where they are and drop all remaining statements."""
        job, orders = self._job, self._orders
        if job.bound:
            raise MotionError(f"the blocks under way follow {job.bound}: they can only be ended")
        orders.withheld.clear()
        orders.read.clear()
        orders.dropped = len(job.line_of)
        job.trial = job.trial.anew()
        job.held, job.open, job.error, job.skipping = False, False, "", ""
        if job.handed or job.planner is not None:
            job.trial.begins_at(self._robots(), self._own_places(self._seen.position), orders.dropped)
            self._rest_now(-1)

    def _rest_now(self, behind: int) -> None:
        """End the current part where the axes come to rest.  behind: they continue from there to the end of this block, -1: of none."""
        job = self._job
        if self._orders.stops_behind is None:
            self._out.append(PieceRecord(Part.FLUSH, self.state.job, self.generation))
        self._orders.stops_behind = behind
        job.handed, job.blocks = True, job.planner.added if isinstance(job.planner, Planner) else job.blocks
        job.error = ""

    def _cut(self, behind: int, *, keep: bool) -> Work[None]:
        """Drop the statements after this block, or keep them waiting for their step."""
        job, orders = self._job, self._orders
        rows, orders.read = list(orders.read), deque(each for each in orders.read if each.number <= behind)
        later = [each for each in rows if each.number > behind]
        if keep:
            orders.withheld.extendleft(reversed([(each.number, each.block) for each in later]))
        else:
            orders.withheld = deque(each for each in orders.withheld if each[0] <= behind)
            orders.dropped, job.cut_behind = len(job.line_of), behind
        if not later:
            return
        if orders.stops_behind is not None:
            orders.stops_behind = min(orders.stops_behind, behind - job.before)
            return
        planner = job.planner if isinstance(job.planner, Planner) and not job.handed else None
        ends = job.before + (job.blocks if planner is None else planner.added)
        stops = True
        if planner is not None and behind < ends:
            if job.bound:
                raise MotionError(f"the blocks under way follow {job.bound}: they can only be ended")
            stops = planner.cut(max(behind - job.before, 0))
        yield from self._again(rows, behind, ends)
        if not stops:
            self._rest_now(max(behind - job.before, 0))

    def _again(self, rows: Sequence[_Read], behind: int, ends: int) -> Work[None]:
        """Make the coming parts anew; later statements follow them.  ends: last block of the current part."""
        job, withheld = self._job, self._orders.withheld
        redo = [each for each in rows if ends < each.number <= behind]
        before = next((each for each in reversed(rows) if each.number <= min(ends, behind)), None)
        job.trial, job.open = job.trial.anew(), False
        if before is not None:
            job.trial.belts, job.measuring.last, job.last = before.belts, before.measured, before.last
        following = withheld[0][0] - 1 if withheld else len(job.line_of)
        if job.planner is not None or job.handed:
            position = self._own_places(self._seen.position) if before is None else before.position
            job.trial.begins_at(self._robots(), position, ends if redo else following)
        for each in redo:
            yield from self._added(self._adding(each.number), each.block, each.number)
        if redo:
            job.trial.passes_over(following - redo[-1].number)
        job.held = job.held and bool(job.trial.later)

    # ---- one turn ----------------------------------------------------------------------------------------------------------
    def _go_on(self) -> None:
        orders, job = self._orders, self._job
        behind, orders.stops_behind = orders.stops_behind, None
        if behind is not None and behind >= 0 and isinstance(job.planner, Planner) and self._left(job.planner, behind):
            return
        super()._go_on()
        if orders.dropped and job.planner is None and not job.handed and not job.trial.later:
            over = max(self.state.passed, orders.dropped)
            self.state = replace(self.state, block=max(self.state.block, over), passed=over)

    def _left(self, planner: Planner, behind: int) -> bool:
        """Let the stopped axes continue to the end of a block of the same part; False: they are beyond it."""
        job = self._job
        try:
            rows = planner.remaining(behind, self._chain.near(planner.end), self._own_places(self._seen.position))
        except MotionError as error:
            self.state = replace(self.state, order_fault=str(error))
            rows = []
        if not rows:
            return False
        self._chain.begin()
        job.planner = made = self._made(self._seen.position)
        made.given(rows)
        job.handed, job.arrived, job.blocks = False, False, made.added
        return True

    def _show(self) -> None:
        super()._show()
        self._chain.sees(self._seen.piece)
        planner, job = self._job.planner, self._job
        if self.state.job and job.handed and self._seen.piece and planner is not None:  # handed on completely, and still running
            tau = self._chain.tau(self._seen.piece, planner.end)
            block, share = planner.place(self._chain.near_to(tau, self._seen.piece, self._seen.position, self._seen.way))
            passed = max(self.state.passed, job.before + self._chain.passed(self._seen.piece, 0))
            self.state = replace(self.state, block=job.before + max(block, 1), share=share, passed=passed)
        shown = len(self._orders.withheld), self._job.bound, self._chain.back
        if (self.state.withheld, self.state.bound, self.state.back) != shown:
            self.state = replace(self.state, withheld=shown[0], bound=shown[1], back=shown[2])
        if self._chain.back and self._chain.block and self.state.job:
            self.state = replace(self.state, block=self._chain.block, share=0.0)
