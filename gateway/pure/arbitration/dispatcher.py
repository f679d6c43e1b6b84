"""Command dispatcher: validates commands from the command sources, issues orders to the cycle and keeps each command source's
outcome.

Pure: what the cycle publishes (CellState) and time come in, orders and events go out.  Nothing is kept across a restart:
a new dispatcher has no jobs, so a command already present starts nothing (design: a command is taken once).
"""

import functools
import math
import operator
from collections.abc import Callable, Mapping, Sequence

from drivers.drives.tracking import sentence
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.jobs import AxisFacts, DispatcherEvent, Job, OnLoss, SourceState
from gateway.pure.arbitration.overrides import Overrides
from gateway.pure.arbitration.ownership import NOBODY, Ownership
from gateway.pure.cell.web import PAGE_DOOR
from gateway.pure.image.belt_texts import belt_words
from gateway.pure.image.reasons import CommandState, Reason, Refusal
from gateway.pure.image.records.cell import EVERY_AXIS, AxisFlag, CellState, Motion, Order, OrderRecord, Permit
from gateway.pure.image.records.planner import PlannerState, ProgramFacts, ProgramOrder, function_words
from protocols.base.machine import Ns, ms

ENABLE_PATIENCE = ms(5_000)  # brake, power and enabling of six drives take well under 2 s
RESET_PATIENCE = ms(2_000)
TINY, TRAVELS = 1e-6, 10.0  # AX-010: what looks like a number in another format


Planner = Callable[[Sequence[float], Sequence[float], int, float, float, int], bytes]  # start, target (SI), mask, v, a, job -> piece
ABOUT_AXES = (Code.ENABLE, Code.DISABLE, Code.REFERENCE, Code.PTP_ABSOLUTE, Code.PTP_RELATIVE)
NO_PROGRAMS: Mapping[int, ProgramFacts] = {}


