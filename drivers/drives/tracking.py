"""Does an axis stand where it should stand, and follow where it should follow?  647 and 648 of the old error list.

Source: robotstar 8.1 (L4696-4697): 647 tracking distance too long (axis cannot follow), 648 monitoring of standstill (axis left
standstill position).  How a standstill begins is ours (AX-268).
"""

from drivers.drives.limits import LagMonitor, LagState

TRACKING, STANDSTILL = 647, 648


class Tracking:
    """One axis; any unit, all the same one.  A finding stays until clear()."""

    def __init__(self, window: float, limit: float, settle_cycles: int) -> None:
        """`window`: how far a standing axis may be off; `limit`: largest lag of a moving one; both also catch what is no number.

        `settle_cycles`: so long after its set value came to rest an axis is still given the wider limit.
        """
        self._standing, self._moving = LagMonitor(window, window), LagMonitor(limit, limit)
        self._settle = settle_cycles
        self._still = 0  # cycles since the set value changed last
        self._last: float | None = None
        self.number = 0  # 647, 648, or 0

    def check(self, set_position: float, actual: float) -> int:
        """Once per cycle with the set position active at this SYNC; the number of the error list, 0: all is well."""
        self._still = self._still + 1 if set_position == self._last else 0
        self._last = set_position
        if not self.number:
            lag = set_position - actual
            if self._moving.check(lag) is LagState.TRIPPED:
                self.number = TRACKING if self._still < self._settle else STANDSTILL
            elif self._still >= self._settle and self._standing.check(lag) is LagState.TRIPPED:
                self.number = STANDSTILL
        return self.number

    def clear(self) -> None:
        """Not in control: nothing is supervised."""
        self._standing.clear()
        self._moving.clear()
        self._still, self._last, self.number = 0, None, 0
