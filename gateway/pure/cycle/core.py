"""The brain of the cycle: once per SYNC, actual values and orders in, set values and the published state out.  Pure.

It owns the drives' power machines, the mover (paths and programs), referencing, the enabling inputs and the emergency-stop latch; it
decides nothing the command sources should decide.  A new core starts with drives off, override 0, nothing referenced and no rest of a move
(design: section 4).
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from drivers.drives.family import Actual, Event, Power, SetRecord
from drivers.drives.tracking import Tracking
from gateway.pure.cycle.alter import CoreAlter
from gateway.pure.cycle.alter_mover import make_mover
from gateway.pure.cycle.axis import CoreAxis, HeldAxis
from gateway.pure.cycle.axis_loops import PYTHON, AxisLoops
from gateway.pure.cycle.belts import CoreBelts
from gateway.pure.cycle.enabling_inputs import AS_SHIPPED, EVERY, NO_PERMIT, EnablingInputs, RcNumbers
from gateway.pure.cycle.endless import CoreEndless
from gateway.pure.cycle.homing import Homings
from gateway.pure.cycle.publish import Publisher
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import MOST_AXES, RC_BYTES, AxisState, CellState, InputImage, Motion, Order, OrderRecord, Permit
from gateway.pure.image.records.planner import PieceRecord
from motion.execution.stepper import State
from motion.timing.foresight import Foresight
from motion.timing.override_ramp import OverrideRamp
from protocols.base.machine import Ns, ms

if TYPE_CHECKING:
    from gateway.pure.cycle.path_outputs import CoreOutputs
    from gateway.pure.cycle.shared_output import CoreShared

EVERY_AXIS = (1 << MOST_AXES) - 1
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
SERVICES_LIMIT = ms(250)  # life counter of services older than this: dead


class CycleLogic:
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
        functions: "CoreOutputs | None" = None,
        alter: CoreAlter | None = None,
        shared: "CoreShared | None" = None,
        override_step: float = 1.0,
        loops: AxisLoops = PYTHON,
        foresight: type[Foresight] = Foresight,
    ) -> None:
        self.state = CellState(generation=generation, axes=[AxisState() for _ in axes])
        self.outputs = bytearray(RC_BYTES)
        self._period = period_s
        self.plans = tuple(axes)
        self._axes = [HeldAxis(plan, plan.drive.make(), self._tracking(plan), plan.scaling) for plan in axes]
        for axis in self._axes:
            axis.referenced = axis.plan.absolute
        self._endless = CoreEndless(self._axes, self.state)
        self._homings = Homings(self._axes, self.state, period_s)
        self.belts, self._shared = belts, shared
        self._mover = make_mover(
            self._axes, self.state, self.outputs, self._homings, period_s, foresight, belts=belts, alter=alter, off=self._off
        )
        self._mover.functions = functions
        self._drive_axes, self._watch_axes = loops.drive_axes, loops.watch_axes
        self._publisher = Publisher(self.state, self.outputs, numbers, period_s, loops)
        self._finish = finish_without_services
        self._enabling_inputs = EnablingInputs(numbers, assumed)
        self._permits = 0
        self._override = 0.0  # as ordered
        self._ramp = OverrideRamp(override_step)
        self._enabling: list[tuple[int, int]] = []  # job, mask, of each that waits for its axes
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
        self._judge_inputs(inputs, services_ns, now)
        self._judge_services(services_ns, now)
        for order in orders:
            self._obey(order)
        self._apply_override()
        values = self._drive(actuals, inputs)
        self._watch(actuals)
        if self._endless.axes and not (self._mover.busy or self._homings.under_way):
            self._go_round()
        self._publish()
        if self._shared is not None:
            self._share(self._shared)
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

    def _judge_lost(self, just_lost: int, lost: int) -> None:
        """Inputs that are lost, not taken away: stop on the path, and without chain or control off at rest (AX-143)."""
        if just_lost:
            self._stop(Reason.INPUT_LOST)
        if not lost & (CHAIN | CONTROL):
            self._lost_cycles = 0
            return
        self._lost_cycles += 1
        moving = self._homings.job or self._mover.moving
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
        ordered = self._ramp.step(self._override)
        value = ordered if self._permits & FLOW == FLOW else 0.0
        if value != self._mover.override:
            self._mover.set_override(value)

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
                self._mover.move(record)
            case Order.STOP:
                self._stop(Reason(record.reason))
            case Order.RESUME:
                state.stop_cause = 0
                self._mover.stepper.resume()
            case Order.ABANDON:
                self._mover.abandon()
            case Order.PROGRAM:
                self._mover.order_program(record)
            case Order.BELT:
                if self.belts is not None:
                    self.belts.stood(record.mask, record.value)
            case Order.EMERGENCY:
                self._emergency()
            case Order.RESET:
                self._acknowledge()
            case Order.OVERRIDE:
                self._override = min(max(record.value, 0.0), 1.0)

    def _enable(self, record: OrderRecord) -> None:
        state = self.state
        if state.emergency or not state.permits & Permit.CHAIN:
            self.state.fail(record.job, Reason.EMERGENCY_STOP)
        elif not state.permits & Permit.CONTROL:
            self.state.fail(record.job, Reason.CONTROL_NOT_ALLOWED)
        elif self._mover.join(record.mask):  # else the program is over, too
            state.stop_cause = 0
            for n, axis in enumerate(self._axes):
                if record.mask >> n & 1:
                    axis.wanted, axis.finding = True, 0
            self._enabling.append((record.job, record.mask))
        else:
            state.fail(record.job, Reason.DRIVE_ON_NOT_ALLOWED)

    def _reference(self, record: OrderRecord) -> None:
        if self._mover.stepper.state is not State.IDLE or self._homings.job:
            self.state.fail(record.job, Reason.BUSY)
        elif not self._mover.all_enabled(record.mask):
            self.state.fail(record.job, Reason.DRIVES_OFF)
        else:
            self._homings.begin(record.job, record.mask)

    def feed(self, record: PieceRecord) -> None:
        """From the planner."""
        self._mover.feed(record)

    def planner_lost(self) -> None:
        """It died: the program is over after what was committed."""
        self._mover.planner_lost()

    @property
    def starved(self) -> bool:
        """A program is under way, the axes rest, and more has to come from the planner, or an input."""
        return self._mover.starved

    def _stop(self, reason: Reason) -> None:
        self._mover.stop(reason)
        if self._homings.job:
            self._homings.end(reason)
            self.state.stop_cause = reason

    def _off(self, reason: Reason, mask: int = EVERY_AXIS) -> None:
        """Drives off: the drive's own quick stop brings the axis to rest; the rest of a move is gone."""
        moved = [axis for n, axis in enumerate(self._axes) if mask >> n & 1 and axis.wanted]
        for axis in moved:
            axis.wanted = False
        if not moved:
            return
        if reason is not Reason.DRIVES_OFF:
            self.state.stop_cause = reason  # also at rest: whoever finds the drives off reads why
        if self._homings.job:
            self._homings.end(reason)
        for axis in moved:
            axis.run, axis.by_drive = None, False
        for job, wanted in self._enabling:
            if wanted & mask:
                self.state.fail(job, reason)
        self._enabling = [one for one in self._enabling if not one[1] & mask]
        if reason is Reason.DRIVES_OFF and self._mover.leave():
            return
        if self._mover.busy:
            self._mover.drop(reason)

    # ---- set values --------------------------------------------------------------------------------------------------
    def _drive(self, actuals: Sequence[Actual | None], inputs: InputImage) -> list[SetRecord]:
        """All of it happens once per SYNC."""
        mover, homings = self._mover, self._homings
        if mover.storing.by_drives:
            mover.storing.hear(actuals)
        sample = mover.step(inputs)
        if homings.under_way:
            homings.step(actuals)
        values, settled, self._eventful = self._drive_axes(self._axes, actuals, sample.q, sample.qd, self._reset)
        self._settled_axes = settled
        if homings.under_way:
            homings.judge()
        if homings.under_way or not settled:
            self._accept_positions()
        if mover.functions is not None:
            mover.functions.step(sample.q, self.state, self.outputs)
        if mover.running:
            mover.judge(sample)
        if mover.storing.on:
            mover.store([None if actual is None else axis.actual for axis, actual in zip(self._axes, actuals, strict=True)])
        self.state.progress, self.state.piece = sample.s, sample.piece_id
        return values

    def _accept_positions(self) -> None:
        """Where no set value of ours leads, the set position is the one the drive object holds, so enabling never jumps."""
        for axis in self._axes:
            if axis.drive.epoch != axis.epoch:
                axis.epoch, axis.run, axis.by_drive = axis.drive.epoch, None, False
                axis.referenced = axis.plan.absolute
            if axis.run is None and (axis.by_drive or not axis.drive.follows):
                axis.set = axis.scaling.to_si(axis.drive.set_inc)
        self._mover.accept()

    def _go_round(self) -> None:
        """At rest, and with nothing under way: nobody's path counts on the old numbers."""
        if self._endless.look():
            self._mover.accept()

    # ---- supervision -------------------------------------------------------------------------------------------------
    def _watch(self, actuals: Sequence[Actual | None]) -> None:
        self._reset = False
        found = self._watch_axes(self._axes, actuals, 0)
        while found >= 0:
            self.state.stop_cause = Reason.FOLLOWING_ERROR
            self._off(Reason.FOLLOWING_ERROR)
            found = self._watch_axes(self._axes, actuals, found + 1)
        if not self._settled_axes:
            self._judge_powers()
        if self._eventful:
            self._judge_events()
        if self._enabling:
            self._enabling = [one for one in self._enabling if not self._mover.all_enabled(one[1])]

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

    def _share(self, shared: "CoreShared") -> None:
        """Set-point outputs of several axes; two axes of one that move at a time are a servo error (rho3 L6468)."""
        wrong = shared.step(self._axes, self.outputs, jog=not self._mover.program.job)
        if wrong:
            self.state.belt_axis = wrong
            self._off(Reason.SERVO_ERROR)

    # ---- what others see ---------------------------------------------------------------------------------------------
    @property
    def contacts_lost(self) -> bool:
        """A coupler that matters for readiness is away: the cell is not ready."""
        return self._publisher.contacts_lost

    @contacts_lost.setter
    def contacts_lost(self, lost: bool) -> None:
        self._publisher.contacts_lost = lost

    def _publish(self) -> None:
        state, mover, homings = self.state, self._mover, self._homings
        if homings.under_way:
            homings.look()
        motion = Motion.REFERENCING if homings.under_way else MOTIONS[mover.stepper.state]
        if motion is Motion.IDLE and (mover.running or mover.program.job):
            motion = Motion.RUNNING  # the axes are still on their last increments, or a program is being prepared
        state.motion = motion
        state.override = self._override
        state.job = homings.job or mover.running
        self._publisher.publish(self._axes)
