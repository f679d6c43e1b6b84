"""Limits: range of a set value, permitted lag, and the booster's own software limits."""

import math
from enum import Enum, auto

INT16_MAX = 2**15 - 1
INT32_MIN, INT32_MAX = -(2**31), 2**31 - 1
RELEASE = 0.9  # share of the warning limit below which the warning goes


def fits_int32(inc: int) -> bool:
    """Whether a position fits into four bytes; beyond it would wrap round and the axis would turn about."""
    return INT32_MIN <= inc <= INT32_MAX


def saturated_rpm(speed_rpm: float) -> int:
    """Nearest int16, symmetric; 0 for NaN and infinity."""
    return min(max(round(speed_rpm), -INT16_MAX), INT16_MAX) if math.isfinite(speed_rpm) else 0


class LagState(Enum):
    """Result of the last check."""

    OK = auto()
    WARNING = auto()
    TRIPPED = auto()


class LagMonitor:
    """Following error of one axis against warn and trip, all in the same unit.  A trip stays until clear()."""

    __slots__ = ("_trip", "_warn", "state", "worst")

    def __init__(self, warn: float, trip: float) -> None:
        self._warn, self._trip = warn, trip
        self.state = LagState.OK
        self.worst = 0.0  # largest |lag| since clear()

    def check(self, lag: float) -> LagState:
        """lag = set position active at this SYNC - position latched at this SYNC."""
        size = abs(lag)
        if size > self.worst:
            self.worst = size
        if self.state is LagState.OK and size <= self._warn and size <= self._trip:  # nearly always
            return LagState.OK
        warned = self.state is LagState.WARNING and size > self._warn * RELEASE
        if self.state is LagState.TRIPPED or not size <= self._trip:  # NaN trips
            self.state = LagState.TRIPPED
        else:
            self.state = LagState.WARNING if warned or size > self._warn else LagState.OK
        return self.state

    def clear(self) -> None:
        """Not in control: nothing is supervised, a trip is forgotten."""
        self.state, self.worst = LagState.OK, 0.0


def booster_limits(
    lower_deg: float, upper_deg: float, reference_deg: float, offset_deg: float, gear: float, zero_offset_deg: float, inc_per_turn: int
) -> tuple[float, float]:
    """(n_RMC_L, p_RMC_L) in inc for ENABLE LIMIT SWITCH, both magnitudes from the resolver zero.

    P205, P204, P207, P208, gear factor, RMC zero offset, CPS.  Source: rho3 2.7 (L3724-3731); the lower end goes in as a
    magnitude (D-17), negative where it lies above 0.
    """
    at_end = reference_deg + offset_deg  # Ref_Pkt_pos: where the axis reads after referencing
    upper = ((upper_deg - at_end) * gear + zero_offset_deg) * inc_per_turn / 360
    lower = ((lower_deg + at_end) * gear - zero_offset_deg) * inc_per_turn / 360
    return lower, upper
