"""A lane of the cycle: moves the axes of one kinematic, or those of none, independently.  Pure.

A cell of one kinematic has one lane with all its axes.  An order for axes of several lanes goes to the first of them, which holds the axes
of the others until it has nothing left to do with them.
"""

import functools
import operator
from collections.abc import Iterable, Sequence

from gateway.pure.cycle.homing import Homings
from gateway.pure.cycle.mover import Mover
from gateway.pure.cycle.single_inputs import SingleInputs
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import EVERY_AXIS, CellState, InputImage, LaneState, Motion, Order, OrderRecord
from motion.execution.stepper import State
from motion.timing.override_ramp import OverrideRamp
from protocols.base.machine import Ns

MOTIONS = {
    State.IDLE: Motion.IDLE,
    State.RUNNING: Motion.RUNNING,
    State.STOPPING: Motion.STOPPING,
    State.STOPPED: Motion.STOPPED,
}
IDLE, RUNNING = State.IDLE, State.RUNNING  # asked in every cycle: State.IDLE costs a search in its class, MOTIONS a hash in Python
AT_REST, MOVES, REFERENCES = Motion.IDLE, Motion.RUNNING, Motion.REFERENCING


class Lane:
    """`state`: what a cell of these axes alone would publish; with one lane it is the cell's own."""

    withheld = 0  # bits of Permit that feed inputs of its kinematics alone withhold (AX-1787)

    def __init__(self, own: int, state: CellState, homings: Homings, mover: Mover, ramp: OverrideRamp) -> None:
        self.homings, self.mover, self.state = homings, mover, state
        self.ramp = ramp
        self.override = 0.0  # as ordered
        self.factor = 1.0  # on it, of the program or PTP move under way
        self.held = False  # the motion is hold-to-run: it stops without the services
        self.own = self.holds = own  # axes (bit n-1 = axis n)
        self.places: tuple[int, ...] = ()  # of those it holds, from 0
        self.kinematics: list[LaneState] = []  # separate states of kinematics that it always leads together
        self._single: dict[int, float] = {}  # axes of a kinematic -> override ordered for it alone, since the last one for all
        self.moves = own  # axes of the order under way
        self.hold(own)

    @property
    def busy(self) -> bool:
        """Return whether a path, a program or a reference run is not yet at its end."""
        return self.mover.busy or self.homings.under_way or self.homings.job != 0

    @property
    def motion(self) -> Motion:
        if self.homings.under_way:
            return REFERENCES
        mover = self.mover
        state = mover.stepper.state
        if state is IDLE:  # with a job: the axes are still on their last increments, or a program is being prepared
            return MOVES if mover.running or mover.program.job else AT_REST
        return MOVES if state is RUNNING else MOTIONS[state]

    @property
    def ordered(self) -> float:
        """Override of the current motion: with several kinematics the lowest of those it moves."""
        if not self.kinematics:
            return self.override
        single = self._single
        return min((single.get(each.own, self.override) for each in self.kinematics if each.own & self.moves), default=self.override)

    @property
    def highest(self) -> float:
        """Override of the kinematic that has the highest one."""
        if not self.kinematics:
            return self.override
        return max((self._single.get(each.own, self.override) for each in self.kinematics), default=self.override)

    def set_override(self, value: float, mask: int) -> None:
        """As ordered for these axes."""
        named = [each for each in self.kinematics if each.own & mask]
        if len(named) < len(self.kinematics):
            self._single |= {each.own: value for each in named}
        else:
            self.override = value
            self._single.clear()
        for each in named:
            each.override = value

    def hold(self, mask: int) -> None:
        """These axes are led by it; where no path leads, one begins where they are."""
        self.holds = self.homings.mask = mask
        self.mover.gate.mask = mask
        self.places = tuple(n for n in range(mask.bit_length()) if mask >> n & 1)

    def take(self, other: "Lane") -> None:
        """The axes of another one that has nothing to do."""
        self.hold(self.holds | other.holds)
        other.hold(0)
        self.mover.accept()

    def stop(self, reason: Reason) -> None:
        """On the path; a reference run ends."""
        self.mover.stop(reason)
        if self.homings.job:
            self.homings.end(reason)
            self.state.stop_cause = reason

    def obey(self, record: OrderRecord) -> None:
        """An order that needs no axis by name."""
        match record.order:
            case Order.RESUME:
                self.state.stop_cause = 0
                self.mover.resume()
            case Order.ABANDON:
                self.mover.abandon()
            case Order.HOLD:
                self.mover.hold_path(Reason(record.reason))
            case Order.RETRACE:
                self.mover.retrace()
            case Order.OVERRIDE:
                self.set_override(min(max(record.value, 0.0), 1.0), record.mask or EVERY_AXIS)
            case Order.DISTANCE:
                self.mover.measure.distance = record.value
            case Order.FACTOR if record.job in (self.mover.program.job, self.mover.running):
                self.factor = min(max(record.value, 0.0), 1.0)

    def show(self, shown: LaneState, whole: CellState) -> None:
        """Fill its published state; jobs that ended since the last cycle are passed on to the state of the entire cell."""
        state = self.state
        if state.done_job != shown.done_job:
            whole.done_job = state.done_job
        if (state.failed_job, state.failed_reason) != (shown.failed_job, shown.failed_reason):
            whole.fail(state.failed_job, state.failed_reason)
        for name in SHOWN:
            setattr(shown, name, getattr(state, name))
        shown.holds, shown.own, shown.override, shown.withheld = self.holds, self.own, self.override, self.withheld


