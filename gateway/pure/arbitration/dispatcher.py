"""Command dispatcher: validates commands from the command sources, issues orders to the cycle and keeps each command source's
outcome.

Pure: what the cycle publishes (CellState) and time come in, orders and events go out.  Nothing is kept across a restart:
a new dispatcher has no jobs, so a command already present starts nothing (design: a command is taken once).
"""

import functools
import operator
from collections.abc import Callable, Mapping, Sequence

from gateway.pure.arbitration.admission import Admission
from gateway.pure.arbitration.axis_masks import axes_with, names_of
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.jobs import AxisFacts, DispatcherEvent, Job, OnLoss, SourceState
from gateway.pure.arbitration.outcomes import Outcomes
from gateway.pure.arbitration.outgoing import OutgoingOrders
from gateway.pure.arbitration.overrides import Overrides
from gateway.pure.arbitration.ownership import NOBODY, Ownership
from gateway.pure.cell.web import PAGE_SOURCE
from gateway.pure.image.reasons import CommandState, Reason, Refusal
from gateway.pure.image.records.cell import EVERY_AXIS, AxisFlag, CellState, Motion, Order, OrderRecord
from gateway.pure.image.records.planner import PlannerState, ProgramFacts, ProgramOrder
from protocols.base.machine import Ns, ms

ENABLE_PATIENCE = ms(5_000)  # brake, power and enabling of six drives need well under 2 s
RESET_PATIENCE = ms(2_000)

Planner = Callable[[Sequence[float], Sequence[float], int, float, float, int], bytes]  # start, target (SI), mask, v, a, job -> piece
ABOUT_AXES = (Code.ENABLE, Code.DISABLE, Code.REFERENCE, Code.PTP_ABSOLUTE, Code.PTP_RELATIVE, Code.AXES_OVERRIDE)
NO_PROGRAMS: Mapping[int, ProgramFacts] = {}


