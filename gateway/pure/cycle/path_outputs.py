"""IO logic and PPO of a program in the cycle: outputs led by a workpiece coordinate of the set values.  Pure.

Their behaviour on the path and their end are in motion.outputs.rho3 (rho 3 Releases part 1, L4211-4264; AX-465, AX-466); here they get
their coordinate once a cycle and their places in the image (AX-392).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gateway.pure.image.records.cell import CellState, Motion, Permit, set_bit
from gateway.pure.image.records.planner import function_number
from motion.errors import MotionError
from motion.geometry.conventions import RHO3
from motion.kinematics.base import PathKinematics
from motion.outputs.function import Function
from motion.outputs.rho3 import Analog, Call, Kind, PathOutputs, Stop

COORDINATES = 6
FULL = 0x7FFF  # of an analog output: its most volts
HELD = (Motion.STOPPING, Motion.STOPPED)


@dataclass(frozen=True, slots=True)
class OutputPlace:
    """Address of a function's value: RC output (of the lowest bit), bits (1: IO logic), rated value and volts of an analog output;
    kinematic: whose coordinates lead it, from 1."""

    output: int
    bits: int = 1
    rated: float = 0.0
    volts: float = 10.0
    kinematic: int = 1


Places = Mapping[tuple[Kind, int], OutputPlace]


class CoreOutputs:
    """All functions of a cell.  robots: kinematics by number, as motion.planner.robot.Machine has them (axes that carry the robot or the
    workpiece included), each on the axes of the cell."""

    def __init__(self, places: Places, robots: Mapping[int, PathKinematics], period_s: float) -> None:
        self._places, self._robots, self._period = places, robots, period_s
        analog = {number: Analog(place.rated, place.volts) for (kind, number), place in places.items() if kind is Kind.PPO and place.rated}
        self._functions = PathOutputs(analog)
        self._running = 0  # upper bound of the number of running functions
        self._failed = 0  # job that failed last
        self.cell: CellState | None = None  # of all lanes, where there are several
        self.masks: Mapping[int, int] = {}  # in a cell of several kinematics: kinematic -> its axes (bit n-1 = axis n)
        self._failed_of: dict[int, int] = {}  # kinematic -> job of its lane that failed last

    def call(self, asked: Function, state: CellState, image: bytearray) -> None:
        """The path has reached the statement; state: of the lane it is on.  ProgramFault: the function has not ended."""
        state = self.cell or state
        self._failed = state.failed_job
        self._failed_of = {kinematic: _failed_in(state, mask) for kinematic, mask in self.masks.items()}
        self._functions.call(*as_call(asked))
        self._running += 1
        self._show(image)

    def step(self, q: Sequence[float], state: CellState, image: bytearray) -> None:
        """q: set values of this cycle, m and rad."""
        if not self._running:
            return
        fresh, self._failed = state.failed_job != self._failed, state.failed_job
        for kinematic in {place.kinematic for (kind, number), place in self._places.items() if self._in_use(kind, number, place)}:
            robot = self._robots[kinematic]
            point = RHO3.values(robot.forward(tuple(q[: robot.axes])))
            self._functions.step(kinematic, point, self._period, self._stops(state, kinematic, fresh=fresh))
            said = self._functions.stopped
            if said is not None:
                state.path_stop = function_number(said[0] is Kind.PPO, said[1])
        self._show(image)
        self._running = sum(self._in_use(kind, number, place) for (kind, number), place in self._places.items())

    def _in_use(self, kind: Kind, number: int, place: OutputPlace) -> bool:
        return self._functions.in_use(kind, place.kinematic, number)

    def _stops(self, state: CellState, kinematic: int, *, fresh: bool) -> Sequence[Stop]:
        """fresh: an order of the cell failed in this cycle; with several lanes those of this kinematic count."""
        permits, motion = state.permits, state.motion
        if mask := self.masks.get(kinematic, 0):
            failed = _failed_in(state, mask)
            fresh, self._failed_of[kinematic] = failed != self._failed_of.get(kinematic, 0), failed
            motion, permits = state.motion_of(mask), permits & ~state.withheld(mask)
        found = (
            (state.emergency, Stop.EMERGENCY),
            (not permits & Permit.RUN, Stop.FEED_HOLD),
            (not permits & Permit.FEED, Stop.FEED_ALLOW),
            (not permits & Permit.TRAVEL, Stop.TRAVEL_ALLOW),
            (motion in HELD, Stop.INTERPOLATOR_STOP),
            (fresh, Stop.RUNTIME_ERROR),
        )
        return [stop for holds, stop in found if holds]

    def _show(self, image: bytearray) -> None:
        for (kind, number), place in self._places.items():
            value = self._functions.outputs.get((kind, place.kinematic, number))
            if value is None:
                continue
            if kind is Kind.IOL:
                set_bit(image, place.output, value != 0.0)
            else:
                octet, size = place.output >> 3, place.bits >> 3
                image[octet : octet + size] = _raw(value, place).to_bytes(size, "big")  # the word order of every command source (AX-010)


def _failed_in(state: CellState, mask: int) -> int:
    """The newest order that failed in a lane with these axes."""
    lanes = state.apart
    return max((lane.failed_job for lane in lanes if lane.holds & mask), default=0) if lanes else state.failed_job


def _raw(value: float, place: OutputPlace) -> int:
    """Return two's complement, limited to the range of its bits; analog: FULL is the maximum of the board."""
    scaled = value / place.volts * FULL if place.rated else value
    half = 1 << (place.bits - 1)
    return min(max(round(scaled), -half), half - 1) & (2 * half - 1)


def as_call(asked: Function) -> tuple[Kind, Call]:
    """Convert to the arguments of the functions."""
    kind = Kind.PPO if asked.ppo else Kind.IOL
    return kind, Call(asked.number, asked.kinematic, asked.coordinate, asked.position, asked.value, asked.time_ms, asked.system)


def check_function(asked: Function, places: Places, kinematic: int) -> None:
    """Before anything moves; MotionError names what the robot, of this number in its cell, does not have."""
    kind, call = as_call(asked)
    PathOutputs({number: Analog(1.0) for _, number in places}).call(kind, call)
    own = [key for key, place in places.items() if place.kinematic == kinematic]
    if (kind, abs(call.number)) not in own:
        known = ", ".join(sorted(f"{each.name} {number}" for each, number in own)) or "none"
        raise MotionError(f"{kind.name} {abs(call.number)}: no such function; the robot has {known} ([[path_output]])")
    if call.kinematic != kinematic or (call.number > 0 and call.coordinate > COORDINATES):
        raise MotionError(
            f"{kind.name} {call.number}: kinematic {call.kinematic}, coordinate {call.coordinate}; kinematic {kinematic}, 1..6: x y z a b c"
        )
