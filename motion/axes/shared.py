"""Several axes on one set-point output (one frequency converter for all).

Source: rho 3 Releases part 1, section 17 (L6461-6507): P401 sub-query 6 = hundreds: output, ones: running number from 1 (101, 102,
103); only one axis moves at a time, else servo error; 0 V while the axis is in its INPOS range; the loop stays closed for the
correction time of P201 after INPOS; jog option 1: the last jogged axis keeps the output until another one is moved.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from motion.axes.errors import SERVO_ERROR, AxisError
from motion.errors import MotionError


def groups(p401: Mapping[int, int]) -> dict[int, tuple[int, ...]]:
    """P401 sub-query 6 of each axis (from 0) -> {output: axes in the order of their running numbers}; outputs of one axis left out.

    Raises MotionError when the running numbers of an output are not 1, 2, 3 .. without a gap.
    """
    found: dict[int, dict[int, int]] = {}
    for axis, entry in p401.items():
        if entry < 100:
            continue  # an output of its own
        output, running = divmod(entry, 100)
        if running in found.setdefault(output, {}):
            raise MotionError(f"P401: running number {running} of set-point output {output} is given twice (axis {axis + 1})")
        found[output][running] = axis
    for output, places in found.items():
        if sorted(places) != list(range(1, len(places) + 1)):
            raise MotionError(f"P401: set-point output {output} has the running numbers {sorted(places)}; 1 .. {len(places)} are needed")
    return {output: tuple(axis for _, axis in sorted(places.items())) for output, places in found.items()}


@dataclass(slots=True)
class SharedOutput:
    """One output.  `step` once a cycle.  correction: P201 of each axis, s; keep_last: jog option 1."""

    axes: tuple[int, ...]
    correction: tuple[float, ...]
    keep_last: bool = False
    active: int | None = None  # axis whose set value is at the output
    _in_position_since: float | None = field(default=None)

    def step(self, in_position: Sequence[bool], volts: Sequence[float], now_s: float, *, jog: bool = False) -> float:
        """The voltage of the output; in_position and volts: (all axes of the control,).

        Raises AxisError servo error when a second axis leaves its INPOS range while another one has the output.
        """
        leaving = [axis for axis in self.axes if not in_position[axis]]
        if len(leaving) > 1:
            raise AxisError(SERVO_ERROR, leaving[1] + 1, f"axis {leaving[0] + 1} has the set-point output")
        if leaving:
            self.active, self._in_position_since = leaving[0], None
            return volts[leaving[0]]
        if self.active is None:
            return 0.0
        if jog and self.keep_last:
            return volts[self.active]
        if self._in_position_since is None:
            self._in_position_since = now_s
        if now_s - self._in_position_since < self.correction[self.axes.index(self.active)]:
            return volts[self.active]
        self.active = None
        return 0.0