class CommandDispatcher:
    """Commands in, orders out."""

    def __init__(
        self, axes: Sequence[AxisFacts], plan: Planner, first_job: int, programs: Mapping[int, ProgramFacts] = NO_PROGRAMS
    ) -> None:
        """`first_job`: a number above every job a predecessor may have used; `programs`: those of the cell, by their numbers."""
        self.axes = tuple(axes)
        self.programs = programs
        self.planner: PlannerState | None = None  # what the planner process says; None: it is not there
        self.control = Ownership()
        self.cell: CellState | None = None
        self.stopped_moves = 0
        self.barred = 0  # axes the interface has disabled
        self.unspoken: dict[int, str] = {}  # axes nothing is ever sent to, and why (AX-436)
        self.overrides = Overrides(len(self.axes))
        self._plan = plan
        self._next = first_job
        self._doors: dict[int, SourceState] = {}
        self._open: list[Job] = []
        self._orders: list[OrderRecord] = []
        self._programs: list[ProgramOrder] = []
        self._events: list[DispatcherEvent] = []
        self._first_try = False
        self._moves: list[Job] = []  # moves and reference runs that axes are on: one at most of each lane

    @property
    def _all(self) -> int:
        """Mask of all axes."""
        return (1 << len(self.axes)) - 1

    def bar(self, mask: int) -> None:
        """These axes are disabled at the interface: off at once whichever source has control, and not moved until a new start (AX-333)."""
        new, self.barred = mask & ~self.barred, mask
        if new & self.enabled_mask():
            self._order(Order.DISABLE, mask=new, reason=Reason.DRIVES_OFF)

    def multiply_override(self, factor: float) -> None:
        """A factor on every override, whichever source has control (AX-1000)."""
        if self.cell is not None:
            for mask, value in self.overrides.multiplied(factor, self.cell):
                self._order(Order.OVERRIDE, mask=0 if mask == self._all else mask, value=value)

    def belt_stood(self, place: int, offset: float) -> None:
        """Offset of a belt's counter to its encoder when last seen; NaN: unknown (AX-480)."""
        self._order(Order.BELT, mask=place, value=offset)

    def open_ready(self) -> None:
        """As an open chain, whichever source has control."""
        self._order(Order.EMERGENCY)

    # ---- what the others ask ---------------------------------------------------------------------------------------------
    def door(self, number: int) -> SourceState:
        """State of one command source; made at the first call."""
        return self._doors.setdefault(number, SourceState())

    def take_orders(self) -> list[OrderRecord]:
        """Orders since the last call, in order."""
        orders, self._orders = self._orders, []
        return orders

    def take_programs(self) -> list[ProgramOrder]:
        """For the planner, since the last call; to be handed over after take_orders()."""
        programs, self._programs = self._programs, []
        return programs

    def take_events(self) -> list[DispatcherEvent]:
        """Events since the last call."""
        events, self._events = self._events, []
        return events

    def enabled_mask(self, flag: AxisFlag = AxisFlag.ENABLED) -> int:
        """Axes (bit n-1 = axis n) with `flag` set."""
        if self.cell is None:
            return 0
        wanted, mask, place = int(flag), 0, 1
        for axis in self.cell.axes[: len(self.axes)]:
            if int(axis.flags) & wanted:  # plain numbers: arithmetic of enum flags costs a microsecond each
                mask |= place
            place <<= 1
        return mask

    # ---- time goes on ----------------------------------------------------------------------------------------------------
    def observe(self, cell: CellState, now: Ns) -> None:
        """Take over what the cycle published and settle the open jobs; generation 0: there is no cycle."""
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
        outcome = self._outcome(job, cell)
        if outcome is not None:
            detail = self._fault(job, cell, outcome)
            self._end(job, self._ended(job, outcome), outcome, detail)
        elif job.until is not None and now >= job.until:
            self._end(job, CommandState.ABORTED, *self._why_not(job, cell))

    @staticmethod
    def _ended(job: Job, outcome: Reason) -> CommandState:
        """A program that failed before anything moved was refused."""
        if outcome is Reason.NONE:
            return CommandState.DONE
        untried = outcome in (Reason.PROGRAM_FAULT, Reason.DRIVE_ON_NOT_AVAILABLE)
        refused = job.code == Code.PROGRAM and job.state is CommandState.ACCEPTED and untried
        return CommandState.REFUSED if refused else CommandState.ABORTED

    def _fault(self, job: Job, cell: CellState, outcome: Reason) -> str:
        """The planner's words: line, block, axis and the manual's number; or which axis did not follow."""
        if outcome is Reason.FOLLOWING_ERROR:
            return self.strayed()
        if outcome in (Reason.BELT_FAULT, Reason.ALTER_FAULT):
            axis = self.axes[cell.belt_axis - 1].name if 0 < cell.belt_axis <= len(self.axes) else ""
            return belt_words(cell.belt_code, cell.belt_block or (self.planner.of(job.watch).block if self.planner else 0), axis)
        if outcome is Reason.SERVO_ERROR:
            return self.axes[cell.belt_axis - 1].name if 0 < cell.belt_axis <= len(self.axes) else ""
        if outcome in (Reason.DRIVE_ON_NOT_AVAILABLE, Reason.DRIVE_ON_NOT_ALLOWED):
            drive_axis = cell.lane_of(job.span).drive_axis
            return f"axis {self.axes[drive_axis - 1].name}" if 0 < drive_axis <= len(self.axes) else ""
        if outcome is Reason.NOT_READY:
            off = ", ".join(axis.name for n, axis in enumerate(self.axes) if (job.mask & ~self.enabled_mask()) >> n & 1)
            return f"drives off: {off}" if off else "its axes move or are being referenced"
        if outcome is Reason.OUTPUT_IN_USE:
            return function_words(cell.lane_of(job.span).path_stop)
        planner = self.planner.of(job.watch) if self.planner is not None else None
        if outcome is not Reason.PROGRAM_FAULT or planner is None or planner.failed_job != job.watch:
            return ""
        return planner.fault

    def strayed(self, language: str = "en") -> str:
        """Axes that did not follow or did not stand, each with the number and words of the old error list; empty: none."""
        found = self.cell.axes if self.cell is not None else []
        told = [(axis.name, found[n].finding) for n, axis in enumerate(self.axes[: len(found)]) if found[n].finding]
        return ", ".join(f"{name} {sentence(number, language)}" for name, number in told)

    def _outcome(self, job: Job, cell: CellState) -> Reason | None:
        """NONE: done; a reason: aborted; None: still open."""
        if cell.taken < job.id:
            return None
        job.also = tuple(other for other in job.also if not cell.done(other))
        failed = cell.failure(job.watch or (job.id if job.code == Code.ENABLE else 0))
        if job.watch:
            done = cell.done(job.watch)
            if job.also and (done or not failed):
                if done:
                    job.watch, job.also = job.also[0], job.also[1:]
                return None
            return Reason.NONE if done else Reason(failed) if failed else None
        if failed:
            return Reason(failed)
        return Reason.NONE if self._reached(job, cell) else None

    def _reached(self, job: Job, cell: CellState) -> bool:
        """Whether what the command asks for stands."""
        enabled = self.enabled_mask() & job.mask
        match job.code:
            case Code.ENABLE:
                return enabled == job.mask
            case Code.DISABLE:
                return not enabled
            case Code.STOP:
                return cell.rests(job.id)
            case Code.ABANDON | Code.REQUEST_CONTROL:
                return cell.motion_of(job.span) is Motion.IDLE
            case Code.FAULT_RESET:
                return not cell.emergency and not self.enabled_mask(AxisFlag.FAULT | AxisFlag.LOST)
            case _:
                return True

    def _why_not(self, job: Job, cell: CellState) -> tuple[Reason, str]:
        if cell.emergency:
            return Reason.EMERGENCY_STOP, ""
        faults = [f"{a.name} fault {cell.axes[n].fault_code}" for n, a in enumerate(self.axes) if cell.axes[n].flags & AxisFlag.FAULT]
        if faults:
            return Reason.DRIVE_FAULT, ", ".join(faults)
        return Reason.TIME_OUT, Code(job.code).name.lower()

    def _end(self, job: Job, state: CommandState, reason: Reason, detail: str = "") -> None:
        job.state, job.reason, job.detail = state, reason, detail or job.detail
        if not (job.quiet and state is CommandState.DONE):
            self._events.append(DispatcherEvent(state.name.lower(), job.door, job.code, reason, job.detail))

    # ---- commands --------------------------------------------------------------------------------------------------------
    def command(self, door: int, command: Command, now: Ns, *, first_try: bool = False) -> Job:
        """Judge one fresh command of a command source; its outcome is in the returned Job (refused at once or open).

        `first_try`: a relative move of a single axis that has not been referenced yet (AX-312); everything else is judged as ever.
        """
        self._first_try = first_try
        job = Job(self._next, door, command.code, mask=command.mask, held=door == PAGE_DOOR and command.code != Code.PROGRAM)
        self._next += 1
        state = self.door(door)
        state.last = state.by_code[command.code] = job
        try:
            if command.code not in Code._value2member_map_:
                raise Refusal(Reason.UNKNOWN_CODE, str(command.code))
            self._judge(job, Code(command.code), command, now)
        except Refusal as refusal:
            self._end(job, CommandState.REFUSED, refusal.reason, refusal.detail)
        if job.open:
            self._open.append(job)
            self._events.append(DispatcherEvent("accepted", door, job.code, Reason.NONE, ""))
        return job

    def refuse(self, door: int, code: Code, reason: Reason, detail: str) -> Job:
        """A command that a command source could not give because of its numbers: the outcome is stored like that of a given one."""
        job = Job(self._next, door, code)
        self._next += 1
        state = self.door(door)
        state.last = state.by_code[code] = job
        self._end(job, CommandState.REFUSED, reason, detail)
        return job

    def _judge(self, job: Job, code: Code, command: Command, now: Ns) -> None:
        cell = self.cell
        if cell is None or not cell.generation:
            raise Refusal(Reason.NOT_READY, "the cycle does not run")
        if code in (*ABOUT_AXES, Code.REQUEST_CONTROL, Code.RELEASE_CONTROL):
            job.span = cell.span(job.mask & self._all)
        at_rest = cell.motion_of(job.span) in (Motion.IDLE, Motion.STOPPED)
        match code:
            case Code.REQUEST_CONTROL:
                self._request(job, cell, at_rest=at_rest)
            case Code.RELEASE_CONTROL:
                own = self.control.axes_of(job.door) & job.span
                self.control.release(job.door, at_rest=cell.motion_of(own) in (Motion.IDLE, Motion.STOPPED), axes=job.span)
                self._done(job)
            case Code.STOP:
                self._stop(job, cell)
            case _:
                self.control.demand(job.door)
                if code not in ABOUT_AXES or not job.mask & self._all:
                    job.span = self.control.axes_of(job.door)  # what names no axes is about those it has
                self.control.demand(job.door, job.span)
                self._owners_command(job, code, command, cell, now)

    def _request(self, job: Job, cell: CellState, *, at_rest: bool) -> None:
        before = self.control.axes_of(job.door)
        if self.control.request(job.door, at_rest=at_rest, axes=job.span):
            self._events.append(DispatcherEvent("control", job.door, job.code, Reason.NONE, ""))
            new = job.span & ~before
            if cell.motion_of(new) is Motion.STOPPED:  # a rest another command source left must not be resumed by this one's first resume
                self._drop_rest(new)
                job.span = new
                job.id = self._orders[-1].job  # done when the rest is gone: the next command must not find the axes busy
                return
        self._done(job)

    def _drop_rest(self, axes: int) -> None:
        self._order(Order.ABANDON, mask=_named(axes))
        for move in self._moves_of(axes):
            self._end(move, CommandState.ABORTED, Reason.ABANDONED)
            self._moves.remove(move)

    def _moved_by(self, mask: int, span: int) -> str:
        """What has the lanes (`span`) of these axes, and which of the axes; "": what moves was not ordered."""
        move = next(iter(self._moves_of(span)), None)
        if move is None:
            return ""
        names = ", ".join(axis.name for n, axis in enumerate(self.axes) if (mask & move.mask or move.mask) >> n & 1)
        what = move.what or Code(move.code).name.lower().replace("_", " ")
        return f"{names}: {what} of command source {move.door} is under way"

    def _moves_of(self, axes: int) -> list[Job]:
        """Moves of the lanes with some of these axes."""
        return [move for move in self._moves if move.span & axes]

    def stop_move(self, move: Job) -> None:
        """Its lanes alone stop on their path: the process it belongs to is gone."""
        self._order(Order.STOP, mask=_named(move.span), reason=Reason.STOPPED_BY_DOOR)
        move.reason, move.detail = Reason.STOPPED_BY_DOOR, str(move.door)

    def abandon_move(self, move: Job) -> None:
        """Its rest is given up."""
        self._drop_rest(move.span)

    # ---- orders to a stream (AX-1080) --------------------------------------------------------------------------------------
    def hold_move(self, move: Job) -> None:
        """Its lanes rest on the path, and what still comes of it waits."""
        self._order(Order.HOLD, mask=_named(move.span), reason=Reason.STOPPED_BY_DOOR)
        move.reason, move.detail = Reason.STOPPED_BY_DOOR, str(move.door)

    def go_on_with(self, move: Job, *, back: bool = False) -> None:
        """What was held goes on, or back along its path; Refusal."""
        cell = self.cell
        if cell is None or not cell.generation:
            raise Refusal(Reason.NOT_READY, "the cycle does not run")
        self.control.demand(move.door, move.span)
        self._may_move(cell, self._in_loop(move), idle=False)
        if cell.override_of(move.span) <= 0.0:
            raise Refusal(Reason.OVERRIDE_ZERO)
        if not back:
            move.reason, move.detail = Reason.NONE, ""
        self._order(Order.RETRACE if back else Order.RESUME, mask=_named(move.span))

    def _stop(self, job: Job, cell: CellState) -> None:
        """Every command source may stop, and stops all that moves."""
        self._order(Order.STOP, job.id, reason=Reason.STOPPED_BY_DOOR)
        for move in self._moves:
            if move.open and cell.motion_of(move.span) is Motion.RUNNING:
                move.reason, move.detail = Reason.STOPPED_BY_DOOR, str(job.door)
                self.stopped_moves += 1

    def _owners_command(self, job: Job, code: Code, command: Command, cell: CellState, now: Ns) -> None:
        match code:
            case Code.ENABLE:
                self._mask(job)
                self._spoken_to(job.mask)
                self._may_enable(cell)
                job.until = now + ENABLE_PATIENCE
                self._order(Order.ENABLE, job.id, mask=job.mask)
            case Code.DISABLE:
                self._mask(job)
                job.until = now + ENABLE_PATIENCE
                self._order(Order.DISABLE, job.id, mask=job.mask)
            case Code.REFERENCE:
                self._mask(job)
                self._may_move(cell, job.mask, referenced=False)
                self._can_be_referenced(job.mask)
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
                self._drop_rest(job.span)
                job.id = self._orders[-1].job
            case Code.FAULT_RESET:
                job.until = now + RESET_PATIENCE
                self._order(Order.RESET, job.id)
            case Code.OVERRIDE:
                if not 0.0 <= command.velocity <= 1.0:
                    raise Refusal(Reason.RATE, f"override {command.velocity:.2%}; 0..100 %")
                self._order(Order.OVERRIDE, job.id, mask=_named(job.span), value=self.overrides.ordered(job.span, command.velocity))

    def _resume(self, job: Job, cell: CellState) -> None:
        """Every move of its lanes that was stopped goes on."""
        moves = self._moves_of(cell.stopped(job.span))
        if not moves:
            raise Refusal(Reason.NOTHING_TO_RESUME)
        for move in moves:
            self._may_move(cell, self._in_loop(move), idle=False)
        for move in moves:
            move.reason, move.detail = Reason.NONE, ""
        job.watch, job.also = moves[0].id, tuple(move.id for move in moves[1:])
        self._order(Order.RESUME, job.id, mask=_named(functools.reduce(operator.or_, (move.span for move in moves))))

    def _moving(self, job: Job) -> None:
        """Its lanes are this job's."""
        job.watch = job.id
        self._moves.append(job)

    def _ptp(self, job: Job, command: Command, cell: CellState, *, relative: bool) -> None:
        self._mask(job)
        if job.mask >> len(command.targets):
            missing = ", ".join(axis.name for n, axis in enumerate(self.axes) if n >= len(command.targets) and job.mask >> n & 1)
            raise Refusal(Reason.MASK, f"{job.mask:04X}h; {len(command.targets)} targets are given, none for {missing}")
        alone = self._first_try and relative and job.mask.bit_count() == 1
        self._may_move(cell, job.mask, referenced=not alone)
        self._rates(command, cell.override_of(job.span))
        start = [axis.set for axis in cell.axes[: len(self.axes)]]
        target = list(start)
        for n, axis in enumerate(self.axes):
            if job.mask >> n & 1:
                self._plausible(axis, command.targets[n], relative=relative)
                wanted = command.targets[n] + (start[n] / axis.si if relative else 0.0)
                if not axis.low <= wanted <= axis.high and not (relative and axis.endless):
                    raise Refusal(Reason.TARGET_LIMIT, f"{axis.name} {wanted:.3f} {axis.unit}; {axis.low:g}..{axis.high:g} {axis.unit}")
                target[n] = wanted * axis.si
        piece = self._plan(start, target, job.mask, command.velocity, command.acceleration, job.id)
        self._moving(job)
        self._order(Order.MOVE, job.id, mask=job.mask, reason=_without_services(job), piece=piece)

    def order_program(self, door: int, number: int, now: Ns, velocity: float = 1.0, acceleration: float = 1.0) -> Job:
        """A command source selects a program of the cell by its number, whichever way it names it."""
        return self.command(door, Command(Code.PROGRAM, number, velocity, acceleration), now)

    def order_stream(self, door: int, robot: int, mask: int, *, held: bool = False) -> Job:
        """The interpreter wants to move a robot (its number, from 1) in the name of a command source: blocks of a language follow one by
        one, the planner judges each as it comes.  held: hold-to-run."""
        job = Job(self._next, door, Code.PROGRAM, mask=mask, quiet=True, held=held, what=f"a stream of robot {robot}")
        self._next += 1
        state = self.door(door)
        state.last = state.by_code[Code.PROGRAM] = job
        try:
            cell = self.cell
            if cell is None or not cell.generation:
                raise Refusal(Reason.NOT_READY, "the cycle does not run")
            job.span = cell.span(mask)
            self.control.demand(door, job.span)
            self._may_move(cell, self._in_loop(job))
            if cell.override_of(job.span) <= 0.0:
                raise Refusal(Reason.OVERRIDE_ZERO)
            self._begin(job, ProgramOrder(job.id, 0, 1.0, 1.0, robot))
        except Refusal as refusal:
            self._end(job, CommandState.REFUSED, refusal.reason, refusal.detail)
            return job
        self._open.append(job)
        return job

    def _program(self, job: Job, command: Command, cell: CellState) -> None:
        """The planner reads and tries it whole before anything moves (AX-322)."""
        number = command.mask
        if number not in self.programs:
            known = ", ".join(f"{n} {program.name}" for n, program in sorted(self.programs.items())) or "none"
            raise Refusal(Reason.PROGRAM_UNKNOWN, f"{number}; this cell has {known}")
        job.mask, job.what = self.programs[number].mask, f"program {number} {self.programs[number].name}"
        job.span = cell.span(job.mask)
        self.control.demand(job.door, job.span)
        self._may_move(cell, self._in_loop(job))
        self._rates(command, cell.override_of(job.span))
        self._begin(job, ProgramOrder(job.id, number, command.velocity, command.acceleration))

    def _begin(self, job: Job, order: ProgramOrder) -> None:
        """The order to the cycle, and to the planner."""
        if self._moves_of(job.span):
            raise Refusal(Reason.BUSY, self._moved_by(job.mask, job.span))
        if self.planner is None:
            raise Refusal(Reason.NOT_READY, "the planner process does not run")
        self._moving(job)
        self._order(Order.PROGRAM, job.id, mask=job.mask, reason=_without_services(job))
        self._programs.append(order)

    def _in_loop(self, job: Job) -> int:
        """Axes of a move that have to be enabled.  A program does without axes that somebody has switched off or disabled, one by one
        (rho 3 L1295-1330): it ends where it would move one of them."""
        off = job.mask & ~self.enabled_mask()
        amiss = self.enabled_mask(AxisFlag.ON | AxisFlag.FAULT | AxisFlag.LOST | AxisFlag.UNCONFIGURED) & ~self.barred
        return job.mask if job.code != Code.PROGRAM or off == job.mask or off & amiss else job.mask & ~off

    def _spoken_to(self, mask: int) -> None:
        for axis, why in self.unspoken.items():
            if mask >> axis & 1:
                raise Refusal(Reason.NOT_READY, why)

    @staticmethod
    def _rates(command: Command, override: float) -> None:
        for name, value in (("velocity", command.velocity), ("acceleration", command.acceleration)):
            if not 0.0 < value <= 1.0:
                raise Refusal(Reason.RATE, f"{name} {value:.2%}; 0.01..100 %")
        if override <= 0.0:
            raise Refusal(Reason.OVERRIDE_ZERO)

    @staticmethod
    def _plausible(axis: AxisFacts, value: float, *, relative: bool) -> None:
        """AX-010: a target that only a number read in the wrong format would have."""
        travel = axis.high - axis.low
        if not math.isfinite(value) or (value != 0.0 and abs(value) < TINY) or abs(value) > TRAVELS * travel:
            kind = "distance" if relative else "target"
            raise Refusal(
                Reason.FORMAT_SUSPICION,
                f"{axis.name} {kind} {value:.3g} {axis.unit} looks like KG read as IEEE (travel {travel:g} {axis.unit})",
            )

    def _mask(self, job: Job) -> None:
        if job.mask == 0 or job.mask & ~self._all:
            raise Refusal(Reason.MASK, f"{job.mask:04X}h; this cell has {len(self.axes)} axes: 0001h..{self._all:04X}h")
        if job.mask & self.barred and job.code != Code.DISABLE:
            names = ", ".join(axis.name for n, axis in enumerate(self.axes) if (job.mask & self.barred) >> n & 1)
            raise Refusal(Reason.DRIVES_OFF, f"{names} disabled at the interface")

    def _can_be_referenced(self, mask: int) -> None:
        """An absolute axis needs no reference run, but a zero."""
        missing = mask & ~self.enabled_mask(AxisFlag.REFERENCED)
        names = ", ".join(axis.name for n, axis in enumerate(self.axes) if missing >> n & 1 and axis.absolute)
        if names:
            raise Refusal(
                Reason.NOT_REFERENCED, f'{names}: home.by = "none" and no zero is known; set it: axisgate axis zero CELL AXIS --at POSITION'
            )

    @staticmethod
    def _may_enable(cell: CellState) -> None:
        if cell.emergency or not cell.permits & Permit.CHAIN:
            raise Refusal(Reason.EMERGENCY_STOP)
        if not cell.permits & Permit.CONTROL:
            raise Refusal(Reason.CONTROL_NOT_ALLOWED)

    def _may_move(self, cell: CellState, mask: int, *, referenced: bool = True, idle: bool = True) -> None:
        self._may_enable(cell)
        motion = cell.motion_of(cell.span(mask))
        if idle and motion is not Motion.IDLE:
            stopped = motion is Motion.STOPPED
            raise Refusal(Reason.BUSY, "resume or abandon the stopped move first" if stopped else self._moved_by(mask, cell.span(mask)))
        if not cell.permits & Permit.FEED:
            raise Refusal(Reason.FEED_NOT_ALLOWED)
        if not cell.permits & Permit.TRAVEL:
            raise Refusal(Reason.TRAVEL_NOT_ALLOWED)
        for flag, reason in ((AxisFlag.ENABLED, Reason.DRIVES_OFF), (AxisFlag.REFERENCED, Reason.NOT_REFERENCED)):
            missing = mask & ~self.enabled_mask(flag)
            if missing and (flag is AxisFlag.ENABLED or referenced):
                raise Refusal(reason, ", ".join(axis.name for n, axis in enumerate(self.axes) if missing >> n & 1))

    def _order(self, order: Order, job: int = 0, *, mask: int = 0, value: float = 0.0, reason: int = 0, piece: bytes = b"") -> None:
        if not job:
            job, self._next = self._next, self._next + 1
        generation = self.cell.generation if self.cell is not None else 0
        self._orders.append(OrderRecord(order, job, generation, mask, value, reason, piece))

    def _done(self, job: Job) -> None:
        job.state = CommandState.DONE
        self._events.append(DispatcherEvent("done", job.door, job.code, Reason.NONE, ""))

    # ---- links -----------------------------------------------------------------------------------------------------------
    def link(self, door: int, on_loss: OnLoss, *, alive: bool) -> None:
        """The command source's link came or went; when the owner's went, the move ends as configured and nothing restarts by itself."""
        self.control.link(door, alive=alive)
        if alive or not self.owns(door) or self.cell is None:
            return
        own = self.control.axes_of(door)
        moving = self.cell.motion_of(own) in (Motion.RUNNING, Motion.REFERENCING)
        if on_loss is OnLoss.QUICK_STOP:
            self._order(Order.DISABLE, mask=self._all & own, reason=Reason.LINK_LOST)
        elif on_loss in (OnLoss.STOP, OnLoss.HOLD) and moving:
            self._order(Order.STOP, mask=_named(own), reason=Reason.LINK_LOST)
        if moving and on_loss is not OnLoss.FINISH:
            for move in self._moves_of(own):
                move.reason, move.detail = Reason.LINK_LOST, f"command source {door}"
        self._events.append(DispatcherEvent("stopped", door, Code.STOP, Reason.LINK_LOST, f"command source {door}; {on_loss.value}"))

    @property
    def owner(self) -> int:
        """Number of the command source in control, in a cell of several lanes of the first that has one; 0: none."""
        return self.control.owner or NOBODY

    def owns(self, door: int) -> bool:
        """It has control: of the cell, or of some of its kinematics."""
        return self.control.axes_of(door) != 0


def _without_services(job: Job) -> int:
    """What the cycle has to know of it when the services die."""
    return Reason.SERVICES_LOST if job.held else Reason.NONE


def _named(axes: int) -> int:
    """As an order names lanes: 0 is all of them."""
    return 0 if axes == EVERY_AXIS else axes
