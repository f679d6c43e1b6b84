"""A cell in virtual time with measuring inputs that change between two SYNCs, and where axis 1 was at each of them."""

from collections.abc import Callable

import numpy as np

from gateway.pure.image.records.planner import MeasuringFacts
from hil_tests.lab.virtual.program_bench import LIMITS, WithPlanner

PROBE, FAST = 300, 301  # RC inputs of both channels
ON_ALL, ON_TWO = (1 << len(LIMITS)) - 1, 0b11
CHANNELS = {610: MeasuringFacts(PROBE, ON_ALL), 611: MeasuringFacts(FAST, ON_ALL), 620: MeasuringFacts(PROBE, ON_TWO)}
CLOSE = 2e-6  # m or rad: cubic between cycles against the finer curve through them


class Probing(WithPlanner):
    """Beside it: where axis 1 was at every SYNC, and an input that changes between two of them."""

    def __init__(self) -> None:
        super().__init__()
        self.programs.cell.channels = CHANNELS
        self.seen: list[tuple[int, float]] = []
        self.cell.permit(PROBE, FAST, value=False)
        each: Callable[[], None] = self.cell.each

        def look() -> None:
            state = self.cell.core.state
            self.seen.append((state.sync_ns, state.axes[0].actual))
            each()

        self.cell.each = look

    def edge_at(self, place: float, number: int = PROBE, *, ago: float = 0.0) -> int:
        """Once axis 1 is beyond `place` the input becomes 1, so long (in cycles) before the cycle that sees it; its stamp."""
        for _ in range(3000):
            self.cell.cycle()
            if self.places()[0] > place:
                break
        return self.change(number, ago=ago)

    def change(self, number: int, *, value: bool = True, ago: float = 0.0) -> int:
        stamp = self.cell.now - round(ago * self.cell.period_ns)
        self.cell.permit(number, value=value)
        self.cell.inputs.stamps[number >> 3] = stamp
        return stamp

    def was(self, stamp: int) -> float:
        """Axis 1 at an instant, from all SYNCs around."""
        near = [(t, q) for t, q in self.seen if abs(t - stamp) < 6 * self.cell.period_ns]
        times = np.array([t - stamp for t, _ in near]) * 1e-9
        return float(np.polynomial.Polynomial.fit(times, np.array([q for _, q in near]), 5)(0.0))

    @property
    def measured(self) -> float:
        state = self.cell.core.state
        assert state.measured_mask & 1, "nothing is measured"
        return state.axes[0].measured
