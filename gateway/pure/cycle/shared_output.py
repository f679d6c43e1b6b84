"""Several axes on one set-point output in the cycle: one frequency converter that moves one axis after the other.  Pure.

The rule is motion.axes.shared (rho 3 Releases part 1, section 17, L6461-6507); here it gets its axes once a cycle and writes the set
point and who has it into RC outputs (AX-549).
"""

from collections.abc import Sequence
from dataclasses import dataclass

from drivers.drives.family import Power
from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.image.records.cell import set_bit
from motion.axes.errors import AxisError
from motion.axes.shared import SharedOutput

FULL = 0x7FFF  # of the set point: the axis' speed limit


@dataclass(frozen=True, slots=True)
class SharedFacts:
    """[[shared_output]].  axes: places in the cell, from 0, in the order of their running numbers; rated: speed at full set point;
    gain: of the position loop, 1/s; output: RC output byte of the set point; select: RC output of the first axis, -1: none."""

    axes: tuple[int, ...]
    correction_s: tuple[float, ...]
    rated: tuple[float, ...]
    output: int
    select: int = -1
    gain: float = 16.7
    keep_last: bool = False


class CoreShared:
    """All such outputs of a cell."""

    def __init__(self, facts: Sequence[SharedFacts], period_s: float) -> None:
        self.facts = tuple(facts)
        self._outputs = [SharedOutput(each.axes, each.correction_s, each.keep_last) for each in facts]
        self._period, self._time = period_s, 0.0

    def step(self, axes: Sequence[HeldAxis], outputs: bytearray, *, jog: bool) -> int:
        """Call once a cycle; jog: no program runs.  Return the axis (from 1) that moved with another one of its output; 0: none."""
        self._time += self._period
        wrong = 0
        for facts, output in zip(self.facts, self._outputs, strict=True):
            try:
                volts = output.step(self._in_position(facts, axes), self._wanted(facts, axes), self._time, jog=jog)
            except AxisError as error:
                wrong, volts, output.active = wrong or error.axis, 0.0, None
            value = round(FULL * min(max(volts, -1.0), 1.0))
            outputs[facts.output : facts.output + 2] = (value & 0xFFFF).to_bytes(2, "big")
            for place, axis in enumerate(facts.axes if facts.select >= 0 else ()):
                set_bit(outputs, facts.select + place, output.active == axis)
        return wrong

    @staticmethod
    def _in_position(facts: SharedFacts, axes: Sequence[HeldAxis]) -> list[bool]:
        """(axes,) an axis that moves, or is not where it should be, is not; one without its drive moves nothing.  An axis that begins
        while the one before still settles is, as long as it is inside its window: an exact stop does not wait for the mechanics."""
        found, group = [True] * len(axes), [n for n in facts.axes if axes[n].power is Power.ENABLED]
        away = [n for n in group if axes[n].by_drive or abs(axes[n].set - axes[n].actual) > axes[n].plan.window]
        settling = any(axes[n].speed == 0.0 for n in away)
        for n in group:
            found[n] = n not in away and (settling or axes[n].speed == 0.0)
        return found

    @staticmethod
    def _wanted(facts: SharedFacts, axes: Sequence[HeldAxis]) -> list[float]:
        """(axes,) what each axis' position loop asks for, as a share of its full speed."""
        wanted = [0.0] * len(axes)
        for place, rated in zip(facts.axes, facts.rated, strict=True):
            axis = axes[place]
            wanted[place] = (axis.speed + facts.gain * axis.behind) / rated
        return wanted
