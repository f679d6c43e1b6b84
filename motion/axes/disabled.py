"""Disabled axes: taken out for service until the control starts anew.

Source: rho 3 Releases part 1, section 11 (L7918-7945): RC inputs 216..235 = 1 take effect at once and stay until a start-up with
0; no monitoring, set-point output 0 V, no referencing; moving such an axis is "drive on not available"; warning 1408..1427.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from motion.axes.errors import DRIVE_ON_NOT_AVAILABLE, AxisError
from motion.axes.interruptible import MOVES
from motion.errors import MotionError

FIRST_INPUT = 216  # RC input of axis 1
FIRST_WARNING = 1408  # code of axis 1
MOST = 20


@dataclass(slots=True)
class DisabledAxes:
    """All axes of the control, numbered from 0; only a start-up creates it anew."""

    axes: int
    _disabled: list[bool] = field(init=False)

    def __post_init__(self) -> None:
        if not 1 <= self.axes <= MOST:
            raise MotionError(f"{self.axes} axes: 1 .. {MOST} can be disabled by RC inputs")
        self._disabled = [False] * self.axes

    def update(self, inputs: Sequence[bool]) -> tuple[int, ...]:
        """inputs: RC inputs 216.. of the axes; a 1 acts at once, a 0 is ignored.  Return the new warnings: 1408 + axis."""
        fresh = [n for n, signal in enumerate(inputs) if signal and not self._disabled[n]]
        for n in fresh:
            self._disabled[n] = True
        return tuple(FIRST_WARNING + n for n in fresh)

    @property
    def disabled(self) -> tuple[bool, ...]:
        """(axes,): out of the loop, not monitored, nothing to reference."""
        return tuple(self._disabled)

    @property
    def warnings(self) -> tuple[int, ...]:
        """Standing warnings "Axis disabled", as mode 7.2 shows them."""
        return tuple(FIRST_WARNING + n for n, out in enumerate(self._disabled) if out)

    def outputs(self, volts: Sequence[float]) -> tuple[float, ...]:
        """Set-point outputs: 0 V for disabled axes."""
        return tuple(0.0 if out else value for value, out in zip(volts, self._disabled, strict=True))

    def check_move(self, start: Sequence[float], *way: Sequence[float]) -> None:
        """Raises AxisError for the first disabled axis that would move."""
        for n, out in enumerate(self._disabled):
            if out and any(abs(point[n] - start[n]) > MOVES for point in way):
                raise AxisError(DRIVE_ON_NOT_AVAILABLE, n + 1, "disabled until a start-up with its RC input 0", FIRST_WARNING + n)
