"""The last look at a set value while speed changes: differences of the set values themselves, as a judge at the drive sees them.

The plan of a change (motion.timing.change) knows the path at places some part of a period apart; where jerks switch in between, the
third difference of the set values may come out higher than planned.  A set value is q(tau), and tau may still be moved: by h^3 * c it
moves third differences by c q' and second ones by h c q'.  So the bounds of all axes leave a range of c, in closed form.
"""

from collections.abc import Sequence

ACCEL_MOST, JERK_MOST = 1.018, 1.09  # shares of the limits that the set values may reach
LEVELS = (1.0, 1.004, 1.008, 1.02, 1.05, 1.1, 1.2, 1.4, 1.8, 2.5)  # of these shares: where no c serves all axes, the lowest level that does
LASTING = 6.0  # times h omega q'' is the share of c that stays: two periods of it
LEAST = 1e-9  # share of a limit per unit of c: below it c does not affect an axis

Row = tuple[float, float, float, float, float, float, float]


def correction(rows: Sequence[Row], omega: float, u: float, period_s: float) -> float:
    """What to add to c.  Rows: new position, slope q', the three positions before it (last one first), acceleration and jerk limit.

    What c adds to u an axis bears in every period from then on, times 3 omega q'': where that is more than what its jerk gains now, it
    asks for nothing.  omega^2 q'' is its acceleration without the share of u.
    """
    h, h3 = period_s, period_s**3
    thirds, seconds = JERK_MOST * h3, ACCEL_MOST * h * h
    for q, _, one, two, three, accel, jerk in rows:
        if abs(q - 3.0 * (one - two) - three) > thirds * jerk or abs(q - 2.0 * one + two) > seconds * accel:
            break
    else:
        return 0.0
    shares: list[tuple[float, float]] = []
    for q, slope, one, two, three, accel, jerk in rows:
        most_j, most_a = jerk * JERK_MOST, accel * ACCEL_MOST
        third, bend = (q - 3.0 * (one - two) - three) / (h3 * most_j), (q - 2.0 * one + two) / (h * h)
        gains = (slope * omega * omega + LASTING * h * omega * (bend - u * slope)) * slope >= 0.0
        shares += ((third, slope / most_j if gains else 0.0), (bend / most_a, h * slope / most_a))
    return _nearest(shares)


def _nearest(shares: list[tuple[float, float]]) -> float:
    """The c closest to 0 with which every share + c * its slope lies within the lowest level possible."""
    for level in LEVELS:
        low, high = -1e15, 1e15
        for share, slope in shares:
            if abs(slope) > LEAST:
                one, two = (-level - share) / slope, (level - share) / slope
                low, high = (max(low, one), min(high, two)) if slope > 0.0 else (max(low, two), min(high, one))
        if low <= high:
            return min(max(0.0, low), high)
    return 0.0