class CommandDispatcher:
    """Commands in, orders out."""

    def __init__(
        self, axes: Sequence[AxisFacts], plan: Planner, first_job: int, programs: Mapping[int, ProgramFacts] = NO_PROGRAMS
    ) -> None:
        """`first_job`: a number above every job a predecessor may have used; `programs`: those of the cell, by their numbers."""
        self.axes = tuple(axes)
        self.programs = programs
        self.planner: PlannerState | None = None  # state of the planner process; None: it does not run
        self.control = Ownership()
        self.cell: CellState | None = None
        self.admission = Admission(self.axes)
        self.overrides = Overrides(len(self.axes))
        self._outcomes = Outcomes(self.axes)
        self._plan = plan
        self._outgoing = OutgoingOrders(first_job)
        self._sources: dict[int, SourceState] = {}
        self._open: list[Job] = []
        self._events: list[DispatcherEvent] = []
        self._first_try = False
        self._moves: list[Job] = []  # moves and reference runs that axes are on: one at most of each lane

    def bar(self, mask: int) -> None:
        """These axes are disabled at the interface: off at once whichever source has control, and not moved until a new start (AX-333)."""
        new, self.admission.barred = mask & ~self.admission.barred, mask
        if new & self.enabled_mask():
            self._order(Order.DISABLE, mask=new, reason=Reason.DRIVES_OFF)

    def multiply_override(self, factor: float) -> None:
        """A factor on every override, whichever source has control (AX-1000)."""
        if self.cell is not None:
            for mask, value in self.overrides.multiplied(factor, self.cell):
                self._order(Order.OVERRIDE, mask=0 if mask == self.admission.every_axis else mask, value=value)

    def restore_belt_offset(self, place: int, offset: float) -> None:
        """Offset of a belt's counter to its encoder when last seen; NaN: unknown (AX-480)."""
        self._order(Order.BELT, mask=place, value=offset)

    def open_ready(self) -> None:
        """As an open chain, whichever source has control."""
        self._order(Order.EMERGENCY)

    # ---- what the others ask ---------------------------------------------------------------------------------------------
    def source(self, number: int) -> SourceState:
        """State of one command source; made at the first call."""
        return self._sources.setdefault(number, SourceState())

    def take_orders(self) -> list[OrderRecord]:
        """Orders since the last call, in order."""
        return self._outgoing.take_orders()

    def take_programs(self) -> list[ProgramOrder]:
        """For the planner, since the last call; to be handed over after take_orders()."""
        return self._outgoing.take_programs()

    def take_events(self) -> list[DispatcherEvent]:
        """Events since the last call."""
        events, self._events = self._events, []
        return events

    def enabled_mask(self, flag: AxisFlag = AxisFlag.ENABLED) -> int:
        """Axes (bit n-1 = axis n) with `flag` set."""
        return axes_with(flag, self.cell, len(self.axes))

    def strayed(self, language: str = "en") -> str:
        """Describe the axes that did not follow or did not come to rest."""
        return self._outcomes.strayed(self.cell, language)

    # ---- time passes ----------------------------------------------------------------------------------------------------
    def observe(self, cell: CellState, now: Ns) -> None:
        """Adopt the state published by the cycle and settle the open jobs; generation 0: there is no cycle."""
        before, self.cell = self.cell, cell
        if before is not None and before.generation != cell.generation:
            for job in self._open:
                self._end(job, CommandState.ABORTED, Reason.CYCLE_RESTARTED)
            self._moves.clear()
        for job in list(self._open):
            self._settle(job, cell, now)
        self._open = [job for job in self._open if job.open]
        self._moves = [job for job in self._moves if job.open]

    def _settle(self, job: Job, cell: CellState, now: Ns) -> None:
        if job.state is CommandState.ACCEPTED and (cell.moves(job.id) if job.code == Code.PROGRAM else cell.taken >= job.id):
            job.state = CommandState.RUNNING
        outcome = self._outcomes.of(job, cell)
        if outcome is not None:
            detail = self._outcomes.fault(job, cell, self.planner, outcome)
            self._end(job, self._outcomes.ended(job, outcome), outcome, detail)
        elif job.until is not None and now >= job.until:
            self._end(job, CommandState.ABORTED, *self._outcomes.why_not(job, cell))

    def _end(self, job: Job, state: CommandState, reason: Reason, detail: str = "") -> None:
        job.state, job.reason, job.detail = state, reason, detail or job.detail
        if not (job.quiet and state is CommandState.DONE):
            self._events.append(DispatcherEvent(state.name.lower(), job.source, job.code, reason, job.detail))

    # ---- commands --------------------------------------------------------------------------------------------------------
    def command(self, source: int, command: Command, now: Ns, *, first_try: bool = False) -> Job:
        """Judge one fresh command of a command source; its outcome is in the returned Job (refused at once or open).

        `first_try`: a relative move of a single axis that has not been referenced yet (AX-312); everything else is judged as ever.
        """
        self._first_try = first_try
        job = Job(
            self._outgoing.number(), source, command.code, mask=command.mask, held=source == PAGE_SOURCE and command.code != Code.PROGRAM
        )
        state = self.source(source)
        state.last = state.by_code[command.code] = job
        try:
            if command.code not in Code._value2member_map_:
                raise Refusal(Reason.UNKNOWN_CODE, str(command.code))
            self._judge(job, Code(command.code), command, now)
        except Refusal as refusal:
            self._end(job, CommandState.REFUSED, refusal.reason, refusal.detail)
        if job.open:
            self._open.append(job)
            self._events.append(DispatcherEvent("accepted", source, job.code, Reason.NONE, ""))
        return job

    def refuse(self, source: int, code: Code, reason: Reason, detail: str) -> Job:
        """Refuse a command that a command source could not issue because of its numbers; its outcome is stored like any other."""
        job = Job(self._outgoing.number(), source, code)
        state = self.source(source)
        state.last = state.by_code[code] = job
        self._end(job, CommandState.REFUSED, reason, detail)
        return job

    def _judge(self, job: Job, code: Code, command: Command, now: Ns) -> None:
        cell = self.cell
        if cell is None or not cell.generation:
            raise Refusal(Reason.NOT_READY, "the cycle does not run")
        if code in (*ABOUT_AXES, Code.REQUEST_CONTROL, Code.RELEASE_CONTROL):
            job.span = cell.span(job.mask & self.admission.every_axis)
        at_rest = cell.motion_of(job.span) in (Motion.IDLE, Motion.STOPPED)
        match code:
            case Code.REQUEST_CONTROL:
                self._request(job, cell, at_rest=at_rest)
            case Code.RELEASE_CONTROL:
                own = self.control.axes_of(job.source) & job.span
                self.control.release(job.source, at_rest=cell.motion_of(own) in (Motion.IDLE, Motion.STOPPED), axes=job.span)
                self._done(job)
            case Code.STOP:
                self._stop(job, cell)
            case _:
                self.control.demand(job.source)
                if code not in ABOUT_AXES or not job.mask & self.admission.every_axis:
                    job.span = self.control.axes_of(job.source)  # a command without axes concerns those its source controls
                self.control.demand(job.source, job.span)
                self._owners_command(job, code, command, cell, now)

    def _request(self, job: Job, cell: CellState, *, at_rest: bool) -> None:
        before = self.control.axes_of(job.source)
        if self.control.request(job.source, at_rest=at_rest, axes=job.span):
            self._events.append(DispatcherEvent("control", job.source, job.code, Reason.NONE, ""))
            new = job.span & ~before
            if cell.motion_of(new) is Motion.STOPPED:  # a rest another command source left must not be resumed by this one's first resume
                job.span = new
                job.id = self._drop_rest(new)  # done when the rest is gone: the next command must not find the axes busy
                return
        self._done(job)

    def _drop_rest(self, axes: int) -> int:
        """The number of the order's job."""
        number = self._order(Order.ABANDON, mask=_named(axes))
        for move in self._moves_of(axes):
            self._end(move, CommandState.ABORTED, Reason.ABANDONED)
            self._moves.remove(move)
        return number

    def _moved_by(self, mask: int, span: int) -> str:
        """What has the lanes (`span`) of these axes, and which of the axes; "": what moves was not ordered."""
        move = next(iter(self._moves_of(span)), None)
        if move is None:
            return ""
        names = names_of(self.axes, mask & move.mask or move.mask)
        what = move.what or Code(move.code).name.lower().replace("_", " ")
        return f"{names}: {what} of command source {move.source} is under way"

    def _moves_of(self, axes: int) -> list[Job]:
        """Moves of the lanes with some of these axes."""
        return [move for move in self._moves if move.span & axes]

    def stop_move(self, move: Job) -> None:
        """Its lanes alone stop on their path: the process it belongs to is gone."""
        self._order(Order.STOP, mask=_named(move.span), reason=Reason.STOPPED_BY_SOURCE)
        move.reason, move.detail = Reason.STOPPED_BY_SOURCE, str(move.source)

    def abandon_move(self, move: Job) -> None:
        """Its rest is given up."""
        self._drop_rest(move.span)

    # ---- orders to a stream (AX-1080) --------------------------------------------------------------------------------------
    def hold_move(self, move: Job) -> None:
        """Its lanes rest on the path, and what still comes of it waits."""
        self._order(Order.HOLD, mask=_named(move.span), reason=Reason.STOPPED_BY_SOURCE)
        move.reason, move.detail = Reason.STOPPED_BY_SOURCE, str(move.source)

    def go_on_with(self, move: Job, *, back: bool = False) -> None:
        """Continue the held move, or run it back along its path.  Raise Refusal."""
        cell = self.cell
        if cell is None or not cell.generation:
            raise Refusal(Reason.NOT_READY, "the cycle does not run")
        self.control.demand(move.source, move.span)
        self._may_move(cell, self.admission.to_be_enabled(move, cell), idle=False)
        if cell.override_of(move.mask) <= 0.0:
            raise Refusal(Reason.OVERRIDE_ZERO)
        if not back:
            move.reason, move.detail = Reason.NONE, ""
        self._order(Order.RETRACE if back else Order.RESUME, mask=_named(move.span))

    def run_on(self, axes: int, distance: float) -> None:
        """Past the edge that ends a block of these axes: so far, in m or rad, from now on (rho 3 SF 42)."""
        self._order(Order.DISTANCE, mask=_named(axes), value=distance)

    def slow_move(self, move: Job, share: float) -> None:
        """A share, 0 .. 1, of the override, as long as it runs (rho 3 SF 41)."""
        self._order(Order.FACTOR, move.id, mask=_named(move.span), value=share)

    def _stop(self, job: Job, cell: CellState) -> None:
        """Every command source may stop, and stops all that moves."""
        self._order(Order.STOP, job.id, reason=Reason.STOPPED_BY_SOURCE)
        for move in self._moves:
            if move.open and cell.motion_of(move.span) is Motion.RUNNING:
                move.reason, move.detail = Reason.STOPPED_BY_SOURCE, str(job.source)

    def _owners_command(self, job: Job, code: Code, command: Command, cell: CellState, now: Ns) -> None:
        match code:
            case Code.ENABLE:
                self.admission.check_axes(job)
                self.admission.check_sent(job.mask)
                self.admission.check_enabling(cell)
                job.until = now + ENABLE_PATIENCE
                self._order(Order.ENABLE, job.id, mask=job.mask)
            case Code.DISABLE:
                self.admission.check_axes(job)
                job.until = now + ENABLE_PATIENCE
                self._order(Order.DISABLE, job.id, mask=job.mask)
            case Code.REFERENCE:
                self.admission.check_axes(job)
                self._may_move(cell, job.mask, referenced=False)
                self.admission.check_reference_run(cell, job.mask)
                self._moving(job)
                self._order(Order.REFERENCE, job.id, mask=job.mask, reason=_without_services(job))
            case Code.PTP_ABSOLUTE | Code.PTP_RELATIVE:
                self._ptp(job, command, cell, relative=code is Code.PTP_RELATIVE)
            case Code.PROGRAM:
                self._program(job, command, cell)
            case Code.RESUME:
                self._resume(job, cell)
            case Code.ABANDON:
                job.span = cell.stopped(job.span)
                if not job.span:
                    raise Refusal(Reason.NOTHING_TO_RESUME)
                job.id = self._drop_rest(job.span)
            case Code.FAULT_RESET:
                job.until = now + RESET_PATIENCE
                self._order(Order.RESET, job.id)
            case Code.OVERRIDE | Code.AXES_OVERRIDE:
                if code is Code.AXES_OVERRIDE:
                    self.admission.check_named(job)
                if not 0.0 <= command.velocity <= 1.0:
                    raise Refusal(Reason.RATE, f"override {command.velocity:.2%}; 0..100 %")
                axes = cell.kinematics(job.mask) if code is Code.AXES_OVERRIDE else job.span
                self._order(Order.OVERRIDE, job.id, mask=_named(axes), value=self.overrides.ordered(axes, command.velocity))

    def _resume(self, job: Job, cell: CellState) -> None:
        """Continue every stopped move of its lanes."""
        moves = self._moves_of(cell.stopped(job.span))
        if not moves:
            raise Refusal(Reason.NOTHING_TO_RESUME)
        for move in moves:
            self._may_move(cell, self.admission.to_be_enabled(move, cell), idle=False)
        for move in moves:
            move.reason, move.detail = Reason.NONE, ""
        job.watch, job.also = moves[0].id, tuple(move.id for move in moves[1:])
        self._order(Order.RESUME, job.id, mask=_named(functools.reduce(operator.or_, (move.span for move in moves))))

    def _moving(self, job: Job) -> None:
        """Its lanes are this job's."""
        job.watch = job.id
        self._moves.append(job)

    def _ptp(self, job: Job, command: Command, cell: CellState, *, relative: bool) -> None:
        self.admission.check_axes(job)
        if job.mask >> len(command.targets):
            missing = ", ".join(axis.name for n, axis in enumerate(self.axes) if n >= len(command.targets) and job.mask >> n & 1)
            raise Refusal(Reason.MASK, f"{job.mask:04X}h; {len(command.targets)} targets are given, none for {missing}")
        alone = self._first_try and relative and job.mask.bit_count() == 1
        self._may_move(cell, job.mask, referenced=not alone)
        self.admission.check_rates(command, cell.override_of(job.mask))
        start = [axis.set for axis in cell.axes[: len(self.axes)]]
        target = self.admission.ptp_targets(job.mask, command, start, relative=relative)
        piece = self._plan(start, target, job.mask, command.velocity, command.acceleration, job.id)
        self._moving(job)
        self._order(Order.MOVE, job.id, mask=job.mask, reason=_without_services(job), piece=piece)

    def order_program(self, source: int, number: int, now: Ns, velocity: float = 1.0, acceleration: float = 1.0) -> Job:
        """A command source selects a program of the cell by its number, whichever way it names it."""
        return self.command(source, Command(Code.PROGRAM, number, velocity, acceleration), now)

    def order_stream(self, source: int, robot: int, mask: int, *, held: bool = False) -> Job:
        """Open a stream in which the interpreter moves a robot (its number, from 1) for a command source: the blocks arrive one by one,
        and the planner checks each on arrival.  held: hold-to-run.
        """
        job = Job(self._outgoing.number(), source, Code.PROGRAM, mask=mask, quiet=True, held=held, what=f"a stream of robot {robot}")
        state = self.source(source)
        state.last = state.by_code[Code.PROGRAM] = job
        try:
            cell = self.cell
            if cell is None or not cell.generation:
                raise Refusal(Reason.NOT_READY, "the cycle does not run")
            job.span = cell.span(mask)
            self.control.demand(source, job.span)
            self._may_move(cell, self.admission.to_be_enabled(job, cell))
            if cell.override_of(job.mask) <= 0.0:
                raise Refusal(Reason.OVERRIDE_ZERO)
            self._begin(job, ProgramOrder(job.id, 0, 1.0, 1.0, robot))
        except Refusal as refusal:
            self._end(job, CommandState.REFUSED, refusal.reason, refusal.detail)
            return job
        self._open.append(job)
        return job

    def _program(self, job: Job, command: Command, cell: CellState) -> None:
        """Hand the program to the planner, which reads and tries all of it before any motion (AX-322)."""
        number = command.mask
        if number not in self.programs:
            known = ", ".join(f"{n} {program.name}" for n, program in sorted(self.programs.items())) or "none"
            raise Refusal(Reason.PROGRAM_UNKNOWN, f"{number}; this cell has {known}")
        job.mask, job.what = self.programs[number].mask, f"program {number} {self.programs[number].name}"
        job.span = cell.span(job.mask)
        self.control.demand(job.source, job.span)
        self._may_move(cell, self.admission.to_be_enabled(job, cell))
        self.admission.check_rates(command, cell.override_of(job.mask))
        self._begin(job, ProgramOrder(job.id, number, command.velocity, command.acceleration))

    def _begin(self, job: Job, order: ProgramOrder) -> None:
        """The order to the cycle, and to the planner."""
        if self._moves_of(job.span):
            raise Refusal(Reason.BUSY, self._moved_by(job.mask, job.span))
        if self.planner is None:
            raise Refusal(Reason.NOT_READY, "the planner process does not run")
        self._moving(job)
        self._order(Order.PROGRAM, job.id, mask=job.mask, reason=_without_services(job))
        self._outgoing.add_program(order)

    def _may_move(self, cell: CellState, mask: int, *, referenced: bool = True, idle: bool = True) -> None:
        self.admission.check_enabling(cell)
        motion = cell.motion_of(cell.span(mask))
        if idle and motion is not Motion.IDLE:
            stopped = motion is Motion.STOPPED
            raise Refusal(Reason.BUSY, "resume or abandon the stopped move first" if stopped else self._moved_by(mask, cell.span(mask)))
        self.admission.check_travel(cell, mask, referenced=referenced)

    def _order(self, order: Order, job: int = 0, *, mask: int = 0, value: float = 0.0, reason: int = 0, piece: bytes = b"") -> int:
        """The number of its job, a new one where it is of none."""
        generation = self.cell.generation if self.cell is not None else 0
        return self._outgoing.add(order, job, generation, mask=mask, value=value, reason=reason, piece=piece)

    def _done(self, job: Job) -> None:
        job.state = CommandState.DONE
        self._events.append(DispatcherEvent("done", job.source, job.code, Reason.NONE, ""))

    # ---- links -----------------------------------------------------------------------------------------------------------
    def link(self, source: int, on_loss: OnLoss, *, alive: bool) -> None:
        """Record that the command source's link came or went.  Loss of the owner's link ends the move as configured; nothing restarts
        automatically.
        """
        self.control.link(source, alive=alive)
        if alive or not self.owns(source) or self.cell is None:
            return
        own = self.control.axes_of(source)
        moving = self.cell.motion_of(own) in (Motion.RUNNING, Motion.REFERENCING)
        if on_loss is OnLoss.QUICK_STOP:
            self._order(Order.DISABLE, mask=self.admission.every_axis & own, reason=Reason.LINK_LOST)
        elif on_loss in (OnLoss.STOP, OnLoss.HOLD) and moving:
            self._order(Order.STOP, mask=_named(own), reason=Reason.LINK_LOST)
        if moving and on_loss is not OnLoss.FINISH:
            for move in self._moves_of(own):
                move.reason, move.detail = Reason.LINK_LOST, f"command source {source}"
        self._events.append(DispatcherEvent("stopped", source, Code.STOP, Reason.LINK_LOST, f"command source {source}; {on_loss.value}"))

    @property
    def owner(self) -> int:
        """Number of the command source in control, in a cell of several lanes of the first that has one; 0: none."""
        return self.control.owner or NOBODY

    def owns(self, source: int) -> bool:
        """It has control: of the cell, or of some of its kinematics."""
        return self.control.axes_of(source) != 0


def _without_services(job: Job) -> int:
    """What the cycle has to know of it when the services die."""
    return Reason.SERVICES_LOST if job.held else Reason.NONE


def _named(axes: int) -> int:
    """As an order names lanes: 0 is all of them."""
    return 0 if axes == EVERY_AXIS else axes
