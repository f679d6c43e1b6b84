"""Position-dependent outputs of the rho 3: SF 1 IO logic (binary) and SF 2 PPO (INTEGER and analog).

Source: rho 3 Releases part 1, section 12 (L4211-4264); positions in workpiece coordinates (L8999-9001).  The text describes only how
running functions are reset and stopped; their behaviour along the path is decision AX-465: an IO switches its output to the parameter
value when the coordinate passes the position, a PPO leads its output in proportion to the coordinate's way, from the value that is
proportional to the parameter value at the position; TIME_OFFS (ms) shifts both, positive: later.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum

from motion.errors import MotionError
from motion.geometry.conventions import RHO3
from motion.measure.errors import ProgramFault

IOL_IN_USE, PPO_IN_USE = "IOL:Fkt. still in use", "PPO:Fkt. still in use"
STOPPED = "PPO/IOL : IPO - STOP"
FIRST_ANALOG = 201  # function numbers from here are analog outputs (example L4243)
STILL = 1e-9  # mm or deg in a cycle: the coordinate does not move


class Stop(Enum):
    """What ends a running function (L4247-4258)."""

    FEED_HOLD = "feed hold"
    FEED_ALLOW = "feed allow was removed"
    TRAVEL_ALLOW = "travel allow was removed"
    RESET = "reset"
    EMERGENCY = "emergency stop"
    INTERPOLATOR_STOP = "interpolator stop"
    RUNTIME_ERROR = "runtime error"
    COORDINATE = "the coordinate is at rest"


class Kind(Enum):
    """SF 1 or SF 2; the value names outputs."""

    IOL = "binary"
    PPO = "value"


@dataclass(frozen=True, slots=True)
class Analog:
    """An analog output: rated value of P405 and the maximum of the board, 13.3 or 10 V."""

    rated: float
    volts: float = 10.0

    def __post_init__(self) -> None:
        if not (self.rated > 0.0 and math.isfinite(self.rated) and self.volts in (10.0, 13.3)):
            raise MotionError(f"analog output: rated value {self.rated} above 0 (P405), 10 or 13.3 V, not {self.volts}")


@dataclass(frozen=True, slots=True)
class Call:
    """Parameters as both functions have them.  number negative: reset; position: mm or deg; time_ms: TIME_OFFS."""

    number: int
    kinematic: int
    coordinate: int
    position: float
    value: float
    time_ms: int = 0
    system: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # workpiece system its coordinate is of


@dataclass(slots=True)
class _Running:
    call: Call
    begin_value: float
    begin: float | None = None  # coordinate when the function was first seen
    before: float = 0.0
    moved: bool = False
    frozen: bool = False


Key = tuple[Kind, int, int]  # kind, kinematic, function number


@dataclass(slots=True)
class PathOutputs:
    """All such functions of one control.  `outputs` holds the values at the outputs: 0 or 1, INTEGER, V."""

    analog: Mapping[int, Analog] = field(default_factory=dict)  # by PPO number
    outputs: dict[Key, float] = field(default_factory=dict, init=False)
    stopped: tuple[Kind, int] | None = field(default=None, init=False)  # function the last step stopped
    _running: dict[Key, _Running] = field(default_factory=dict, init=False)

    def call(self, kind: Kind, asked: Call) -> None:
        """SF 1 or SF 2.  ProgramFault `Fkt. still in use` while the function has not ended; a negative number ends it at once."""
        self._check(kind, asked)
        key = (kind, asked.kinematic, abs(asked.number))
        if asked.number < 0:
            self._running.pop(key, None)
            self._put(key, asked.value)
            return
        if key in self._running:
            raise ProgramFault(IOL_IN_USE if kind is Kind.IOL else PPO_IN_USE, f"function {asked.number}, kinematic {asked.kinematic}")
        self._running[key] = _Running(asked, self._coordinate(key))

    def in_use(self, kind: Kind, kinematic: int, number: int) -> bool:
        """Whether the function may not be called anew."""
        return (kind, kinematic, number) in self._running

    def step(self, kinematic: int, point: Sequence[float], period_s: float, stops: Sequence[Stop] = ()) -> str:
        """Once a cycle.  point: original coordinates of the set point, mm and deg; stops: what holds now.

        Returns the message PPO/IOL : IPO - STOP with function and reason when a function was stopped, else an empty text.
        """
        said, self.stopped = "", None
        for key, running in list(self._running.items()):
            if key[1] != kinematic or running.frozen:
                continue
            own = _seen(running.call.system, point)
            reason = self._reason(running, own, stops)
            if reason is not None:
                self._stop(key, running)
                self.stopped = self.stopped or (key[0], key[2])
                said = said or f"{STOPPED} ({key[0].name} {key[2]}, kinematic {kinematic}: {reason.value})"
            elif self._advance(key, running, own, period_s):
                del self._running[key]
        return said

    def _reason(self, running: _Running, point: Sequence[float], stops: Sequence[Stop]) -> Stop | None:
        """Only a function whose coordinate has begun to move can be stopped: before, it waits for its block."""
        if not running.moved:
            return None
        if stops:
            return stops[0]
        here = point[running.call.coordinate - 1]
        return Stop.COORDINATE if abs(here - running.before) <= STILL and not _reached(running, here) else None

    def _stop(self, key: Key, running: _Running) -> None:
        if key[0] is Kind.IOL:
            del self._running[key]  # aborted and reset
            self._put(key, 0.0)
        else:
            running.frozen = True  # keeps its value, and its number until it is reset

    def _advance(self, key: Key, running: _Running, point: Sequence[float], period_s: float) -> bool:
        """True: the function has ended."""
        call, here = running.call, point[running.call.coordinate - 1]
        if running.begin is None:
            running.begin = running.before = here
        change = here - running.before
        running.moved = running.moved or abs(change) > STILL
        running.before = here
        shifted = here - change / period_s * call.time_ms * 1e-3
        ended = _reached(running, shifted)
        if key[0] is Kind.PPO and not ended:
            way = call.position - running.begin
            share = min(max((shifted - running.begin) / way, 0.0), 1.0)
            self.outputs[key] = running.begin_value + share * (self._scaled(key, call.value) - running.begin_value)
        if ended:
            self._put(key, call.value)
        return ended

    def _coordinate(self, key: Key) -> float:
        return self.outputs.get(key, 0.0)

    def _put(self, key: Key, value: float) -> None:
        self.outputs[key] = float(value != 0.0) if key[0] is Kind.IOL else self._scaled(key, value)

    def _scaled(self, key: Key, value: float) -> float:
        """Analog: value / rated x most volts, held within the board's range."""
        if key[2] < FIRST_ANALOG:
            return value
        output = self.analog[key[2]]
        return min(max(value / output.rated, -1.0), 1.0) * output.volts

    def _check(self, kind: Kind, asked: Call) -> None:
        name = kind.name
        if asked.number == 0 or asked.kinematic < 1:
            raise MotionError(f"{name}: function {asked.number}, kinematic {asked.kinematic}: numbers from 1 on are needed")
        if kind is Kind.PPO and abs(asked.number) >= FIRST_ANALOG and abs(asked.number) not in self.analog:
            raise MotionError(f"PPO {asked.number}: analog output {abs(asked.number)} has no rated value (P405)")
        if not math.isfinite(asked.value):
            raise MotionError(f"{name} {asked.number}: parameter value {asked.value} is not a number")
        if asked.number > 0 and not (asked.coordinate >= 1 and math.isfinite(asked.position)):
            raise MotionError(f"{name} {asked.number}: coordinate {asked.coordinate}, position {asked.position} do not fit")


def _seen(system: Sequence[float], point: Sequence[float]) -> Sequence[float]:
    """Coordinates in a workpiece system (L8999-9001)."""
    return RHO3.values(RHO3.pose(system).inverse() @ RHO3.pose(point)) if any(system) else point


def _reached(running: _Running, here: float) -> bool:
    """Return whether the coordinate has reached the position from the side on which it began."""
    begin = running.begin if running.begin is not None else here
    way = running.call.position - begin
    return (here - running.call.position) * (1.0 if way >= 0.0 else -1.0) >= -STILL
