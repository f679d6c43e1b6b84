"""Limited change of override per cycle: RDELTA_OV_MAX of the Reis (L1971-1977), 0 < x <= 1.0, default 0.1.

The set values keep their limits without it (motion.execution.follower); it reproduces the slower response of the old controller.
"""

from motion.errors import MotionError

DEFAULT = 0.1


class OverrideRamp:
    """The override passed to the stepper in each cycle on the way to a new one."""

    def __init__(self, most: float = DEFAULT, value: float = 0.0) -> None:
        if not 0.0 < most <= 1.0:
            raise MotionError(f"RDELTA_OV_MAX {most:.6g} is outside 0 .. 1 (0 itself not allowed)")
        self._most, self.value = most, value

    def step(self, wanted: float) -> float:
        """One cycle towards `wanted` (0 .. 1)."""
        if wanted == self.value:  # as in most cycles
            return wanted
        if not 0.0 <= wanted <= 1.0:
            raise MotionError(f"override {wanted} is outside 0 .. 1")
        change = wanted - self.value
        self.value = wanted if abs(change) <= self._most * (1 + 1e-9) else self.value + (self._most if change > 0 else -self._most)
        return self.value
