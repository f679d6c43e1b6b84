"""The brain of the cycle: once per SYNC, actual values and orders in, set values and the published state out.  Pure.

It owns the drives' power machines, the stepper, referencing, the enabling inputs and the emergency-stop latch; it decides nothing the
doors should decide.  A new core starts with drives off, override 0, nothing referenced and no rest of a move (design: section 4).
"""

from collections.abc import Sequence

from drivers.drives.family import Actual, Demand, DriveHoming, Event, Homing, Power, SetRecord
from drivers.drives.referencing import Referencing, RunState
from drivers.drives.tracking import Tracking
from gateway.pure.beltrecords import belt_block_of, synchron_of
from gateway.pure.coreaxis import CoreAxis, HeldAxis
from gateway.pure.corebelts import BeltFault, CoreBelts
from gateway.pure.coreprogram import ProgramRun
from gateway.pure.corepublish import Publisher
from gateway.pure.permits import AS_SHIPPED, EVERY, NO_PERMIT, EnablingInputs, RcNumbers
from gateway.pure.plannerrecords import Part, PieceRecord, switch_of, until_of
from gateway.pure.reasons import Reason
from gateway.pure.records import (
    RC_BYTES,
    CellState,
    InputImage,
    Motion,
    Order,
    OrderRecord,
    Permit,
    set_bit,
)
from motion.errors import MotionError
from motion.pieces import decode
from motion.stepper import Sample, State, Stepper
from motion.timed import decode_any
from protocols.base.machine import Ns, ms

ARRIVAL_S = 2.0  # after the set values: an axis that is not in its window by then has not arrived
SETTLE_S = 0.5  # after its last set value an axis has so long to come to its place; then it stands (AX-268)
LOST_STOP_S = 2.0  # an axis still moving so long after its chain or control input was lost is switched off
CHAIN, CONTROL, FEED, RUN, TRAVEL = (int(permit) for permit in Permit)
FLOW = FEED | RUN
MOTIONS = {
    State.IDLE: Motion.IDLE,
    State.RUNNING: Motion.RUNNING,
    State.STOPPING: Motion.STOPPING,
    State.STOPPED: Motion.STOPPED,
}
BROKEN = ((Power.FAULT, Reason.DRIVE_FAULT), (Power.LOST, Reason.DRIVE_LOST))
TOO_MANY_SKIPPED = 3  # SYNCs skipped in a row: stop on the path
_new = tuple.__new__  # of a record without counting its fields again: once an axis and cycle
SERVICES_LIMIT = ms(250)  # life counter of services older than this: dead


