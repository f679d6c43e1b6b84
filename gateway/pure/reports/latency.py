"""Verdict on measured times: the shortest cycle that they are good for."""

from collections.abc import Sequence
from dataclasses import dataclass

CLOCKS_MS = (2, 4, 8, 16, 32)  # P5 is 2 to 32 ms


@dataclass(frozen=True, slots=True)
class Measured:
    """Times in ms of one measurement; `share`: the part of a cycle that they may use."""

    what: str
    ordered_ms: Sequence[float]  # ascending, not empty
    share: float = 1.0

    def percentile(self, part: float) -> float:
        """The time that `part` (0 to 1) of all times do not exceed; nearest rank."""
        rank = -(-round(part * 1_000_000) * len(self.ordered_ms) // 1_000_000)  # rounded up
        return self.ordered_ms[max(rank, 1) - 1]

    def figures(self) -> dict[str, float]:
        """Count, percentiles and maximum, rounded to 1 us."""
        names = (("p50", 0.5), ("p99", 0.99), ("p99.9", 0.999), ("max", 1.0))
        return {"count": float(len(self.ordered_ms)), **{name: round(self.percentile(part), 3) for name, part in names}}

    def clock(self) -> int | None:
        """Shortest cycle in ms that it is good for; None: not even the longest."""
        worst = self.percentile(0.999)
        return next((clock for clock in CLOCKS_MS if worst < clock * self.share), None)


@dataclass(frozen=True, slots=True)
class Verdict:
    """`good`: shortest cycle in ms that all measurements are good for; None: none."""

    good: int | None
    words: str


def verdict(measured: Sequence[Measured]) -> Verdict:
    """The worst measurement decides and is named.  Raises ValueError if nothing was measured."""
    if not measured:
        raise ValueError("nothing was measured")
    longest = CLOCKS_MS[-1] + 1
    worst = max(measured, key=lambda each: (each.clock() or longest, each.percentile(0.999) / each.share))
    good, why = worst.clock(), f"{worst.what} p99.9 = {worst.percentile(0.999):.1f} ms"
    if good is None:
        return Verdict(None, f"not good for {CLOCKS_MS[-1]} ms: {why}")
    shorter = [clock for clock in CLOCKS_MS if clock < good]
    return Verdict(good, f"good for {good} ms" + (f", not for {shorter[-1]} ms" if shorter else "") + f": {why}")
