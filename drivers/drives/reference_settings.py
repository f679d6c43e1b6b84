"""Settings of referencing by the gateway, at the motor; modes as drivers.drives.referencing describes them."""

import math
from dataclasses import dataclass

from drivers.drives.scaling import Scaling, ScalingError

MODES = range(4)

ORIENTED, STOPPING = (1, 3), (2, 3)  # the zero out of the gear factor; the axis stops where it is


@dataclass(frozen=True, slots=True)
class ReferenceSettings:
    """At the motor, in increments; raises ScalingError."""

    inc_per_turn: int
    direction: int  # +1, -1: side on which the switch is, in increments
    speed_inc_s: float  # towards the switch (P108)
    slow_inc_s: float  # from the switch to the zero (P109)
    accel_inc_s2: float
    jerk_inc_s3: float
    position_inc: float = 0.0  # P207 as increments, signed by the axis' direction
    offset_inc: float = 0.0  # P208, the same
    way_inc: float = math.inf  # longest way from the start
    timeout_s: float = 60.0
    mode: int = 0  # 0..3
    gear: float = 1.0  # gear factor with decimals (modes 1 and 3)

    def __post_init__(self) -> None:
        for name in ("inc_per_turn", "speed_inc_s", "slow_inc_s", "accel_inc_s2", "jerk_inc_s3", "way_inc", "timeout_s", "gear"):
            value: float = getattr(self, name)
            if not value > 0:
                raise ScalingError(f"referencing: {name} {value} is not a number above 0")
        if self.direction not in (1, -1):
            raise ScalingError(f"referencing: direction {self.direction} is neither 1 nor -1")
        if self.mode not in MODES:
            raise ScalingError(f"referencing: mode {self.mode} is outside 0..3")

    @property
    def seek_inc_s(self) -> float:
        """Speed towards the switch: P108; if the switch stops the axis P109, from which it must come to rest before the limit (L3857)."""
        return self.slow_inc_s if self.mode in STOPPING else self.speed_inc_s


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceMove:
    """As its axis states it, in m or rad; direction: +1, -1 of the axis, on which side the switch is."""

    direction: int
    speed: float
    slow_speed: float
    accel: float
    jerk: float
    position: float = 0.0
    offset: float = 0.0
    way: float = math.inf
    timeout_s: float = 60.0
    mode: int = 0

    def at_motor(self, scaling: Scaling) -> ReferenceSettings:
        """In increments; raises ScalingError."""
        factor = abs(scaling.inc_per_unit)
        return ReferenceSettings(
            inc_per_turn=scaling.inc_per_turn,
            direction=self.direction * scaling.direction,
            speed_inc_s=self.speed * factor,
            slow_inc_s=self.slow_speed * factor,
            accel_inc_s2=self.accel * factor,
            jerk_inc_s3=self.jerk * factor,
            position_inc=self.position * scaling.inc_per_unit,
            offset_inc=self.offset * scaling.inc_per_unit,
            way_inc=self.way * factor,
            timeout_s=self.timeout_s,
            mode=self.mode,
            gear=scaling.gear,
        )
