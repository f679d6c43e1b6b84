"""The way past the edge of a probe: straight on, without a ramp.  Source: rho 3 Releases part 2, section 3.2 (L6766-6768)."""

from dataclasses import dataclass
from math import hypot


@dataclass(slots=True)
class RunOn:
    """The rest of a modified MOVE UNTIL: straight to the target at the speed of the edge, no ramp at either end (L6768).

    The acceleration limit is not kept here, as the manual wants it; the speed is the block's, which is within its limits.
    """

    q: list[float]
    target: list[float]
    step_length: float  # m or rad a cycle; 0: standstill
    override: float = 1.0  # 0 .. 1, at which the speed of the edge was driven

    @property
    def arrived(self) -> bool:
        """Whether the last set values are the target."""
        return self.q == self.target

    def step(self, share: float = 1.0) -> tuple[float, ...]:
        """Set values of the next cycle; share: of the speed, 0 .. 1."""
        left = [b - a for a, b in zip(self.q, self.target, strict=True)]
        length, step = hypot(*left), self.step_length * share
        if length <= step * (1 + 1e-9) or self.step_length == 0.0:
            self.q = list(self.target)
        else:
            self.q = [a + way * step / length for a, way in zip(self.q, left, strict=True)]
        return tuple(self.q)
