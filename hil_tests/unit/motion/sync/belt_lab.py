"""A belt with an encoder of 0.1 mm, driven in virtual time."""

from collections.abc import Callable

from motion.sync.belts import BeltData, Belts
from motion.sync.errors import BeltError

CYCLE = 0.01
MM = 1e-3


class Conveyor:
    """One or more belts; speeds in mm/s."""

    def __init__(self, count: int = 1, cycle_s: float = CYCLE, period_s: float | None = None, increment: float = 1e-4) -> None:
        self.belts = Belts([BeltData(increment, simulated=250.0)] * count, period_s or cycle_s, cycle_s)
        self.period, self.increment = period_s or cycle_s, increment
        self.ways = [0.0] * count
        self.belts.update(self.counts())

    def counts(self) -> list[int]:
        return [round(way / self.increment) for way in self.ways]

    def run(self, *speeds: float, periods: int = 1, each: Callable[[], object] = lambda: None) -> None:
        for _ in range(periods):
            for n, speed in enumerate(speeds):
                self.ways[n] += speed * MM * self.period
            self.belts.update(self.counts())
            each()

    def counter(self, number: int = 1) -> float:
        """mm."""
        return self.belts.belt(number).counter / MM


def code(action: Callable[[], object]) -> int:
    """Number of the BeltError, 0 without one."""
    try:
        action()
    except BeltError as error:
        return error.code
    return 0
