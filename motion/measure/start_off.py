"""Fast, smooth start-off: WAIT UNTIL on a high-speed input directly before a movement.

Source: rho 3 Releases part 1, section 4 (L1574-1655); TO04, section 2 (L4740-4768); TO05, section 15 (L8196-8215).  The wait is a block
of a kinematic, so block preparation goes on.  The movement starts one position-controller cycle after the condition plus at
most one interpolation cycle; statements in between cost two interpolation cycles more; MAX_TIME is a wanted delay.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from motion.errors import MotionError
from motion.measure.inputs import Edge, MeasuringInput

BETWEEN = 2  # additional P5 cycles when other statements are between the wait and the movement (TO04)
ROUNDING = 1e-6  # of a position-controller cycle: makes 0.15 s exactly 150 cycles of 1 ms despite rounding


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
