"""The planner process without its rings: records in, records out, once a turn.  Pure.

A job is a program.  Either it comes as a stream (BEGIN, statements of the text form, FINISH as often as wanted, END), and moves as soon
as enough is known; or it is a program of the cell (RUN), which is read completely and tried block by block before any of it is handed to
the cycle (AX-322).  A stream accepts the same statements: its parts begin as they become known, and the last one stays open for further
blocks (AX-970).  A fault in a block ends the job, and the blocks handed on before it end at rest.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

from gateway.pure.image.records.planner import (
    ANSWERS,
    BLOCKS,
    Answer,
    BlockRecord,
    PieceRecord,
    PlannerState,
    Say,
    job_over,
    restated,
    run_of,
)
from gateway.pure.planning.belt_statements import act_order, act_record, belts_after, sets_type
from gateway.pure.planning.cell_checks import Away, OfCell
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.cycle_view import CycleView
from gateway.pure.planning.handing_on import QUIET_TURNS, HandingOn
from gateway.pure.planning.job import Job
from gateway.pure.planning.parts import Coming, Measuring, later_fault
from gateway.pure.planning.team import (
    begun_part,
    machines_in,
    not_measured,
    own_axes,
    own_blocks,
    reader_for,
    systems_of,
)
from gateway.pure.planning.tool_shown import ToolShown
from gateway.pure.planning.trial import Behind, Trial
from motion.errors import MotionError
from motion.planner.marks import at_rest
from motion.planner.planner import Planner
from motion.program.blocks import Block
from motion.program.errors import BlockError
from motion.program.factors import Factors
from motion.program.team import Shared
from motion.sync.alterable import check_alterable
from motion.sync.belts import Type
from motion.sync.facts import BeltFacts
from motion.timing.slices import Work


class Programs(HandingOn):
    """What the robots of a run are moved by."""

    def __init__(self, cell: CellPrograms, lane: str = "") -> None:
        super().__init__(cell, lane)
        self._typed: tuple[Sequence[BeltFacts], tuple[tuple[int, int], ...]] = ((), ())  # as published
        self._placed = 0  # axes whose positions were set in this cycle (SF 3)
        self._tool = ToolShown()

    def turn(self, records: Sequence[BlockRecord], view: CycleView) -> list[PieceRecord]:
        """records: new ones; view: the rest is the cycle's."""
        seen, self._seen = self._seen, view
        if view.generation != seen.generation:
            self._belts, self._placed = self.cell.belts, 0  # a start-up of the control
            self._reading.forget()
            self._drop()
            self.workpiece.started_up()
            self._out.clear()
        if view.failed and view.failed == self.state.job:
            self._drop()
        self._quiet += 1
        self._listen(records)
        if self.state.job and self._job.handed and view.parts != seen.parts:
            self._job.measured, self._job.arrived = view.measured, True
        if self.state.job and not self._reading.under_way:  # a statement half read belongs to the present job
            if self._job.arrived:
                self._go_on()
            elif self._job.held:
                self._next()
        return self.go_on()

    def go_on(self) -> list[PieceRecord]:
        """Return the records due in this turn; plan again where a law was made in its remaining time."""
        self._plan()
        self._show()
        taken = self._seen.taken
        out = [record for record in self._out if record.job <= taken]  # a cycle that does not know the job yet would drop its fault
        self._out = [record for record in self._out if record.job > taken]
        return out

    def handed_on(self, number: int) -> None:
        """The last record of the turn, as the ring counts them."""
        self._chain.sent = number

    def _show(self) -> None:
        """Belts, axes, systems and tool as the page and the next planner read them."""
        if self._typed[0] is not self._belts:
            self._typed = self._belts, tuple((each.kind.value, each.tolerance) for each in self._belts)
        types = self._typed[1]
        self.workpiece.reached(self.state.block)
        self._tool.reached(self.state.block)
        systems, tool = self.workpiece.shown, self._tool.shown
        said = self.generation, types, self._placed, systems, tool, self._job.heard
        shown = self.state
        if (shown.cycle, shown.types, shown.placed, shown.systems, shown.tool, shown.heard) != said:
            heard = self._job.heard
            self.state = restated(shown, cycle=self.generation, types=types, placed=self._placed, systems=systems, tool=tool, heard=heard)

    def follows(self, before: PlannerState) -> None:
        """Adopt the last report of the previous planner: belts stay as programs have set them, as long as its cycle runs (AX-394)."""
        if before.cycle and len(before.types) == len(self.cell.belts):
            self._seen, self._placed = CycleView(before.cycle), before.placed
            self.workpiece.follows(before.systems)
            self._tool.shown = before.tool
            rows = zip(self.cell.belts, before.types, strict=True)
            self._belts = tuple(replace(each, kind=Type(kind), tolerance=tolerance) for each, (kind, tolerance) in rows)

    # ---- statements --------------------------------------------------------------------------------------------------------
    def _listen(self, records: Sequence[BlockRecord]) -> None:
        """Process new records up to a slow one: prepare() continues it, and the next turn continues with the records after it."""
        for record in records:
            if record.say is Say.DROP:
                self._reading.forget()
                self._drop()
            else:
                self._reading.put(partial(self._heard, record))
        while self._reading.busy:
            self._quiet = 0
            if not self._reading.go():
                break

    def _heard(self, record: BlockRecord) -> Work[None]:
        if record.say is Say.BEGIN and self.state.job and not self._job.ended:
            return  # one stream at a time; the ordering source sees that its job did not begin
        if record.say in (Say.BEGIN, Say.RUN, Say.STREAM):
            self._begin(record.job)
            self._job.off = self._seen.off if record.say is Say.RUN else 0
            self._job.streams = self._job.trial.streams = record.say is not Say.RUN
        if record.job != self.state.job:
            return
        self._job.heard += record.say is not Say.STREAM
        try:
            yield from self._obey(record)
        except MotionError as error:
            self._fail(error)

    def _begin(self, job: int) -> None:
        """A program of the cell is ordered at rest alone, so whatever job was there is over."""
        self._chain.begin()
        self.state = PlannerState(job=job, failed_job=self.state.failed_job)
        self._job = Job(Trial(self._belts, self.cell.files), Measuring(self.cell.channels, self.cell.systems))
        self._tool.begin()
        self.slowing.begin()
        self.workpiece.begin()

    def _obey(self, record: BlockRecord) -> Work[None]:
        if record.say is Say.RUN:
            order = run_of(record)
            self._job.factors = Factors(order.velocity, order.acceleration, order.acceleration)
            self._job.number = self._job.trial.program = order.number
            self._job.lines = enumerate(self.cell.text_of(order.number).splitlines(), 1)
            return
        if record.say is Say.LOST:
            self.lost(*map(int, record.text.split()))
            return
        if record.say in (Say.STREAM, Say.WHOLE) or (self._job.whole is not None and record.say in (Say.LINE, Say.END)):
            self._collect(record)
            return
        if record.text:
            yield from self._statement(record.text, 0)
        if record.say is Say.FINISH:
            yield from self._pause()
        if record.say is Say.END:
            self._job.reader.ended()
            yield from self._behind()
            yield from self._end()

    def _pause(self) -> Work[None]:
        """Pause the stream: the axes come to rest at the last target, and the actions at rest after it are done."""
        if isinstance(self._job.planner, Planner):
            yield from self._job.planner.ending()
            self._job.planner.finish()
        self._quiet = QUIET_TURNS
        if self._job.reader.acts and not self._job.reader.inside:
            yield from self._behind()
            self._job.reader.acts = ()

    def _collect(self, record: BlockRecord) -> None:
        """Collect the lines of a stream that is read completely, with its job."""
        if record.say is Say.STREAM:
            self._job.number = self._job.trial.program = -int(record.text)
            self._job.whole = None
        elif record.say is Say.WHOLE:
            self._job.whole = []
            self._job.streams = self._job.trial.streams = False
        elif self._job.whole is not None and record.say is Say.LINE:
            self._job.whole.append(record.text)
        elif self._job.whole is not None:
            self._job.lines, self._job.whole = enumerate(self._job.whole, 1), None

    def _statement(self, text: str, line: int) -> Work[None]:
        self._job.reader = reader_for(text, self._job.reader)
        self._job.reader.statement(text, line)
        for read in self._job.reader.take():
            self._job.line_of.append(line)
            yield from self._read(read, len(self._job.line_of))

    def _read(self, read: Block | Shared, number: int) -> Work[None]:
        """One block of the text."""
        planner, robots = self._adding(number), self._robots()
        block = self.workpiece.placed(read, number, robots, self.cell.kinematic_of)
        for machine, own in own_blocks(robots, block):
            mask, kinematic = self.cell.mask_of(machine), self.cell.kinematic_of(machine)
            cell = OfCell(self.cell.functions, self.cell.outputs, self._job.measuring, mask, kinematic)
            cell.check(own, number, machine)
            self._tool.placed(number, own.tool.pose, kinematic)
        if self._job.left_out(block.label):
            self._job.planner = None
            self.state = replace(self.state, block=number, passed=number)
            return
        yield from self._added(planner, block, number)
        self._job.trial.armed_by(block)

    def _added(self, planner: Planner, block: Block | Shared, number: int) -> Work[None]:
        """The block goes to the part it belongs to."""
        robots = self._robots()
        alone = block.alone if isinstance(block, Shared) else (0, block)
        if alone is not None:
            member, own = alone
            option = self.cell.kinematic_of(machines_in(robots)[member]) in self.cell.altered
            check_alterable(own, self._job.last, number, option=option)
            self._job.last = own
            yield from self._add(planner, own, number, member)
            return
        assert isinstance(block, Shared)
        self._job.last = None
        if self._job.trial.begun or block.asks or planner.machine is not robots:
            self._job.close()
            self._job.trial.together(self._behind_all(planner), block, number, self.cell.kinematic_of)
        else:
            self._add_whole(planner, block)

    def _behind_all(self, planner: Planner) -> Behind:
        """Return where all robots are after the blocks of this planner."""
        part = self._job.under_way
        return Behind(planner, self._robots(), self._job.part_start, 0 if part is None else part.member)

    def _adding(self, number: int) -> Planner:
        """Return the planner to which this block is added; for blocks that are only tried so far, the planner that tries them."""
        planner = self._job.planner
        if self._job.apart or not isinstance(planner, Planner):
            made = self._made(self._seen.position)
            if self._job.apart:
                return made
            planner = self._job.planner = made
            self._job.before, self._job.blocks = number - 1, 0
        return planner

    def _add(self, planner: Planner, block: Block, number: int, member: int) -> Work[None]:
        """A block that ends with an input, waits for one or goes to @MPOS, and a part on a belt, are parts of their own: where they begin
        or end is known only then.  What comes after is tried as if the part had reached its target, the belt where it was programmed."""
        job = self._job
        if job.riding is not None and job.open and job.under_way is not None and job.under_way.holds(block):
            yield from job.trial.ending(planner, block)
            job.trial.joined(job.under_way, block)
            assert isinstance(job.planner, Planner)
            yield from job.planner.ending(block)
            self._joined(job.riding.add(block))
        elif job.trial.begun or job.divides(block):
            yield from job.trial.ending(planner, block, member)
            job.close()
            kinematic = self.cell.kinematic_of(machines_in(self._robots())[member])
            job.trial.add(self._behind_all(planner), block, number, kinematic, member)
        else:
            yield from planner.ending(block)
            self._add_whole(planner, Coming.marked(block))

    def _joined(self, block: Block) -> None:
        """A block of the part on a belt that has begun, as seen from the belt."""
        planner = self._job.planner
        assert isinstance(planner, Planner)
        try:
            planner.add(block)
        except BlockError as error:
            raise later_fault(error, self._job.before) from error

    def _add_whole(self, planner: Planner, block: Block | Shared) -> None:
        before, away = planner.position, Away(self._job.off, self.cell.windows)
        try:
            planner.add(block)
        except BlockError as error:
            raise later_fault(error, self._job.before) from error
        for machine, first in own_axes(planner.machine):
            own = slice(first, first + machine.axes)
            away.check(before[own], planner.position[own], len(self._job.line_of), machine, self.cell.mask_of(machine))

    def _behind(self) -> Work[None]:
        """Add the actions at rest after the last block."""
        if self._job.reader.acts:
            planner = self._adding(len(self._job.line_of) + 1)
            yield from self._job.trial.ending(planner)
            self._job.close()
            self._job.trial.behind(self._behind_all(planner), self._job.reader.acts, len(self._job.line_of), self._job.reader.labels.label)
        if any(systems := systems_of(self._job.reader)):
            number = len(self._job.line_of) + 1
            self.workpiece.behind(systems, number, self._robots(), self.cell.kinematic_of)

    def _go_on(self) -> None:
        """A part is over, and the axes rest where it ended, or have got onto a belt: the next one begins."""
        self._chain.begin()
        job = self._job
        job.handed, job.arrived, job.before, job.blocks = False, False, job.before + job.blocks, 0
        self._answer()
        if job.error and not self._seen.met:
            job.skip(job.error)
        job.error = ""
        self._next()

    def _answer(self) -> None:
        """What is known of a block that ended with its input, or without it."""
        part = self._job.under_way
        if part is not None and part.asks_met:
            places = tuple(self._seen.measured) if self._seen.met else ()
            answer = Answer(self._job.before, self._seen.met, places)
            self.state = replace(self.state, answers=(*self.state.answers, answer)[-ANSWERS:])

    def _next(self) -> None:
        """Begin the next known part; a stream may have none yet, and a part that must be handed on completely has to be complete."""
        job, position = self._job, self._seen.position
        job.held = False

        def unmeasured(part: Coming) -> bool:
            return not_measured(part, self._robots(), job.measured, self.cell.mask_of)

        part = job.coming(unmeasured)
        while part is not None and part.act is not None and sets_type(part.act):
            self._belts = belts_after(part.act, self._belts)  # nothing for the cycle to do
            part = job.coming(unmeasured)
        if part is None:
            job.rests()  # nothing is left to plan, or as yet
            self.state = replace(self.state, block=max(job.before, self.state.block), share=1.0, passed=max(job.before, self.state.passed))
            return
        if part.follows and not (job.ended or job.trial.later or self._quiet > QUIET_TURNS):
            job.trial.later.appendleft(part)
            job.planner, job.held = None, True
            return
        job.before, job.error = part.number - 1, part.error
        job.begins(part)
        try:
            self._next_part(part, position, self._seen.engaged)
        except MotionError as error:
            self._fail(error)

    def _next_part(self, part: Coming, position: Sequence[float], engaged: float) -> None:
        job, generation = self.state.job, self.generation
        robots = self._robots()
        machine = machines_in(robots)[part.member]
        mask, self._job.part_start = self.cell.mask_of(machine), self._own_places(position)
        planner = self._made(position, machine if part.alone else robots)
        self.state = replace(self.state, passed=max(self.state.passed, self._job.before))
        own = part.own(mask, job, generation)
        if part.act is not None:
            order = act_order(part.act, self._belts, part.number)
            assert order is not None
            own = act_record(job, generation, order)
        if own is not None:
            self._job.planner, self._job.handed = None, True
            self._placed |= mask if part.point else 0
            self._out.append(own)
            self.state = replace(self.state, block=self._job.before, share=1.0)
            return
        if part.blocks and part.blocks[0].file is not None:
            self._job.planner, self._job.blocks = self.cell.files.played(part, planner, self._job.factors.velocity, mask), 1
            return
        if part.engages or part.follows:
            self._job.start, self._job.handed = planner.position, True
            if part.engages:
                self._out.append(part.engagement(job, generation))
            else:
                self._job.blocks = len(part.blocks)
                self._out += part.followed(planner.robot, planner.position, job, generation)
            self.state = replace(self.state, block=self._job.before + 1, share=0.0)
            return
        blocks = part.blocks
        if part.tried is not None:
            self._job.riding = part.again(planner.robot, self._job.start)
            carried, start, blocks = part.carried(self._job.riding, engaged)
            planner = replace(planner, machine=carried, start=start)
        rows = part.shared or blocks
        self._job.planner, self._job.blocks = planner, len(rows)
        records = begun_part(part, rows, planner, self._job.measuring, self._job.measured, self.cell.mask_of, job, generation)
        self._out += [*part.begins(job, generation, self.cell.kinematic_of(machines_in(planner.machine)[0])), *records]
        if not self._job.open:
            self._mark(at_rest(each) for each in planner.left())

    def _end(self) -> Work[None]:
        if isinstance(self._job.planner, Planner):
            yield from self._job.planner.ending()
            self._job.planner.finish()
        self._job.trial.check_done(len(self._job.line_of), self._job.left())
        self._job.ended = True
        self._quiet = QUIET_TURNS

    @property
    def preparing(self) -> bool:
        """Return whether a program of the cell is not read to its end yet or a slow statement is in progress."""
        return self._job.lines is not None or self._reading.busy

    def prepare(self, position: Sequence[float]) -> None:
        """One more line of it, or a slice of one: its block is tried from where the one before ends, and nothing of it moves meanwhile.
        standing: the axes, now."""
        self._seen = self._seen._replace(position=position)
        if self._job.lines is not None and not self._reading.busy:
            self._reading.put(partial(self._line, self._job.lines))
        self._reading.go()

    def _line(self, lines: Iterator[tuple[int, str]]) -> Work[None]:
        try:
            number, text = next(lines, (0, ""))
            if number:
                yield from self._statement(text, number)
            else:
                self._job.reader.ended()
                yield from self._behind()
                yield from self._end()
                self._job.lines = None
        except MotionError as error:
            self._fail(error)

    def lost(self, count: int, most: int = BLOCKS) -> None:
        """End a stream that lost `count` statements: the ones after them would no longer mean what was intended."""
        if self.state.job and self._job.streams and not self._job.ended:
            lost = "a statement of the stream is" if count == 1 else f"{count} statements of the stream are"
            words = f"{lost} lost: more than {most} arrived before the planner used them"
            self._fail(BlockError(words, block=len(self._job.line_of) + 1))

    def _drop(self) -> None:
        self._job.over()
        self._reading.stop()
        self._chain.begin()
        self.state = job_over(self.state, waiting=0, ended=True, warning="")
