"""Increments at the motor <-> m or rad at the axis.

inc = zero_inc + direction * gear * inc_per_turn * q / feed_per_turn.  `direction` is the sign of the measuring system (P401.7), `output`
that of the set-point output (P401.8); they belong together: with only one of them negative the axis never arrives (rho3 2.9), and
`axisgate check` refuses it.
"""

import math
from dataclasses import dataclass, field, replace


class ScalingError(ValueError):
    """Numbers no axis can have; the message names the field, its value and range."""


@dataclass(frozen=True, slots=True)
class Scaling:
    """One axis; raises ScalingError."""

    inc_per_turn: int = 16384  # at the motor
    gear: float = 1.0  # motor turns for one turn of the output
    feed_per_turn: float = 2 * math.pi  # m or rad of the axis for one turn of the output
    direction: int = 1  # +1, -1: axis positive = increments rising, falling
    zero_inc: float = 0.0  # increments where the axis reads 0; referencing finds it
    output: int = 0  # +1, -1: sign of the output; 0: as direction
    inc_per_unit: float = field(init=False, repr=False, compare=False)  # increments for one m or rad, signed
    sent_per_unit: float = field(init=False, repr=False, compare=False)  # as it is sent: the other way where the output is reversed
    rpm_per_unit: float = field(init=False, repr=False, compare=False)  # rpm of the motor for 1 m/s or rad/s, signed

    def __post_init__(self) -> None:
        for name, value in (("inc_per_turn", self.inc_per_turn), ("gear", self.gear), ("feed_per_turn", self.feed_per_turn)):
            if not (math.isfinite(value) and value > 0):
                raise ScalingError(f"{name} {value} is not a number above 0")
        if self.direction not in (1, -1):
            raise ScalingError(f"direction {self.direction} is neither 1 nor -1")
        if self.output not in (1, 0, -1):
            raise ScalingError(f"output {self.output} is neither 1 nor -1 nor 0 (as direction)")
        if not math.isfinite(self.zero_inc):
            raise ScalingError(f"zero_inc {self.zero_inc} is not a number")
        # Computed once: the cycle reads it several times per axis
        sent = self.output * self.direction or 1
        per_unit = self.direction * self.gear * self.inc_per_turn / self.feed_per_turn
        object.__setattr__(self, "inc_per_unit", per_unit)
        object.__setattr__(self, "sent_per_unit", per_unit * sent)
        object.__setattr__(self, "rpm_per_unit", 60.0 * self.direction * sent * self.gear / self.feed_per_turn)

    def to_inc(self, q: float) -> int:
        """m or rad -> the nearest increment; not limited to int32 (the Drive refuses values out of range)."""
        return round(self.zero_inc + q * self.sent_per_unit)

    def to_si(self, inc: float) -> float:
        """Increments -> m or rad."""
        return (inc - self.zero_inc) / self.inc_per_unit

    def to_rpm(self, speed: float) -> float:
        """m/s or rad/s of the axis -> rpm of the motor, signed."""
        return self.rpm_per_unit * speed

    def speed_from_inc(self, inc_per_s: float) -> float:
        """inc/s -> m/s or rad/s of the axis."""
        return inc_per_s / self.inc_per_unit

    def reach(self) -> tuple[float, float]:
        """Lowest and highest m or rad a telegram's int32 can name: travel limits must lie inside."""
        ends = (self.to_si(-(2**31)), self.to_si(2**31 - 1))
        return min(ends), max(ends)

    def with_zero(self, zero_inc: float) -> "Scaling":
        """The same axis after referencing."""
        return replace(self, zero_inc=zero_inc)