class Core:
    """One cell's axes."""

    def __init__(
        self,
        axes: Sequence[CoreAxis],
        period_s: float,
        generation: int,
        *,
        numbers: RcNumbers = AS_SHIPPED,
        assumed: Permit = NO_PERMIT,
        finish_without_services: bool = False,
        belts: CoreBelts | None = None,
    ) -> None:
        self.state = CellState(generation=generation)
        self.outputs = bytearray(RC_BYTES)
        self._period = period_s
        self.plans = tuple(axes)
        self._axes = [HeldAxis(plan, plan.drive.make(), self._tracking(plan), plan.scaling) for plan in axes]
        for axis in self._axes:
            axis.referenced = axis.plan.absolute
        self._stepper = Stepper(len(axes), period_s)
        self._stepper.set_override(0.0)
        self._publisher = Publisher(self.state, self.outputs, numbers, period_s)
        self._finish = finish_without_services
        self._enabling_inputs = EnablingInputs(numbers, assumed)
        self._inputs = InputImage()
        self._permits = 0
        self._override = 0.0
        self._job_masks: dict[int, int] = {}
        self._running = 0  # job of the piece under way
        self.belts = belts
        self._program = ProgramRun()  # done when nothing more comes and all is run
        self._arriving = 0  # cycles since the set values of the running job arrived
        self._homing = 0  # job of the reference run
        self._referencing = False  # it is under way, or an axis still comes to rest from it
        self._enabling: tuple[int, int] = (0, 0)  # job, mask
        self._reset = False
        self._services_alive = False
        self._settled = False
        self._settled_axes = False  # every drive follows, and none lost its increments
        self._eventful = False  # a drive did something by itself in this cycle
        self._lost_cycles = 0  # since chain or control was lost

    def _tracking(self, plan: CoreAxis) -> Tracking:
        return Tracking(plan.standing, plan.lag_warn, plan.lag_trip, round(SETTLE_S / self._period))

    # ---- one cycle ---------------------------------------------------------------------------------------------------
    def idle(self) -> list[SetRecord]:
        """Set values before the first SYNC."""
        return [axis.drive.idle() for axis in self._axes]

    def step(
        self, actuals: Sequence[Actual | None], inputs: InputImage, orders: Sequence[OrderRecord], services_ns: Ns, now: Ns
    ) -> list[SetRecord]:
        """actuals: (axes,) of this SYNC, None where the telegram did not come; services_ns: stamp of the services' last beat."""
        self.state.cycle += 1
        self.state.sync_ns = now
        self._inputs = inputs
        self._judge_inputs(inputs, services_ns, now)
        self._judge_services(services_ns, now)
        for order in orders:
            self._obey(order)
        values = self._drive(actuals)
        self._watch(actuals)
        self._publish()
        return values

    # ---- inputs ------------------------------------------------------------------------------------------------------
    def _judge_inputs(self, inputs: InputImage, services_ns: Ns, now: Ns) -> None:
        view = self._enabling_inputs.judge(inputs, services_ns, now)
        if view.permits != self._permits:
            self._permits, self.state.permits = view.permits, EVERY[view.permits]
        if view.taken & CHAIN and self._settled:
            self._emergency()
        if view.taken & CONTROL:
            self._off(Reason.CONTROL_NOT_ALLOWED)
        self._judge_lost(view.just_lost, view.lost)
        if view.taken & TRAVEL:
            self._stop(Reason.TRAVEL_NOT_ALLOWED)
        if view.permits & CHAIN:
            self._settled = True  # before the chain was seen closed once there is nothing to latch
        self._reset = view.reset
        if self._reset:
            self._acknowledge()
        self._apply_override()

    def _judge_lost(self, just_lost: int, lost: int) -> None:
        """Inputs that are lost, not taken away: stop on the path, and without chain or control off at rest (AX-143)."""
        if just_lost:
            self._stop(Reason.INPUT_LOST)
        if not lost & (CHAIN | CONTROL):
            self._lost_cycles = 0
            return
        self._lost_cycles += 1
        moving = self._homing or self._stepper.state in (State.RUNNING, State.STOPPING)
        if not moving or self._lost_cycles * self._period > LOST_STOP_S:
            self._off(Reason.INPUT_LOST)

    def _judge_services(self, services_ns: Ns, now: Ns) -> None:
        alive = services_ns != 0 and now - services_ns < SERVICES_LIMIT
        if not alive:
            self.services_lost()
        self._services_alive = alive

    def services_lost(self) -> None:
        """They are silent, or a successor is there already: it knows nothing of the move that runs, so the move ends as configured."""
        if not self._services_alive:
            return  # noticed before
        self._services_alive = False
        self.state.services_lost += 1
        if not self._finish:
            self._stop(Reason.SERVICES_LOST)

    def _apply_override(self) -> None:
        """Feed hold and a missing feed allow hold on the path; the move goes on when they are back (as the old feed hold)."""
        value = self._override if self._permits & FLOW == FLOW else 0.0
        if self.belts is not None and self.belts.set_override(value):
            return
        if value != self._stepper.override:
            self._stepper.set_override(value)

    def _emergency(self) -> None:
        if not self.state.emergency:
            self.state.emergency = True
            self.state.stop_cause = Reason.EMERGENCY_STOP
        self._off(Reason.EMERGENCY_STOP)

    def _acknowledge(self) -> None:
        if self.state.permits & Permit.CHAIN:
            self.state.emergency = False
        self.state.stop_cause = 0
        self._reset = True
        for axis in self._axes:
            axis.finding = 0

    # ---- orders ------------------------------------------------------------------------------------------------------
    def _obey(self, record: OrderRecord) -> None:
        state = self.state
        state.taken = max(state.taken, record.job)
        match record.order:
            case Order.ENABLE:
                self._enable(record)
            case Order.DISABLE:
                self._off(Reason(record.reason) if record.reason else Reason.DRIVES_OFF, record.mask)
            case Order.REFERENCE:
                self._reference(record)
            case Order.MOVE:
                self._move(record)
            case Order.STOP:
                self._stop(Reason(record.reason))
            case Order.RESUME:
                state.stop_cause = 0
                self._stepper.resume()
            case Order.ABANDON:
                if self._on_belt:
                    self._leave_belt(Reason.ABANDONED)
                elif self._stepper.state is not State.IDLE:
                    self._stepper.abandon()
                    self._fail(self._running, Reason.ABANDONED)
                    self._running = 0
                    self._program.clear()
            case Order.PROGRAM:
                self._order_program(record)
            case Order.RESET:
                self._acknowledge()
            case Order.OVERRIDE:
                self._override = min(max(record.value, 0.0), 1.0)
                self._apply_override()

    def _enable(self, record: OrderRecord) -> None:
        state = self.state
        if state.emergency or not state.permits & Permit.CHAIN:
            self._fail(record.job, Reason.EMERGENCY_STOP)
        elif not state.permits & Permit.CONTROL:
            self._fail(record.job, Reason.CONTROL_NOT_ALLOWED)
        else:
            state.stop_cause = 0
            for n, axis in enumerate(self._axes):
                if record.mask >> n & 1:
                    axis.wanted, axis.finding = True, 0
            self._enabling = (record.job, record.mask)

    def _reference(self, record: OrderRecord) -> None:
        if self._stepper.state is not State.IDLE or self._homing or not self._all_enabled(record.mask):
            self._fail(record.job, Reason.BUSY if self._homing or self._stepper.state is not State.IDLE else Reason.DRIVES_OFF)
            return
        for n, axis in enumerate(self._axes):
            plan = axis.plan.reference
            if record.mask >> n & 1 and plan is not None:
                axis.referenced = False
                if isinstance(plan, DriveHoming):
                    axis.by_drive = True
                else:
                    axis.run = Referencing(plan, axis.drive.position_inc)
        self._homing, self._referencing = record.job, True

    def _move(self, record: OrderRecord) -> None:
        try:
            piece = decode(record.piece)
            if self._homing or self._program.job or self.state.emergency or not self._all_enabled(piece.mask):
                raise MotionError("the axes of the piece are not all enabled, or they are being referenced")
            self._stepper.load(piece)
        except MotionError:
            self._fail(record.job, Reason.NOT_READY)
            return
        self._running, self._arriving = record.job, 0
        self.state.stop_cause = 0

    def _order_program(self, record: OrderRecord) -> None:
        busy = self._homing or self._running or self._program.job or self._stepper.state is not State.IDLE
        if busy or self.state.emergency or not self._all_enabled(record.mask):
            self._fail(record.job, Reason.NOT_READY)
            return
        self._program.order(record.job)
        self.state.stop_cause = 0

    def feed(self, record: PieceRecord) -> None:
        """From the planner: the next piece of the program, or the mark that nothing follows.  What belongs to another job is dropped."""
        program = self._program
        if record.generation != self.state.generation or record.job != program.job:
            return
        if record.part is Part.FAULT:
            self._end_program(Reason.PROGRAM_FAULT)
        elif record.part is Part.UNTIL:
            program.until = until_of(record)
        elif record.part is Part.REST:
            program.rests = True
        elif record.part in (Part.SYNCHRON, Part.BELT_BLOCK):
            self._take_belt(record)
        elif record.part is Part.OUTPUT:
            program.switch(switch_of(record))
        elif record.part is Part.LAST:
            program.complete = True
            if not program.begun:
                self.state.done_job = program.job
                program.clear()
        else:
            self._take_piece(record.piece)

    def _take_piece(self, data: bytes) -> None:
        program = self._program
        if self._stepper.state is State.IDLE and program.sees(self._inputs):
            program.met = True  # it stands already: there is no movement (rho3 4.3)
        if program.met:
            return
        try:
            piece = decode_any(data)
            if self._homing or self.state.emergency or self._running not in (0, program.job) or not self._all_enabled(piece.mask):
                raise MotionError("the axes of the piece are not all enabled and free")
            if self.belts is None or not self.belts.load(piece):
                self._stepper.load(piece)
        except MotionError:
            self._fail(program.job, Reason.NOT_READY)
            if program.begun:
                self._stepper.abandon()
                self._running = 0
            program.clear()
            return
        if not program.begun:
            self._running, self._arriving, program.begun = program.job, 0, True

    def planner_lost(self) -> None:
        """What was committed runs to its end, which is at rest on the path; the program is over."""
        if self._program.waits:
            self._end_program(Reason.PLANNER_LOST)
            self.state.stop_cause = Reason.PLANNER_LOST

    @property
    def starved(self) -> bool:
        """A program is under way, the axes rest, and more has to come from the planner."""
        return self._program.waits and self._stepper.state is State.IDLE

    def _end_program(self, reason: Reason) -> None:
        """It failed; what was committed of it is run."""
        self._fail(self._program.job, reason)
        self._program.switches.clear()
        if self._program.begun:
            self._program.complete = True
        else:
            self._program.clear()

    def _stop(self, reason: Reason) -> None:
        if self._on_belt:
            self._leave_belt(reason)
        elif self._stepper.state is State.RUNNING:
            self._stepper.stop()
            self.state.stop_cause = reason
        elif self.starved:  # nothing to stop on: it must not begin, or go on, by itself afterwards
            self._fail(self._program.job, reason)
            self._running, self.state.stop_cause = 0, reason
            self._program.clear()
        if self._homing:
            self._end_homing(reason)
            self.state.stop_cause = reason

    def _off(self, reason: Reason, mask: int = 0xFFFF) -> None:
        """Drives off: the drive's own quick stop brings the axis to rest; the rest of a move is gone."""
        moved = [axis for n, axis in enumerate(self._axes) if mask >> n & 1 and axis.wanted]
        for axis in moved:
            axis.wanted = False
        if not moved:
            return
        if reason is not Reason.DRIVES_OFF:
            self.state.stop_cause = reason  # also at rest: whoever finds the drives off reads why
        if self._homing:
            self._end_homing(reason)
        for axis in moved:
            axis.run, axis.by_drive = None, False
        if self._running or self._program.job or self._stepper.state is not State.IDLE:
            self._fail(self._running or self._program.job, reason)
            self._running = 0
            self._program.clear()
            if self.belts is not None:
                self.belts.drop()
            self._stepper = Stepper(len(self._axes), self._period, [axis.set for axis in self._axes])
            self._stepper.set_override(0.0)
            self._apply_override()
        if self._enabling[0]:
            self._fail(self._enabling[0], reason)
            self._enabling = (0, 0)

    def _fail(self, job: int, reason: Reason) -> None:
        if job:
            self.state.failed_job, self.state.failed_reason = job, int(reason)

    def _end_homing(self, reason: Reason) -> None:
        self._fail(self._homing, reason)
        self._homing = 0
        for axis in self._axes:
            axis.by_drive = False
            if axis.run is not None:
                axis.run.abort()

    def _all_enabled(self, mask: int) -> bool:
        return all(axis.drive.follows for n, axis in enumerate(self._axes) if mask >> n & 1)

    # ---- set values --------------------------------------------------------------------------------------------------
    def _drive(self, actuals: Sequence[Actual | None]) -> list[SetRecord]:
        """One pass over the axes: all of it happens once per SYNC and axis."""
        sample = self._stepper.step() if self.belts is None else self._belt_step(self.belts)
        if self._program.job:
            self._attend(sample)
        if self._referencing:
            self._step_runs(actuals)
        values: list[SetRecord] = []
        reset, settled, self._eventful = self._reset, True, False
        for axis, actual, q, speed in zip(self._axes, actuals, sample.q, sample.qd, strict=True):
            drive, scaling = axis.drive, axis.scaling
            axis.active_inc, axis.received_inc, axis.sent_inc = axis.received_inc, axis.sent_inc, drive.set_inc
            if axis.led:
                axis.led = False
            elif drive.follows and not axis.by_drive:
                axis.set, axis.speed = q, speed
            else:
                axis.speed = 0.0
            inc = round(scaling.zero_inc + axis.set * scaling.sent_per_unit)  # as to_inc and to_rpm: a call costs as much as the sum
            limit_switch = axis.referenced and axis.limited
            demand = (axis.wanted, reset, inc, axis.speed * scaling.rpm_per_unit, limit_switch, axis.by_drive)
            values.append(drive.step(actual, _new(Demand, demand)))
            power = drive.power
            if power is not axis.power:
                axis.power, axis.power_number = power, power.value
            if not drive.follows or drive.epoch != axis.epoch:
                settled = False
            if drive.events:
                self._eventful = True
            axis.behind = (axis.active_inc - drive.position_inc) / scaling.inc_per_unit
        self._settled_axes = settled
        if self._referencing:
            self._judge_runs()
        if self._referencing or not settled:
            self._accept_positions()
        if self._running and (self._program_over() if self._program.begun else sample.done_id == self._running):
            self._arrive()
        self.state.progress, self.state.piece = sample.s, sample.piece_id
        return values

    # ---- belts -------------------------------------------------------------------------------------------------------
    @property
    def _on_belt(self) -> bool:
        """A synchronous part is under way."""
        return self.belts is not None and not self.belts.free

    def _take_belt(self, record: PieceRecord) -> None:
        """SYNCHRON, or a block of types 2 and 3; what does not fit ends the program before it moves."""
        program, belts = self._program, self.belts
        try:
            every = (1 << len(self._axes)) - 1
            if belts is None or self._homing or self.state.emergency or not self._all_enabled(every):
                raise MotionError("the axes are not all enabled and free")
            if record.part is Part.BELT_BLOCK:
                belts.add(belt_block_of(record))
                return
            belts.synchron(synchron_of(record), [axis.set for axis in self._axes])
            belts.set_override(self._stepper.override)
        except MotionError:
            self._fail(program.job, Reason.NOT_READY)
            self._end_program(Reason.NOT_READY)
            return
        self._running, self._arriving, program.begun = program.job, 0, True

    def _belt_step(self, belts: CoreBelts) -> Sample:
        """Counters, and the set values of the part under way."""
        sample, state = belts.step(self._stepper, self._inputs), self.state
        state.belt, state.belt_speed = belts.shown.counter, belts.shown.watch.speed
        if belts.engaged_now:
            state.engaged = belts.value
            state.parts += 1
        if belts.fault is not None:
            self._belt_fault(belts, belts.fault)
        elif not belts.free and self._end_belt(belts):
            self._stepper.place(sample.q)  # the part is over: from here on the axes are the stepper's again
        return sample

    def _end_belt(self, belts: CoreBelts) -> bool:
        """Nothing more comes of the part: a robot of type 1 leaves its belt, one of types 2 and 3 stands at its last point.  True: over."""
        program = self._program
        if not (program.rests or program.complete or not program.job):
            return False
        if belts.carries:
            over = self._stepper.state is State.IDLE and belts.release()
        else:
            over = belts.done or (not belts.running and (program.complete or not program.job))
        if over:
            belts.drop()
        return over

    def _leave_belt(self, reason: Reason) -> None:
        """Stopped inside a part: it is over, and the axes come to rest whatever the belt does."""
        belts, program = self.belts, self._program
        assert belts is not None
        if program.job and program.job != self.state.failed_job:
            self._end_program(reason)
            program.met = True  # what still comes of it is dropped
            self.state.stop_cause = reason
        fault = belts.stop()
        if fault is not None:
            self._belt_fault(belts, fault)
        elif not belts.carries:
            belts.drop()
        elif self._stepper.state is not State.IDLE:
            self._stepper.abandon()

    def _belt_fault(self, belts: CoreBelts, fault: BeltFault) -> None:
        """The part cannot go on; with types 2 and 3 READY opens, so that the belt can be stopped (rho3 L6112)."""
        state, belts.fault = self.state, None
        state.belt_code, state.belt_block, state.belt_axis = fault.code, belts.block, fault.axis
        if fault.opens_ready:
            state.emergency = True
            self._off(Reason.BELT_FAULT)
        else:
            self._leave_belt(Reason.BELT_FAULT)

    def _attend(self, sample: Sample) -> None:
        """What belongs to a program beside its path: outputs, the input its part ends with, the end of a part."""
        program, stepper = self._program, self._stepper
        for switch in program.passed(sample.piece_id, stepper.within):
            set_bit(self.outputs, switch.number, switch.value)
        if stepper.state is State.RUNNING and program.sees(self._inputs):
            stepper.abandon()
            program.met = True
        if program.rests and stepper.state is State.IDLE and not self._on_belt:
            program.part_over()
            self.state.parts += 1

    def _program_over(self) -> bool:
        return self._program.complete and self._stepper.state is State.IDLE and not self._on_belt

    def _arrive(self) -> None:
        """The set values have arrived; the move has when the axes have, too."""
        late = [axis for axis in self._axes if abs(axis.set - axis.scaling.to_si(axis.drive.position_inc)) > axis.plan.window]
        self._arriving += 1
        if not late:
            if self._running != self.state.failed_job:
                self.state.done_job = self._running
            self._over()
        elif self._arriving * self._period > ARRIVAL_S:
            self._fail(self._running, Reason.FOLLOWING_ERROR)
            self._over()

    def _over(self) -> None:
        self._running, self._arriving = 0, 0
        if self._program.begun:
            self._program.clear()

    def _step_runs(self, actuals: Sequence[Actual | None]) -> None:
        for axis, actual in zip(self._axes, actuals, strict=True):
            if axis.run is not None:
                axis.led = True
                self._step_homing(axis, actual)

    def _judge_runs(self) -> None:
        for axis in self._axes:
            if axis.by_drive:
                self._judge_drive_homing(axis)

    def _judge_drive_homing(self, axis: HeldAxis) -> None:
        """The drive stands in its home position: from now on its increments mean what the plan says (AX-306)."""
        plan, state = axis.plan.reference, axis.drive.homing
        if state is Homing.DONE and isinstance(plan, DriveHoming):
            axis.by_drive, axis.referenced = False, True
            axis.scaling = axis.plan.scaling.with_zero(-plan.position * axis.plan.scaling.inc_per_unit)
            axis.set = axis.scaling.to_si(axis.drive.set_inc)
        elif state is Homing.FAILED:
            self.state.stop_cause = Reason.REFERENCE_FAILED
            self._end_homing(Reason.REFERENCE_FAILED)
        self._homing_ended()

    def _homing_ended(self) -> None:
        if self._homing and not any(axis.run is not None or axis.by_drive for axis in self._axes):
            self.state.done_job, self._homing = self._homing, 0

    def _step_homing(self, axis: HeldAxis, actual: Actual | None) -> None:
        run = axis.run
        assert run is not None
        step = run.step(axis.drive.position_inc, actual is not None and actual.reference_switch, self._period)
        axis.set = axis.scaling.to_si(step.set_inc)
        axis.speed = axis.scaling.speed_from_inc(step.speed_inc_s)
        if step.state is RunState.RUNNING:
            return
        axis.run = None
        if step.state is RunState.DONE:
            assert run.zero_inc is not None
            axis.scaling = axis.plan.scaling.with_zero(run.zero_inc)
            axis.set = axis.scaling.to_si(step.set_inc)
            axis.referenced = True
        elif self._homing:
            self.state.stop_cause = Reason.REFERENCE_FAILED
            self._end_homing(Reason.REFERENCE_FAILED)
        self._homing_ended()

    def _accept_positions(self) -> None:
        """Where no set value of ours leads, the set position is the one the drive object holds, so enabling never jumps."""
        for axis in self._axes:
            if axis.drive.epoch != axis.epoch:
                axis.epoch, axis.run, axis.by_drive = axis.drive.epoch, None, False
                axis.referenced = axis.plan.absolute
            if axis.run is None and (axis.by_drive or not axis.drive.follows):
                axis.set = axis.scaling.to_si(axis.drive.set_inc)
        if self._stepper.state is State.IDLE and not self._on_belt:
            self._stepper.place([axis.set for axis in self._axes])

    # ---- supervision -------------------------------------------------------------------------------------------------
    def _watch(self, actuals: Sequence[Actual | None]) -> None:
        self._reset = False
        for axis, actual in zip(self._axes, actuals, strict=True):
            gap, axis.gap = axis.gap, actual is None
            if gap or actual is None or axis.by_drive or not axis.drive.follows:  # a drive that references leads its position itself
                axis.tracking.clear()  # after a gap: the first answer may be the one that was missing, one cycle old (AX-560)
            elif number := axis.tracking.check(axis.active_inc, axis.behind):
                axis.finding = number
                self.state.stop_cause = Reason.FOLLOWING_ERROR
                self._off(Reason.FOLLOWING_ERROR)
        if not self._settled_axes:
            self._judge_powers()
        if self._eventful:
            self._judge_events()
        job, mask = self._enabling
        if job and self._all_enabled(mask):
            self._enabling = (0, 0)

    def _judge_powers(self) -> None:
        powers = [axis.power for axis in self._axes if axis.wanted]
        for power, reason in BROKEN:
            if power in powers:
                self.state.stop_cause = reason
                self._off(reason)  # the axes move together or not at all

    def _judge_events(self) -> None:
        """What drives did by themselves; of an axis nobody wants on it is no matter."""
        if any(axis.wanted and (Event.DROPPED in axis.drive.events or Event.TIMEOUT in axis.drive.events) for axis in self._axes):
            self.state.stop_cause = Reason.DRIVE_FAULT
            self._off(Reason.DRIVE_FAULT)  # a drive that left control by itself: only a fresh command brings it back
        if any(axis.wanted and (Event.JUMP in axis.drive.events or Event.RANGE in axis.drive.events) for axis in self._axes):
            self.state.stop_cause = Reason.SET_VALUE
            self._off(Reason.SET_VALUE)  # a set value the drive object would not send: the axis no longer follows its path

    def skipped(self, in_a_row: int) -> None:
        """SYNCs were not sent: the path is late by as much, and too many in a row stop it."""
        self.state.skipped += in_a_row
        if in_a_row >= TOO_MANY_SKIPPED:
            self._stop(Reason.OVERRUN)

    def drives_lost(self) -> None:
        """The bus is gone: everything off, and only a fresh command brings it back."""
        self.state.stop_cause = Reason.DRIVE_LOST
        self._off(Reason.DRIVE_LOST)

    # ---- what others see ---------------------------------------------------------------------------------------------
    def _publish(self) -> None:
        state, stepper = self.state, self._stepper.state
        if self._referencing:
            self._referencing = self._homing != 0 or any(axis.run is not None or axis.by_drive for axis in self._axes)
        motion = Motion.REFERENCING if self._referencing else MOTIONS[stepper]
        if motion is Motion.IDLE and (self._running or self._program.job):
            motion = Motion.RUNNING  # the axes are still on their last increments, or a program is being prepared
        state.motion = motion
        state.override = self._override
        state.job = self._homing or self._running
        self._publisher.publish(self._axes)
