"""How much of a leg a range covers."""

from collections.abc import Callable, Sequence

from motion.planner.block_paths import Leg


def axis_range(leg: Leg, ranges: Sequence[float]) -> float:
    """s at which the first moving axis comes within its range of the point (P213 x R_PTP)."""
    shares = [abs(b - a) / leg.length for a, b in zip(leg.start, leg.end, strict=True)]
    return min((r / u for r, u in zip(ranges, shares, strict=False) if u > 0.0), default=0.0)


def first_at(away: Callable[[float], float], distance: float, length: float) -> float:
    """The smallest s with away(s) >= distance; length where there is none."""
    count = 32
    before = 0.0
    for k in range(1, count + 1):
        s = length * k / count
        if away(s) >= distance:
            low, high = before, s
            for _ in range(50):
                middle = 0.5 * (low + high)
                low, high = (low, middle) if away(middle) >= distance else (middle, high)
            return high
        before = s
    return length
