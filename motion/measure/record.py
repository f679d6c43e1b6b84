"""Reference path recording: where a kinematic was at its last 50 marks.  SF 29 on, SF 30 off, SF 31 read.

Source: rho 3 Releases part 1 (TO05), section 9 (L5185-5460).  A mark is each DISTANCE (mm or deg) of a measuring system, or with option
byte 1 a number of interpolation cycles.  Joint and world points are kept, belts included.  Index 1 is the latest (L5386, AX-464).
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from motion.errors import MotionError
from motion.measure.errors import BAD_MEASURING_SYSTEM, POINT_INVALID, ProgramFault

ENTRIES = 50
BY_DISTANCE, BY_CYCLES = 0, 1  # option byte
ROUNDING = 1e-9  # mm or deg


class Entry(NamedTuple):
    """One mark: mm and deg, axes first, then belts."""

    joints: tuple[float, ...]
    world: tuple[float, ...]


@dataclass(slots=True)
class _Tape:
    system: int
    distance: float
    entries: deque[Entry] = field(default_factory=lambda: deque(maxlen=ENTRIES))
    running: bool = True
    mark: float | None = None  # of the measuring system, or cycles since the last entry


@dataclass(slots=True)
class ReferencePaths:
    """Of one control.  systems: number of measuring systems (1..); option: the option byte (0 or 1)."""

    systems: int
    option: int = BY_DISTANCE
    _tapes: dict[int, _Tape] = field(default_factory=dict, init=False)

    def on(self, kinematic: int, system: int, distance: float) -> None:
        """SF 29: earlier entries of this kinematic are dropped.  The measuring system must exist even where cycles count."""
        if not 1 <= system <= self.systems:
            raise ProgramFault(BAD_MEASURING_SYSTEM, f"{system}: 1 .. {self.systems} exist", 91)
        if not (math.isfinite(distance) and distance > 0.0):
            raise MotionError(f"PKT_SPEI_EIN: DISTANCE {distance} is not a number above 0")
        if self.option == BY_CYCLES and round(distance) < 1:
            raise MotionError(f"PKT_SPEI_EIN: {distance} interpolation cycles, 1 is the least")
        self._tapes[kinematic] = _Tape(system, distance)

    def step(self, kinematic: int, measured: Sequence[float], joints: Sequence[float], world: Sequence[float]) -> None:
        """Once an interpolation cycle.  measured: of the measuring systems 1.., mm or deg; joints, world: set points with belts."""
        tape = self._tapes.get(kinematic)
        if tape is None or not tape.running:
            return
        if self.option == BY_CYCLES:
            tape.mark = 0.0 if tape.mark is None else tape.mark + 1.0
            if tape.mark < round(tape.distance):
                return
            tape.mark = 0.0
        else:
            here = measured[tape.system - 1]
            if tape.mark is None:
                tape.mark = here
            gone = here - tape.mark
            marks = math.floor((abs(gone) + ROUNDING) / tape.distance)
            if marks < 1:
                return
            tape.mark += math.copysign(marks * tape.distance, gone)  # the grid stays, whatever a cycle overshoots it by
        tape.entries.appendleft(Entry(tuple(joints), tuple(world)))

    def off(self, kinematic: int) -> int:
        """SF 30: number of entries, 50 at most; they stay until the next SF 29."""
        tape = self._tapes.get(kinematic)
        if tape is None:
            return 0
        tape.running = False
        return len(tape.entries)

    def read(self, kinematic: int, index: int) -> Entry:
        """SF 31: entry 1.. counted from the latest; code 90 where none is stored."""
        tape = self._tapes.get(kinematic)
        stored = len(tape.entries) if tape else 0
        if tape is None or not 1 <= index <= stored:
            raise ProgramFault(POINT_INVALID, f"entry {index} of kinematic {kinematic}: {stored} are stored", 90)
        return tape.entries[index - 1]
