"""The belts of a cell: counters, their reset values, types, thresholds, simulation, and the statement SYNC.

Source: rho 3 Releases part 1: TO01 section 5 (SF 28, L1694-1752), TO04 sections 14-15 (SF 21, SF 15), TO08 section 4 (endless belt,
L11583-11672).  Special functions use the manual's units (mm or deg, mm/s, ms); positions and speeds inside are m or rad, and per s.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import Enum

from motion.errors import MotionError
from motion.geometry.units import kind_of, to_si
from motion.robot import MOST_BELTS
from motion.sync.belt_state import Watch
from motion.sync.errors import NO_BELT, NOT_POSSIBLE, WRONG_KIND, BeltError

SET_COUNTER, SIMULATION = 376, 399  # RC inputs: first of eight "set belt counter"; "switch on belt simulation"
STANDARD_TOLERANCE = 5  # interpolation cycles of belt way
WRAP = 1 << 32  # increments of a measuring system


class Type(Enum):
    """Units place of TYPE_BELT."""

    PARALLEL, ALONE, CAM = 1, 2, 3


@dataclass(frozen=True, slots=True)
class BeltData:
    """increment: m or rad of one increment, its sign the counting direction; simulated: P508 in unit/s; unit: mm or deg."""

    increment: float
    simulated: float = 0.0
    unit: str = "mm"

    def __post_init__(self) -> None:
        kind_of(self.unit)
        if not 0.0 < abs(self.increment) < 1.0 or not abs(self.simulated) < 1e9:
            raise MotionError(f"belt: increment {self.increment:g}, P508 = {self.simulated:g}: finite, and the increment not 0")


@dataclass(slots=True)
class Belt:
    """One belt.  way: everything it ran since start-up; counter: what programs see; m or rad."""

    number: int
    data: BeltData
    watch: Watch
    way: float = 0.0
    zero: float = 0.0  # way at which the counter would be 0
    reset_value: float = 0.0  # loaded by the signal and by SYNC (SF 28)
    kind: Type = Type.PARALLEL
    tolerance: int = STANDARD_TOLERANCE
    rebased: int = 0  # how often the counter jumped: absolute values of before mean nothing any more

    @property
    def counter(self) -> float:
        """m or rad."""
        return self.way - self.zero

    def set_counter(self, value: float) -> None:
        """Set the counter's present value; the way keeps counting."""
        self.zero = self.way - value
        self.rebased += 1

    def subtract(self, value: float) -> None:
        """The counter less this value, whatever the belt does meanwhile: the endless belt."""
        self.zero += value
        self.rebased += 1

    @property
    def room(self) -> float:
        """Tolerance: the way of the set number of interpolation cycles at the present speed, m or rad."""
        return self.tolerance * abs(self.watch.speed) * self.watch.cycle_s

    def check_type(self, type_belt: int) -> tuple[Type, int]:
        """1; 2, 12 .. 122; 3, 13 .. 123: type and tolerance; BeltError 92."""
        tens, units = divmod(type_belt, 10)
        if units not in (1, 2, 3) or not 0 <= tens <= 12 or (units == 1 and tens):
            raise BeltError(WRONG_KIND, f"belt {self.number}: type {type_belt}")
        return Type(units), tens or STANDARD_TOLERANCE


