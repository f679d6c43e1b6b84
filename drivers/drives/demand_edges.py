"""Edges of a demand.  A drive is switched on and its fault is reset by an edge, never by a level that was there before (design 1)."""

from drivers.drives.family import Demand

RESET_CYCLES = 5  # cycles the reset bit is set for one edge of the demand: one lost telegram does not hide it


class DemandEdges:
    """`asked`: an edge of `on` that the drive has not answered yet; `reset_left`: cycles in which the reset bit is still sent."""

    __slots__ = ("asked", "on_before", "reset_before", "reset_left")

    def __init__(self) -> None:
        self.on_before = self.reset_before = True
        self.asked = False
        self.reset_left = 0

    def note(self, demand: Demand, *, fault: bool, lost: bool) -> None:
        """Once a cycle; a drive in fault or lost takes no edge of `on`, and only one in fault takes a reset."""
        rising = demand.on and not self.on_before
        self.on_before = demand.on
        self.asked = demand.on and (self.asked or rising) and not (fault or lost)
        if demand.reset and not self.reset_before and fault:
            self.reset_left = RESET_CYCLES + 1
        self.reset_before = demand.reset
        self.reset_left = max(self.reset_left - 1, 0)
