"""Control logic of the cycle.  Once per SYNC: actual values and orders in, set values and the published state out.  Pure.

It owns the drives' power machines, the enabling inputs, the emergency-stop latch, and a lane for each kinematic: paths, programs,
referencing and override of its axes.  It decides nothing the command sources should decide.  A new core starts with drives off, override 0,
nothing referenced and no rest of a move (design: section 4).
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from drivers.drives.family import Actual, Event, Power, SetRecord
from drivers.drives.tracking import Tracking
from gateway.pure.cycle.axis import CoreAxis, HeldAxis
from gateway.pure.cycle.axis_loops import PYTHON, AxisLoops
from gateway.pure.cycle.core_settings import AS_SHIPPED_RULES, NO_PARTS, CoreParts, CoreRules
from gateway.pure.cycle.core_watch import DriveWatch, Permissions, ServicesWatch
from gateway.pure.cycle.enabling_inputs import EVERY, EnablingInputs
from gateway.pure.cycle.endless import CoreEndless
from gateway.pure.cycle.lane import give_back, held_together, lanes_with, leading, whole_of, withhold
from gateway.pure.cycle.lane_parts import LaneParts
from gateway.pure.cycle.lanes import make_lanes, merged
from gateway.pure.cycle.publish import Publisher
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import (
    EVERY_AXIS,
    RC_BYTES,
    AxisState,
    CellState,
    InputImage,
    Order,
    OrderRecord,
    Permit,
    worst,
)
from gateway.pure.image.records.planner import PieceRecord
from motion.execution.stepper import State
from motion.timing.foresight import Foresight
from protocols.base.machine import Ns

if TYPE_CHECKING:
    from gateway.pure.cycle.shared_output import CoreShared

SETTLE_S = 0.5  # settling time after the last set value before standstill monitoring starts (AX-268)
LOST_STOP_S = 2.0  # an axis still moving this long after its chain or control input was lost is switched off
CHAIN, CONTROL, FEED, RUN, TRAVEL = (int(permit) for permit in Permit)
FLOW = FEED | RUN
BROKEN = ((Power.FAULT, Reason.DRIVE_FAULT), (Power.LOST, Reason.DRIVE_LOST))
TOO_MANY_SKIPPED = 3  # SYNCs skipped in a row: stop on the path


class CycleLogic:
    """One cell's axes."""

    def __init__(
        self,
        axes: Sequence[CoreAxis],
        period_s: float,
        generation: int,
        rules: CoreRules = AS_SHIPPED_RULES,
        parts: CoreParts = NO_PARTS,
        *,
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
        self.belts, self._shared = parts.belts, parts.shared
        self.lanes = make_lanes(
            LaneParts(
                self._axes, self.state, self.outputs, period_s, rules.override_step, foresight,
                parts.belts, parts.alter, parts.functions, self._off,
            )
        )  # fmt: skip
        self._drives = DriveWatch(loops.drive_axes, loops.watch_axes)
        self._publisher = Publisher(self.state, self.outputs, rules.numbers, period_s, loops)
        self._services = ServicesWatch(rules.finish_without_services)
        self._permissions = Permissions(EnablingInputs(rules.numbers, rules.assumed, [axis.kinematic for axis in axes]))
        self._enabling: list[tuple[int, int]] = []  # job, mask, of each that waits for its axes
        self._reset = False

    def _tracking(self, plan: CoreAxis) -> Tracking:
        return Tracking(plan.standstill, plan.lag_warn, plan.lag_trip, round(SETTLE_S / self._period))

    # ---- one cycle ---------------------------------------------------------------------------------------------------
    def idle(self) -> list[SetRecord]:
        """Set values before the first SYNC."""
        return [axis.drive.idle() for axis in self._axes]

    def step(
        self, actuals: Sequence[Actual | None], inputs: InputImage, orders: Sequence[OrderRecord], services_ns: Ns, now: Ns
    ) -> list[SetRecord]:
        """actuals: (axes,) of this SYNC, None where the telegram did not come; services_ns: stamp of the services' last beat."""
        self.state.cycle += 1
        for lane in self.lanes:
            lane.state.sync_ns = now
        self.state.sync_ns = now
        self._judge_inputs(inputs, services_ns, now)
        self._judge_services(services_ns, now)
        for order in orders:
            self._obey(order)
        self._apply_override()
        values = self._drive(actuals, inputs)
        self._watch(actuals)
        if self._endless.axes:
            self._go_round()
        self._publish()
        if len(self.lanes) > 1:
            give_back(self.lanes)
        if self._shared is not None:
            self._share(self._shared)
        return values

    # ---- inputs ------------------------------------------------------------------------------------------------------
    def _judge_inputs(self, inputs: InputImage, services_ns: Ns, now: Ns) -> None:
        permissions = self._permissions
        view = permissions.inputs.judge(inputs, services_ns, now)
        if permissions.changed(view.permits):
            self.state.permits = EVERY[view.permits]
        if (single := permissions.inputs.single) is not None and (lost := withhold(self.lanes, single, inputs, services_ns, now)):
            self._stop(Reason.INPUT_LOST, lost)
        if view.taken & CHAIN and permissions.chain_seen:
            self._emergency()
        if view.taken & CONTROL:
            self._off(Reason.CONTROL_NOT_ALLOWED)
        self._judge_lost(view.just_lost, view.lost)
        if view.taken & TRAVEL:
            self._stop(Reason.TRAVEL_NOT_ALLOWED)
        if view.permits & CHAIN:
            permissions.chain_seen = True
        self._reset = view.reset
        if self._reset:
            self._acknowledge()

    def _judge_lost(self, just_lost: int, lost: int) -> None:
        """Inputs that are lost, not taken away: stop on the path, and without chain or control off at rest (AX-143)."""
        if just_lost:
            self._stop(Reason.INPUT_LOST)
        if not lost & (CHAIN | CONTROL):
            self._permissions.lost_cycles = 0
            return
        self._permissions.lost_cycles += 1
        moving = any(lane.homings.job or lane.mover.moving for lane in self.lanes)
        if not moving or self._permissions.lost_cycles * self._period > LOST_STOP_S:
            self._off(Reason.INPUT_LOST)

    def _judge_services(self, services_ns: Ns, now: Ns) -> None:
        alive = self._services.heard(services_ns, now)
        if not alive:
            self.services_lost()
        self._services.alive = alive

    def services_lost(self) -> None:
        """They are silent, or a successor is there already: it knows nothing of the move that runs, so the move ends as configured."""
        if not self._services.lost():
            return  # noticed before
        self.state.services_lost += 1
        for lane in self.lanes:
            if lane.held or not self._services.finish:
                lane.stop(Reason.SERVICES_LOST)

    def _apply_override(self) -> None:
        """Hold on the path on feed hold or missing feed allow; the move continues when they are back (like the old feed hold)."""
        for lane in self.lanes:
            ordered = lane.ramp.step(lane.ordered) * lane.factor
            value = ordered if self._permissions.permits & FLOW & ~lane.withheld == FLOW else 0.0
            if value != lane.mover.override:
                lane.mover.set_override(value)

    def _emergency(self) -> None:
        if not self.state.emergency:
            self._latch(closed=True)
            self._because(Reason.EMERGENCY_STOP)
        self._off(Reason.EMERGENCY_STOP)

    def _acknowledge(self) -> None:
        if self.state.permits & Permit.CHAIN:
            self._latch(closed=False)
        self._because(Reason.NONE)
        self._reset = True
        for axis in self._axes:
            axis.finding = 0

    def _because(self, reason: Reason, mask: int = EVERY_AXIS) -> None:
        """Why these axes stopped last."""
        for lane in lanes_with(self.lanes, mask):
            lane.state.stop_cause = reason

    def _latch(self, *, closed: bool) -> None:
        self.state.emergency = closed
        for lane in self.lanes:
            lane.state.emergency = closed

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
            case Order.MOVE | Order.PROGRAM:
                self._move(record)
            case Order.STOP:
                self._stop(Reason(record.reason), record.mask or EVERY_AXIS)
            case Order.RESUME | Order.ABANDON | Order.OVERRIDE | Order.HOLD | Order.RETRACE | Order.DISTANCE | Order.FACTOR:
                for lane in lanes_with(self.lanes, record.mask or EVERY_AXIS):
                    lane.obey(record)
            case Order.BELT:
                if self.belts is not None:
                    self.belts.restore(record.mask, record.value)
            case Order.EMERGENCY:
                self._emergency()
            case Order.RESET:
                self._acknowledge()

    def _move(self, record: OrderRecord) -> None:
        """Start a single piece or a program."""
        lane = leading(self.lanes, record.mask or EVERY_AXIS)
        if lane is None:
            self.state.fail(record.job, Reason.BUSY)
            return
        lane.held = record.reason == Reason.SERVICES_LOST
        if not lane.busy:
            lane.factor, lane.moves = 1.0, record.mask or EVERY_AXIS
        if record.order is Order.MOVE:
            lane.mover.move(record)
        else:
            for other in self.lanes:
                if other is not lane and other.own & record.mask:
                    other.state.measured_mask = 0  # a new program has measured nothing
            lane.mover.order_program(record)

    def _enable(self, record: OrderRecord) -> None:
        state = self.state
        if state.emergency or not state.permits & Permit.CHAIN:
            self.state.fail(record.job, Reason.EMERGENCY_STOP)
        elif not state.permits & Permit.CONTROL:
            self.state.fail(record.job, Reason.CONTROL_NOT_ALLOWED)
        elif self._joined(record.mask):  # else the program is over, too
            self._because(Reason.NONE, record.mask)
            for n, axis in enumerate(self._axes):
                if record.mask >> n & 1:
                    axis.wanted, axis.finding = True, 0
            self._enabling.append((record.job, record.mask))
        else:
            state.fail(record.job, Reason.DRIVE_ON_NOT_ALLOWED)

    def _joined(self, mask: int) -> bool:
        """These axes may be switched on: asked of each lane that has some."""
        joined = [lane.mover.join(mask & lane.holds) for lane in lanes_with(self.lanes, mask)]
        return all(joined)

    def _reference(self, record: OrderRecord) -> None:
        lane = leading(self.lanes, record.mask)
        if lane is None or lane.mover.stepper.state is not State.IDLE or lane.homings.job:
            self.state.fail(record.job, Reason.BUSY)
        elif not lane.mover.all_enabled(record.mask):
            self.state.fail(record.job, Reason.DRIVES_OFF)
        else:
            lane.held, lane.moves = record.reason == Reason.SERVICES_LOST, record.mask
            lane.homings.begin(record.job, record.mask)

    def feed(self, record: PieceRecord) -> None:
        """From the planner."""
        lane = next((lane for lane in self.lanes if lane.mover.program.job == record.job), self.lanes[0])
        lane.mover.feed(record)

    def planner_lost(self) -> None:
        """It died: every program is over after what was committed."""
        for lane in self.lanes:
            lane.mover.planner_lost()

    @property
    def starved(self) -> bool:
        """Return whether a running program waits at rest for the planner or an input."""
        return any(lane.mover.starved for lane in self.lanes)

    def _stop(self, reason: Reason, mask: int = EVERY_AXIS) -> None:
        for lane in lanes_with(self.lanes, mask):
            lane.stop(reason)

    def _off(self, reason: Reason, mask: int = EVERY_AXIS) -> None:
        """Drives off: the drive's own quick stop brings the axis to rest; the rest of a move is gone."""
        places = [n for n, axis in enumerate(self._axes) if mask >> n & 1 and axis.wanted]
        moved = [self._axes[n] for n in places]
        for axis in moved:
            axis.wanted = False
        if not moved:
            return
        if reason is not Reason.DRIVES_OFF:
            self._because(reason, mask)  # also at rest: the reason stays readable while the drives are off
        lanes = lanes_with(self.lanes, sum(1 << n for n in places))
        for lane in lanes:
            if lane.homings.job:
                lane.homings.end(reason)
        for axis in moved:
            axis.run, axis.by_drive = None, False
        for job, wanted in self._enabling:
            if wanted & mask:
                self.state.fail(job, reason)
        self._enabling = [one for one in self._enabling if not one[1] & mask]
        for lane in lanes:
            if not (reason is Reason.DRIVES_OFF and lane.mover.leave()) and lane.mover.busy:
                lane.mover.drop(reason)

    # ---- set values --------------------------------------------------------------------------------------------------
    def _drive(self, actuals: Sequence[Actual | None], inputs: InputImage) -> list[SetRecord]:
        """All of it happens once per SYNC."""
        samples = []
        for lane in self.lanes:
            if lane.mover.storing.by_drives:
                lane.mover.storing.hear(actuals)
            samples.append(lane.mover.step(inputs))
            if lane.homings.under_way:
                lane.homings.step(actuals)
        sample = merged(self.lanes, samples)
        values, settled, self._drives.eventful = self._drives.drive(self._axes, actuals, sample.q, sample.qd, self._reset)
        self._drives.settled = settled
        referencing = [lane for lane in self.lanes if lane.homings.under_way]
        for lane in referencing:
            lane.homings.judge()
        if referencing or not settled:
            self._accept_positions()
        path_outputs = self.lanes[0].mover.functions  # of all lanes
        if path_outputs is not None:
            path_outputs.step(sample.q, self.state, self.outputs)
        for lane, own in zip(self.lanes, samples, strict=True):
            if lane.mover.running:
                lane.mover.judge(own)
            if lane.mover.storing.on:
                lane.mover.store([None if actual is None else axis.actual for axis, actual in zip(self._axes, actuals, strict=True)])
            lane.state.progress, lane.state.piece = own.s, own.piece_id
        return values

    def _accept_positions(self) -> None:
        """Where no set value of ours leads, the set position is the one the drive object holds, so enabling never jumps."""
        for axis in self._axes:
            if axis.drive.epoch != axis.epoch:
                axis.epoch, axis.run, axis.by_drive = axis.drive.epoch, None, False
                axis.referenced = axis.plan.absolute
            if axis.run is None and (axis.by_drive or not axis.drive.follows):
                axis.set = axis.scaling.to_si(axis.drive.set_inc)
        for lane in self.lanes:
            lane.mover.accept()

    def _go_round(self) -> None:
        """Bring endless axes of resting lanes back into their modulo: no path depends on the old numbers."""
        for lane in self.lanes:
            if not (lane.mover.busy or lane.homings.under_way) and self._endless.look(lane.holds):
                lane.mover.accept()

    # ---- supervision -------------------------------------------------------------------------------------------------
    def _watch(self, actuals: Sequence[Actual | None]) -> None:
        self._reset = False
        found = self._drives.watch(self._axes, actuals, 0)
        while found >= 0:
            mask = held_together(self.lanes, [found])
            self._because(Reason.FOLLOWING_ERROR, mask)
            self._off(Reason.FOLLOWING_ERROR, mask)
            found = self._drives.watch(self._axes, actuals, found + 1)
        if not self._drives.settled:
            self._judge_powers()
        if self._drives.eventful:
            self._judge_events()
        if self._enabling:
            self._enabling = [one for one in self._enabling if not self.lanes[0].mover.all_enabled(one[1])]

    def _judge_powers(self) -> None:
        powers = [(n, axis.power) for n, axis in enumerate(self._axes) if axis.wanted]
        for power, reason in BROKEN:
            self._broke(reason, [n for n, found in powers if found is power])

    def _judge_events(self) -> None:
        """Handle spontaneous events of drives; ignored for axes that are not commanded on."""
        # left control spontaneously: a fresh command brings it back
        self._broke(Reason.DRIVE_FAULT, self._said(Event.DROPPED, Event.TIMEOUT))
        self._broke(Reason.SET_VALUE, self._said(Event.JUMP, Event.RANGE))  # not sent by the drive object: the axis is off its path

    def _said(self, *events: Event) -> list[int]:
        """Axes (from 0) that are wanted on and did one of these."""
        found = [n for n, axis in enumerate(self._axes) if axis.wanted]
        return [n for n in found if any(event in self._axes[n].drive.events for event in events)]

    def _broke(self, reason: Reason, axes: list[int]) -> None:
        """Switch off the lanes of these axes (from 0), whose drives are no longer controlled."""
        if axes:
            mask = held_together(self.lanes, axes)
            self._because(reason, mask)
            self._off(reason, mask)

    def skipped(self, in_a_row: int) -> None:
        """SYNCs were not sent: the path is late by as much, and too many in a row stop it."""
        self.state.skipped += in_a_row
        if in_a_row >= TOO_MANY_SKIPPED:
            self._stop(Reason.OVERRUN)

    def drives_lost(self) -> None:
        """The bus is gone: everything off, and only a fresh command brings it back."""
        self._because(Reason.DRIVE_LOST)
        self._off(Reason.DRIVE_LOST)

    def _share(self, shared: "CoreShared") -> None:
        """Set-point outputs of several axes; two axes of one that move at a time are a servo error (rho3 L6468)."""
        wrong = shared.step(self._axes, self.outputs, jog=not any(lane.mover.program.job for lane in self.lanes))
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
        for lane in self.lanes:
            if lane.homings.under_way:
                lane.homings.look()
            lane.state.motion = lane.motion
            lane.state.override = lane.highest
            lane.state.job = lane.homings.job or lane.mover.running
        if len(self.lanes) > 1:
            self.state.motion = worst(lane.state.motion for lane in self.lanes)
            whole_of(self.lanes, self.state)
        self._publisher.publish(self._axes)