@dataclass(slots=True)
class Belts:
    """All belts (P501 = how many).  period_s: between two calls of update; cycle_s: interpolation cycle, a multiple of it."""

    data: Sequence[BeltData]
    period_s: float
    cycle_s: float
    all: tuple[Belt, ...] = field(init=False)
    simulated: bool = field(init=False, default=False)
    _counts: list[int] | None = field(init=False, default=None)
    _set: list[bool] = field(init=False)
    _every: int = field(init=False)
    _clock: int = field(init=False, default=0)
    _cycle_ways: list[float] = field(init=False)

    def __post_init__(self) -> None:
        if len(self.data) > MOST_BELTS:
            raise MotionError(f"P501 = {len(self.data)}: at most {MOST_BELTS} belts")
        self._every = round(self.cycle_s / self.period_s) if self.period_s > 0 else 0
        if self._every < 1 or abs(self._every * self.period_s - self.cycle_s) > 1e-9:
            raise MotionError(f"interpolation cycle {self.cycle_s:g} s is not a multiple of the period {self.period_s:g} s")
        self.all = tuple(Belt(number, data, Watch(self.cycle_s)) for number, data in enumerate(self.data, 1))
        self._set = [False] * len(self.all)
        self._cycle_ways = [0.0] * len(self.all)

    def belt(self, number: int) -> Belt:
        """From 1; BeltError 93."""
        if not 1 <= number <= len(self.all):
            raise BeltError(NO_BELT, f"belt {number}, P501 = {len(self.all)}")
        return self.all[number - 1]

    # ---- special functions -------------------------------------------------------------------------------------------
    def set_belt_counter(self, number: int, value: float) -> None:
        """SF 28: the value (mm or deg) that the signal and SYNC load from now on; the counter itself stays."""
        belt = self.belt(number)
        if not abs(value) < 1e9:
            raise MotionError(f"belt {number}: reset value {value:g} is not a usable number")
        belt.reset_value = to_si(value, belt.data.unit)

    def belt_type(self, number: int, type_belt: int) -> None:
        """SF 21; for all processes until changed; BeltError 92, 93."""
        belt = self.belt(number)
        belt.kind, belt.tolerance = belt.check_type(type_belt)

    def belt_parameters(self, number: int, v_stop: float, v_run: float, time_ms: int) -> None:
        """SF 15: thresholds in mm/s or deg/s, time in ms; BeltError 93."""
        belt = self.belt(number)
        belt.watch.parametrise(to_si(v_stop, belt.data.unit), to_si(v_run, belt.data.unit), time_ms / 1000)

    # ---- signals and measuring systems ---------------------------------------------------------------------------------
    def inputs(self, on: Iterable[int]) -> None:
        """RC inputs that are 1, by bit number: 376 .. 383 load the counters at their rising edge (AX-441), 399 simulates."""
        signals = set(on)
        self.simulated = SIMULATION in signals
        for index, belt in enumerate(self.all):
            now = SET_COUNTER + index in signals
            if now and not self._set[index]:
                belt.set_counter(belt.reset_value)
            self._set[index] = now

    def update(self, counts: Sequence[int]) -> None:
        """One period further; counts: increments of the measuring systems, any 32 bits of them."""
        if len(counts) != len(self.all):
            raise MotionError(f"{len(counts)} measuring systems for {len(self.all)} belts")
        before, self._counts = self._counts or list(counts), list(counts)
        self._clock = (self._clock + 1) % self._every
        for index, belt in enumerate(self.all):
            step = (counts[index] - before[index] + WRAP // 2) % WRAP - WRAP // 2
            way = to_si(belt.data.simulated, belt.data.unit) * self.period_s if self.simulated else step * belt.data.increment
            belt.way += way
            self._cycle_ways[index] += way
            if self._clock == 0:
                belt.watch.update(self._cycle_ways[index] / self.cycle_s)
                self._cycle_ways[index] = 0.0


class Condition(Enum):
    """Of the statement SYNC."""

    INPUT, AT_MOST, AT_LEAST = "input", "<=", ">="


@dataclass(slots=True)
class Sync:
    """SYNC belt, input=v | SYNC belt <= v | SYNC belt >= v: ask met() once a cycle; the program waits until it is True.

    value: m or rad.  inside: the statement is in a synchronous part: an endless belt, whose counter is lessened by the value
    instead of set; an input as condition is not possible there (L11617), BeltError 20.
    """

    belt: Belt
    condition: Condition
    value: float = 0.0
    inside: bool = False

    def __post_init__(self) -> None:
        if self.inside and self.condition is Condition.INPUT:
            raise BeltError(NOT_POSSIBLE, f"belt {self.belt.number}: SYNC with an input inside the synchronous part")

    def met(self, signal: bool = False) -> bool:
        """True once: the condition holds and the counter has been set."""
        counter = self.belt.counter
        if self.condition is Condition.INPUT:
            holds = signal
        else:
            holds = counter <= self.value if self.condition is Condition.AT_MOST else counter >= self.value
        if holds and self.inside:
            self.belt.subtract(self.value)
        elif holds:
            self.belt.set_counter(self.belt.reset_value)
        return holds
