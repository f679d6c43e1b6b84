"""Monitors standstill and following error of an axis: 647 and 648 of the old error list.

Source: robotstar 8.1 (L4696-4697): 647 tracking distance too long (axis cannot follow), 648 monitoring of standstill (axis left
standstill position).  How a standstill begins: AX-268.
"""

import math
from collections.abc import Mapping

from drivers.drives.limits import LagMonitor, LagState

TRACKING, STANDSTILL = 647, 648
WORDS: Mapping[int, tuple[str, str]] = {  # English, German
    TRACKING: ("tracking distance too long", "Schleppabstand zu gross"),
    STANDSTILL: ("axis left its standstill position", "Achse hat die Stillstandsposition verlassen"),
}


class Tracking:
    """One axis, all values in the same unit.  A finding stays until clear()."""

    __slots__ = ("_last", "_settle", "_standstill", "_still", "lag", "number")

    def __init__(self, standstill: float = math.inf, warn: float = math.inf, trip: float = math.inf, settle_cycles: int = 0) -> None:
        """`standstill`: largest deviation at standstill; `warn`, `trip`: lag while moving.  NaN exceeds every limit.

        `settle_cycles`: cycles after the set value came to rest in which the wider limit still applies.
        """
        self.lag = LagMonitor(warn, trip)
        self._standstill, self._settle = standstill, settle_cycles
        self._still = 0  # cycles since the set value changed last
        self._last: float | None = None
        self.number = 0  # 647, 648, or 0

    def check(self, set_position: float, behind: float) -> int:
        """Once per cycle: the set position active at this SYNC and its distance from the axis; the error's number, 0: all is well."""
        if set_position == self._last:
            self._still += 1
        else:
            self._still, self._last = 0, set_position
        if not self.number:
            if self.lag.check(behind) is LagState.TRIPPED:
                self.number = TRACKING if self._still < self._settle else STANDSTILL
            elif self._still >= self._settle and not abs(behind) <= self._standstill:
                self.number = STANDSTILL
        return self.number

    def clear(self) -> None:
        """Not in control: nothing is supervised."""
        self.lag.clear()
        self._still, self._last, self.number = 0, None, 0


def sentence(number: int, language: str = "en") -> str:
    """ "647 tracking distance too long"."""
    return f"{number} {WORDS[number][1 if language == 'de' else 0]}"