SHOWN = [name for name in LaneState.__slots__ if name not in ("holds", "own", "override", "withheld")]


def whole_of(lanes: list[Lane], state: CellState) -> None:
    """What readers of the cell as one see: how much of it moves, why it stopped last, where axes were measured."""
    for lane, shown in zip(lanes, state.lanes, strict=True):
        lane.show(shown, state)
    states = [lane.state for lane in lanes]
    first = next((each for each in states if each.job), states[0])
    state.job, state.piece, state.progress = first.job, first.piece, first.progress
    state.override = max(lane.override for lane in lanes)
    state.parts, state.met = sum(each.parts for each in states), first.met
    state.stop_cause = next((each.stop_cause for each in states if each.stop_cause), 0)
    state.path_stop = next((each.path_stop for each in states if each.path_stop), 0)
    state.drive_axis = next((each.drive_axis for each in states if each.drive_axis), 0)
    state.measured_mask = 0
    for each in states:
        state.measured_mask |= each.measured_mask


# ---- which lane holds which axes: lanes of an order for axes of several are led by the first of them, and given back
def lanes_with(lanes: Sequence[Lane], mask: int) -> list[Lane]:
    """Those that hold some of these axes; with one lane it holds all there are."""
    return [lane for lane in lanes if lane.holds & mask]


def held_together(lanes: Sequence[Lane], axes: Iterable[int]) -> int:
    """Every axis of the lanes that hold these (from 0): axes of one move together or not at all."""
    mask = sum(1 << n for n in axes)
    return functools.reduce(operator.or_, (lane.holds for lane in lanes_with(lanes, mask)), 0)


def leading(lanes: Sequence[Lane], mask: int) -> Lane | None:
    """The lane that an order for these axes goes to; None: another one that has some of them has something to do."""
    first, *others = lanes_with(lanes, mask) or lanes[:1]
    if others and any(lane.busy for lane in (first, *others)):
        return None
    for lane in others:
        first.take(lane)
    return first


def give_back(lanes: Sequence[Lane]) -> None:
    """Axes of other lanes, when nothing is left to do with them."""
    for lane in lanes:
        if lane.holds & ~lane.own and not lane.busy:
            for other in lanes:
                if other is not lane and other.own & lane.holds:
                    other.hold(other.own)
                    other.mover.accept()
            lane.hold(lane.own)


def withhold(lanes: Sequence[Lane], single: SingleInputs, inputs: InputImage, services_ns: Ns, now: Ns) -> int:
    """Feed inputs of single kinematics hold what moves these; axes that lose their path with an input that has just been lost."""
    just_lost = single.judge(inputs, services_ns, now)
    for lane in lanes:
        if not lane.kinematics:
            lane.withheld = single.withheld(lane.holds or lane.own)
            continue
        for each in lane.kinematics:
            each.withheld = single.withheld(each.own)
        lane.withheld = single.withheld(lane.moves)
        just_lost &= lane.moves
    return just_lost
