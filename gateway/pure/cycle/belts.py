"""Belts in the cycle: counters once a cycle, and the synchronous part a program is in.  Pure; a cell without belts has none of this.

Type 1: the stepper's path is carried (motion.sync.join); types 2 and 3: the part itself defines the tool's coordinates, cycle by cycle,
and the joints are found from them.  Whatever ends a part ends at rest: the robot leaves a belt of type 1 within an acceleration and a
jerk; faults of types 2 and 3 open READY (rho3 L6112), and the drives stop autonomously (AX-543).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isnan, sqrt

from gateway.pure.cycle.belt_encoders import BeltEncoders
from gateway.pure.cycle.belt_parts import BeltRide, BeltRobots, BeltWay
from gateway.pure.image.records.cell import InputImage, Quality
from gateway.pure.planning.belt_statements import COUNTER, PARAMETERS, ActOrder
from motion.errors import MotionError
from motion.execution.pieces import Piece
from motion.execution.stepper import Sample, State, Stepper
from motion.execution.timed import TimedPiece
from motion.geometry.frames import compose
from motion.geometry.limits import TOUCH, AxisLimits
from motion.kinematics.base import KinematicsError, PathKinematics
from motion.kinematics.placed import first_of
from motion.sync.belt_frame import Carried
from motion.sync.belt_state import Motion
from motion.sync.belts import SET_COUNTER, SIMULATION, Belt, Condition, Sync, Type
from motion.sync.coordinates import coordinates, pose_of
from motion.sync.endless_axis import bearing
from motion.sync.errors import BeltError
from motion.sync.facts import BeltFacts, SynchronOrder, make_belts
from motion.sync.join import SyncStepper
from motion.sync.parallel import Coupling, Hold, ParallelPart
from motion.sync.synchronous_part import BeltBlock, Phase, SynchronPart
from motion.sync.tracker import Tracker

TRAVEL, SILENT, SPEED = 65001, 65002, 65003  # AX-545: an axis would leave its travel; no telegram of the encoder; an axis is too slow
DELAY = 2  # cycles from the SYNC that latches a belt to the one that activates the set value made of it (AX-144)
SILENT_CYCLES = 5
SETTLED, PATIENT_CYCLES = 0.03, 100  # share of the belt's speed its filter may be off when a robot gets on; cycles that is waited for
BEHIND_CYCLES = 50  # how long an axis at its speed limit may lag behind its belt


@dataclass(frozen=True, slots=True)
class BeltFault:
    """code: as CellState.belt_code; axis: from 1, 0: none; opens_ready: the rho 3 opens READY with it."""

    code: int
    axis: int = 0
    opens_ready: bool = False


class CoreBelts:
    """All belts of a cell and the one part that may be under way.  robots: kinematics by number, each on the axes of the cell."""

    def __init__(
        self, facts: Sequence[BeltFacts], robots: Mapping[int, PathKinematics], limits: Sequence[AxisLimits], period_s: float
    ) -> None:
        """limits: of all axes of the cell."""
        self.facts, self.all = tuple(facts), make_belts(tuple(facts), period_s)
        self.encoders = BeltEncoders(len(self.facts))
        self.order: SynchronOrder | None = None  # of the part under way
        self.fault: BeltFault | None = None
        self.engaged_now = False  # in this cycle the robot got onto its belt
        first = next(iter(robots.values()))
        self._robot, self._ride, self._way = BeltRobots(robots, tuple(limits), first), BeltRide(first), BeltWay()
        self._period = period_s
        self._trackers = [Tracker(period_s, DELAY * period_s) for _ in self.facts]
        self._q: tuple[float, ...] = ()
        self._sync: tuple[Sync, ActOrder] | None = None
        self._behind = 0
        self._override = 0.0

    # ---- counters ----------------------------------------------------------------------------------------------------
    def expect(self, place: int) -> None:
        """This belt has an encoder on a bus."""
        self.encoders.expect(place)

    def begins(self, place: int, raw: int, span: int) -> None:
        """The first telegram of its encoder has `raw` of 0..span-1; from here on counting begins at 0."""
        self.encoders.begins(place, raw, span)

    def restore(self, place: int, offset: float) -> None:
        """The counter's offset as it was kept (m or rad), NaN: none; taken once, when the encoder has spoken (AX-480)."""
        self.encoders.keep(place, offset)

    def offset(self, place: int) -> float:
        """Counter minus encoder value, m or rad: it stays while the belt runs.  NaN: nothing to keep yet."""
        return self.encoders.offset(place, self.all.all[place])

    def count(self, place: int, value: int) -> None:
        """A telegram of its encoder."""
        self.encoders.count(place, value)

    def update(self, inputs: InputImage) -> None:
        """One cycle further."""
        good = int(Quality.GOOD)
        numbers = (*range(SET_COUNTER, SET_COUNTER + len(self.facts)), SIMULATION)
        on = [n for n in numbers if inputs.quality[n >> 3] == good and inputs.bit(n)]
        self.all.inputs(on)
        self.all.update(self.encoders.counts)
        self.encoders.listen(self.all)
        carried = self.order.belt if self._ride.carried is not None and self.order is not None else -1
        for n, belt in enumerate(self.all.all):
            if n != carried:  # a carried robot's own belt: motion.sync.belt_frame
                self._trackers[n].update(belt.way + 0.5 * abs(belt.data.increment), at_rest=belt.watch.motion is Motion.STOPPED)

    @property
    def shown(self) -> Belt:
        """The belt of the running part, or the first one."""
        return self.all.all[self.order.belt if self.order is not None else 0]

    def act(self, order: ActOrder) -> None:
        """SF 15, SF 28 at once; SYNC: `awaits` until it is met, on its belt if it is inside a part.  MotionError."""
        under = self.order if self.carries else None
        possible = under is not None and under.belt == order.belt if order.inside else self.free
        if not (possible and 0 <= order.belt < len(self.facts)):
            raise MotionError(f"belt {order.belt + 1}: not possible now")
        number, (a, b, c) = order.belt + 1, order.values
        if order.function == PARAMETERS:
            self.all.belt_parameters(number, a, b, int(c))
        elif order.function == COUNTER:
            self.all.set_belt_counter(number, a)
        else:
            self._sync = (Sync(self.all.all[order.belt], order.condition, a, order.inside), order)

    @property
    def awaits(self) -> bool:
        """A SYNC waits for its belt or its input."""
        return self._sync is not None

    def met(self, inputs: InputImage) -> bool:
        """Once a cycle while it awaits; True: the counter has been set."""
        if self._sync is None:
            return False
        sync, order = self._sync
        good = order.condition is Condition.INPUT and inputs.quality[order.input >> 3] == int(Quality.GOOD)
        if not sync.met(good and inputs.bit(order.input) is order.level):
            return False
        self._sync = None
        return True

    # ---- parts -------------------------------------------------------------------------------------------------------
    @property
    def carries(self) -> bool:
        """The robot is on a belt of type 1, or leaving it."""
        return self._ride.rig is not None

    @property
    def free(self) -> bool:
        """Return whether no part is running."""
        return self.order is None

    def synchron(self, order: SynchronOrder, q: Sequence[float]) -> None:
        """Begin SYNCHRON: the axes (all of the cell) rest at q.  Raise MotionError where a part is under way or the belt does not exist."""
        if self.order is not None or not 0 <= order.belt < len(self.facts) or order.kinematic not in self.facts[order.belt].carriers:
            raise MotionError(f"SYNCHRON of kinematic {order.kinematic} on belt {order.belt + 1}: not possible now")
        self._robot.choose(order.kinematic)
        self.order, self.fault, self._q, self._behind, self._ride.waited = order, None, tuple(q), 0, 0
        self.all.all[order.belt].kind, self.all.all[order.belt].tolerance = order.kind, order.tolerance
        if order.kind is Type.PARALLEL:
            facts = self.facts[order.belt]
            belt, coupling = self.all.all[order.belt], Coupling(facts.accel, facts.jerk)
            carrier = facts.carriers[order.kinematic]
            self._ride.bearing = bearing(carrier, self._robot.now, self._robot.limits, first_of(self._robot.now))
            self._ride.carried = Carried(ParallelPart(belt, carrier), self._trackers[order.belt], coupling)
            return
        belt = self.all.all[order.belt]
        robot = self._robot.now
        pose = compose(robot.forward(self._q[: robot.axes]), order.tool)
        self._way.rotation = pose.rotation
        self._way.part = SynchronPart(belt, order.kinematic, (*coordinates(pose, pose.rotation), *self._q[robot.axes :]), order.at)

    def add(self, block: BeltBlock) -> None:
        """The next block of types 2 and 3; BeltError, MotionError."""
        if self._way.part is None:
            raise MotionError("a block without its part")
        others = self._way.part.position[len(block.target) :]  # axes of the cell that are not the robot's stay
        via = (*block.via, *others) if block.via else ()
        self._way.part.add(replace(block, target=(*block.target, *others), via=via))

    def drop(self) -> None:
        """The part is over, or forgotten; the axes are released."""
        self.order, self._way.part, self._sync = None, None, None
        self._ride.drop()

    def forget(self) -> None:
        """The program whose SYNC waits is over."""
        self._sync = None

    def release(self) -> bool:
        """SYNCHRON_END of type 1: bring the robot to rest beside the belt; True when it has."""
        self.forget()
        if self._ride.carried is None or self._ride.rig is None:
            return True
        self._ride.carried.release()
        arrived = self._behind == 0 or self._ride.rig.fault is not None
        return self._ride.carried.coupling.state is Hold.OFF and arrived

    @property
    def done(self) -> bool:
        """A part of type 2 or 3 has run all blocks it has."""
        return self._way.in_phase(Phase.BETWEEN)

    @property
    def running(self) -> bool:
        """Return whether a block of type 2 or 3 is running."""
        return self._way.in_phase(Phase.RUNNING)

    def stop(self) -> BeltFault | None:
        """Stop the part: type 1 leaves its belt; with types 2 and 3 return the error of feed hold (rho3 L6113)."""
        if self._way.part is not None and self.running:
            return BeltFault(self._way.part.hindered("stopped").code, 0, opens_ready=True)
        self.release()
        return None

    def set_override(self, value: float) -> bool:
        """True when it acts here instead of at the stepper."""
        self._override = value
        return self._ride.rig is not None

    def load(self, piece: Piece | TimedPiece) -> bool:
        """A piece of a type 1; False: it is the stepper's alone."""
        if self._ride.rig is None:
            return False
        self._ride.rig.load(piece)
        return True

    # ---- one cycle ---------------------------------------------------------------------------------------------------
    def step(self, stepper: Stepper, inputs: InputImage) -> Sample:
        """Set values of all axes; `fault` is the cause that ended the part."""
        self.update(inputs)
        self.engaged_now = False
        order = self.order
        if order is None:
            return stepper.step()
        leaving = self._ride.leaving
        if self.encoders.silent[order.belt] > SILENT_CYCLES and not leaving:
            self.fault = BeltFault(SILENT, 0, opens_ready=order.kind is not Type.PARALLEL)
        return self._carry(stepper, order) if order.kind is Type.PARALLEL else self._follow(stepper)

    # ---- type 1 --------------------------------------------------------------------------------------------------------
    def _carry(self, stepper: Stepper, order: SynchronOrder) -> Sample:
        carried = self._ride.carried
        assert carried is not None
        frame = carried.step(self._period)
        if self._ride.rig is None:
            belt = carried.part.belt
            ahead = (order.at - belt.counter) * (-1.0 if belt.watch.speed < 0.0 else 1.0)
            self._ride.waited += not ahead > 0.0  # NaN: at once
            if self._ride.waited and (self._settled(carried) or self._ride.waited > PATIENT_CYCLES):
                self._engage(stepper, carried, order)
            return Sample(self._q, (0.0,) * len(self._q), 0, 0.0, State.IDLE, stepper.step().done_id)
        self._ride.rig.set_override(min(self._override, carried.beside))
        made = self._ride.rig.step(self._ride.framed(carried, frame))
        self._behind = self._behind + 1 if made.short else 0
        self._look_ahead(carried, made.q)
        if self._behind > BEHIND_CYCLES and carried.coupling.state in (Hold.CATCHING, Hold.ON):
            self.fault = self.fault or BeltFault(SPEED, self._robot.slowest(self._q, made.q))
        speeds = tuple((b - a) / self._period for a, b in zip(self._q, made.q, strict=True))
        self._q = made.q
        path = made.path
        return Sample(made.q, speeds, path.piece_id, path.s, path.state, path.done_id)

    @staticmethod
    def _settled(carried: Carried) -> bool:
        """The filter follows the belt: a robot that got on before would start with a step."""
        watch = carried.part.belt.watch
        return abs(carried.tracker.speed - watch.speed) <= SETTLED * abs(watch.speed) + watch.stop

    def _engage(self, stepper: Stepper, carried: Carried, order: SynchronOrder) -> None:
        moved, own = self._ride.bearing, self._robot.limits[: self._ride.bearing.axes]
        rig = SyncStepper(stepper, moved, [axis.speed for axis in own], self._period, self._q)
        carried.bear(moved, own, self._q[: moved.axes])
        carried.engage()
        self._ride.reference = carried.coupling.value if isnan(order.reference) else order.reference
        try:
            rig.place(self._ride.framed(carried, carried.frame))
        except KinematicsError:
            self.fault = BeltFault(TRAVEL)
            return
        self._ride.rig, self.engaged_now = rig, True

    @property
    def value(self) -> float:
        """Of the robot's frame."""
        return self._ride.value

    def _look_ahead(self, carried: Carried, q: Sequence[float]) -> None:
        """Check that every axis would come to rest inside its travel if the robot left its belt now."""
        assert self._ride.rig is not None
        if carried.coupling.state not in (Hold.CATCHING, Hold.ON):
            return
        if self._ride.rig.fault is not None:
            self.fault = BeltFault(TRAVEL, self._robot.place_of(self._ride.rig.fault.axis))
            return
        coupling = carried.coupling
        rate = carried.part.belt.watch.speed if coupling.state is Hold.ON else coupling.rate
        lasts = max(1.875 * abs(rate) / coupling.accel, sqrt(5.78 * abs(rate) / coupling.jerk))
        ahead = carried.part.carrier.frame(0.5 * rate * lasts)
        try:
            own = q[: self._ride.bearing.axes]
            rest = self._ride.bearing.follow(compose(ahead, self._ride.bearing.forward(own)), own)
        except KinematicsError as error:
            self.fault = BeltFault(TRAVEL, self._robot.place_of(error.axis))
            return
        for number, (here, there, axis) in enumerate(zip(q, rest, self._robot.limits, strict=False), 1):
            if not min(axis.lower, here) - TOUCH <= there <= max(axis.upper, here) + TOUCH:
                self.fault = BeltFault(TRAVEL, number)
                return

    # ---- types 2 and 3 -------------------------------------------------------------------------------------------------
    def _follow(self, stepper: Stepper) -> Sample:
        part, resting = self._way.part, stepper.step()
        assert part is not None and self._way.rotation is not None and self.order is not None
        if self.fault is not None:
            return Sample(self._q, (0.0,) * len(self._q), 0, 0.0, State.IDLE, resting.done_id)
        try:
            if self._override <= 0.0 and part.phase is Phase.RUNNING:
                raise part.hindered()
            at = part.step()
        except BeltError as error:
            self.fault = BeltFault(error.code, 0, opens_ready=True)
            return Sample(self._q, (0.0,) * len(self._q), 0, 0.0, State.IDLE, resting.done_id)
        pose = compose(pose_of(at, self._way.rotation), self.order.tool.inverse())
        try:
            goal = (*self._robot.now.follow(pose, self._q[: self._robot.now.axes]), *at[6:])
        except KinematicsError as error:
            self.fault = BeltFault(TRAVEL, self._robot.place_of(error.axis), opens_ready=True)
            goal = self._q
        return self._limited(goal, resting.done_id)

    def _limited(self, goal: tuple[float, ...], done: int) -> Sample:
        """Shorten the entire step so that no axis exceeds its speed, as with P306 sub-query 6 = 3 (rho3 L5549-5596)."""
        h = self._period
        shares = [abs(b - a) / (axis.speed * h) for a, b, axis in zip(self._q, goal, self._robot.limits, strict=True)]
        most = max(shares)
        if most > 1.0:
            goal = tuple(a + (b - a) / most for a, b in zip(self._q, goal, strict=True))
            self._behind += 1
            if self._behind > BEHIND_CYCLES:
                self.fault = BeltFault(SPEED, shares.index(most) + 1, opens_ready=True)
        else:
            self._behind = 0
        speeds = tuple((b - a) / h for a, b in zip(self._q, goal, strict=True))
        self._q = goal
        return Sample(goal, speeds, 0, 0.0, State.IDLE, done)

    @property
    def block(self) -> int:
        """Block of the program a part of type 2 or 3 is in; 0: the planner knows."""
        if self._way.part is None or self.order is None:
            return 0
        return self.order.block + self._way.part.passed
