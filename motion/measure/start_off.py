"""Fast, smooth start-off: WAIT UNTIL on a high-speed input directly before a movement.

Source: rho 3 Releases part 1, section 4 (L1574-1655); TO04, section 2 (L4740-4768); TO05, section 15 (L8196-8215).  The wait is a block
of a kinematic, so block preparation goes on.  The movement starts one position-controller cycle after the condition plus at
most one interpolation cycle; statements in between cost two interpolation cycles more; MAX_TIME is a wanted delay.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from motion.errors import MotionError
from motion.measure.errors import INADMISSABLE_INPUT, ProgramFault
from motion.measure.inputs import Board, Edge, InputKind, MeasuringInput, admitted

BETWEEN = 2  # P5 cycles more when other statements stand between the wait and the movement (TO04)
ROUNDING = 1e-6  # of a position-controller cycle: 0.15 s is 150 cycles of 1 ms, whatever its last bit says


@dataclass(frozen=True, slots=True)
class Clock:
    """period_ns: P5, the grid on which blocks start, from 0; cycle_ns: LRTAKT, which divides it."""

    period_ns: int
    cycle_ns: int

    def __post_init__(self) -> None:
        if not (0 < self.cycle_ns <= self.period_ns and self.period_ns % self.cycle_ns == 0):
            raise MotionError(f"position-controller cycle {self.cycle_ns} ns does not divide the interpolation cycle {self.period_ns} ns")


@dataclass(frozen=True, slots=True)
class Wait:
    """WAIT UNTIL channel = value MAX_TIME = max_time_s.  between: other statements follow before the movement."""

    asked: MeasuringInput
    value: bool
    max_time_s: float = 0.0
    between: bool = False


@dataclass(slots=True)
class StartOff:
    """One wait of one kinematic.  `step` once an interpolation cycle, at its instant; True: the block starts in this cycle."""

    wait: Wait
    clock: Clock
    due_ns: int | None = field(default=None, init=False)  # earliest start; None: the condition was not met yet

    def begin(self, level: bool, now_ns: int) -> None:
        """The wait is reached; a condition that holds already is met now."""
        if level == self.wait.value:
            self._met(now_ns)

    def step(self, now_ns: int, edges: Sequence[Edge]) -> bool:
        """edges: since the last cycle."""
        if self.due_ns is None:
            hit = next((e for e in edges if e.channel == self.wait.asked.wire and e.value == self.wait.value), None)
            if hit is not None:
                self._met(hit.stamp_ns)
        return self.due_ns is not None and now_ns >= self.due_ns

    def _met(self, stamp_ns: int) -> None:
        cycle = self.clock.cycle_ns
        seen = -(-stamp_ns // cycle) * cycle  # the board looks once a position-controller cycle
        delay = math.ceil(self.wait.max_time_s * 1e9 / cycle - ROUNDING) * cycle
        self.due_ns = seen + delay + (BETWEEN * self.clock.period_ns if self.wait.between else 0)


@dataclass(slots=True)
class StartOffs:
    """The waits of one program, in the order of its statements: which kinematic each of them holds.

    A wait belongs to the kinematic of the traverse block before it, not of the one behind: to change over, a dummy
    MOVE_REL is programmed first (L1621-1631).  default: kinematic of a program without a block so far; None: a pure
    input/output process, where the wait is refused (L1580-1582).
    """

    clock: Clock
    boards: Mapping[int, Board]
    default: int | None
    _before: int | None = field(init=False)
    _waits: dict[int, StartOff] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        self._before = self.default

    def wait_until(self, channel: int, value: bool, *, max_time_s: float = 0.0, between: bool = False, error_part: bool = False) -> int:
        """The statement; returns the kinematic it holds.  One high-speed input, no ERROR part (L1601-1619)."""
        asked = admitted(channel, self.boards)
        if asked.kind is not InputKind.HIGH_SPEED:
            raise ProgramFault(INADMISSABLE_INPUT, f"fast start-off needs a high-speed input 6xy, not channel {channel}")
        if error_part:
            raise MotionError("WAIT UNTIL for a fast start-off has no ERROR part")
        if not (math.isfinite(max_time_s) and max_time_s >= 0.0):
            raise MotionError(f"MAX_TIME {max_time_s} s: a number from 0 on is needed")
        if self._before is None:
            raise MotionError("WAIT UNTIL for a fast start-off in a process without a kinematic")
        self._waits[self._before] = StartOff(Wait(asked, value, max_time_s, between), self.clock)
        return self._before

    def block(self, kinematic: int) -> StartOff | None:
        """A traverse block of this kinematic; the wait that holds it, None: it starts as any other."""
        self._before = kinematic
        return self._waits.pop(kinematic, None)
