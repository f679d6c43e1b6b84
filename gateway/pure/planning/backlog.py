"""What waits in the ring between planner and cycle.  Pure."""

from dataclasses import dataclass


@dataclass(slots=True)
class Backlog:
    """All lanes share the ring.  handed: records since the planner began; waiting: of them, those that the cycle has not taken."""

    handed: int = 0
    waiting: int = 0

    def add(self, count: int) -> int:
        """So many are handed on; number of the last one."""
        self.handed += count
        self.waiting += count
        return self.handed

    @property
    def reached(self) -> int:
        """Number of the record that the cycle took last."""
        return self.handed - self.waiting
