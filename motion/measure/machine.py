"""Set machine position: SF 3 MACH_POS assigns new joint positions to the resting axes, like referencing.

Source: rho 3 Releases part 1, section 11 (L4119-4208).  @POS is new at once; POS (and what else the interpolator holds) with the next
MOVE block of the kinematic, a dummy MOVE_REL (0, ..) being enough; @MPOS is new too; belt values in the point are ignored.  Until set
again, referenced (P207) or started anew; Control reset changes nothing.  The travel limits belong to the new positions.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from motion.errors import MotionError
from motion.geometry.limits import AxisLimits
from motion.geometry.units import from_si, to_si


@dataclass(slots=True)
class MachinePosition:
    """Machine position of one kinematic: the axes of its joint point, then its belts.  Only a start-up creates it anew.

    measured: (axes,) m or rad, the values of the measuring systems.  Joint points: mm and deg.
    """

    limits: tuple[AxisLimits, ...]
    belts: int = 0
    _offset: list[float] = field(init=False)  # machine position - measured position
    _accepted: list[float] = field(init=False)  # the same as of the last MOVE block

    def __post_init__(self) -> None:
        self._offset = [0.0] * len(self.limits)
        self._accepted = list(self._offset)

    def mach_pos(self, point: Sequence[float], measured: Sequence[float], *, at_rest: bool = True) -> None:
        """SF 3.  Refused on the way: the set values would jump (AX-463)."""
        if not at_rest:
            raise MotionError("MACH_POS: the axes must be at rest")
        axes = len(self.limits)
        if len(point) not in (axes, axes + self.belts):
            raise MotionError(f"MACH_POS: {len(point)} components for {axes} axes and {self.belts} belts")
        self._checked(measured)
        if not all(map(math.isfinite, point[:axes])):
            raise MotionError(f"MACH_POS: {tuple(point)} are not all numbers")
        self._offset = [to_si(value, axis.unit) - now for value, axis, now in zip(point, self.limits, measured, strict=False)]

    def block(self) -> None:
        """Hand the positions to the interpolator: a MOVE block of this kinematic begins."""
        self._accepted = list(self._offset)

    def referenced(self, axis: int) -> None:
        """The axis (from 0) was referenced anew: P207 counts again."""
        self._offset[axis] = self._accepted[axis] = 0.0

    def machine(self, measured: Sequence[float]) -> tuple[float, ...]:
        """Machine positions in m or rad, of @POS, @MPOS and for the limit switches."""
        return tuple(value + offset for value, offset in zip(self._checked(measured), self._offset, strict=True))

    def joints(self, measured: Sequence[float]) -> tuple[float, ...]:
        """@POS, or @MPOS of a measurement: mm and deg."""
        return tuple(from_si(value, axis.unit) for value, axis in zip(self.machine(measured), self.limits, strict=True))

    def taken_over(self, measured: Sequence[float]) -> tuple[float, ...]:
        """Joint positions, mm and deg, from which POS is reckoned: old ones until a MOVE block came (L4150-4152)."""
        pairs = zip(self._checked(measured), self._accepted, self.limits, strict=True)
        return tuple(from_si(value + offset, axis.unit) for value, offset, axis in pairs)

    def commanded(self, machine: Sequence[float]) -> tuple[float, ...]:
        """Machine positions (m or rad) as the measuring systems, and so the drives, count them."""
        return tuple(value - offset for value, offset in zip(self._checked(machine), self._offset, strict=True))

    def _checked(self, values: Sequence[float]) -> Sequence[float]:
        if len(values) != len(self.limits) or not all(map(math.isfinite, values)):
            raise MotionError(f"{len(self.limits)} axes, positions {tuple(values)}")
        return values


def reference_speed_warning(p108: float, p109: float) -> str:
    """Empty, or why SF 3 together with referencing is dangerous: P108 must equal P109 (L4204-4208)."""
    if p108 == p109:
        return ""
    return f"SF 3 and referencing: P108 = {p108:g} and P109 = {p109:g} must be the same, else the switch is met too fast"
