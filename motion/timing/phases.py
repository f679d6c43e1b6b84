"""A change of omega in three phases (u grows, stays, comes back), where one bound of u and one of c hold all along its way.

On a line at steady speed, and on everything nearly as calm, this is the time optimum: nothing has to be foreseen place by place.
"""

from math import ceil, inf, sqrt
from typing import NamedTuple

SLACK = 1e-9  # relative: rounding does not count as exceeding a bound
LONGER = 4  # periods tried beyond the optimum, so that full periods fit


class Phase(NamedTuple):
    """So many periods with this c = d2 omega/dt2."""

    periods: int
    c: float


def shortest(left: float, u: float, most_u: float, most_c: float) -> tuple[float, float, float]:
    """Seconds of the three phases from u to 0 while omega changes by `left`, left > 0 in the sense of the middle phase."""
    peak = sqrt(max(most_c * left + 0.5 * u * u, 0.0))
    hold = 0.0
    if peak > most_u:
        peak = most_u
        hold = max((left - (2 * peak * peak - u * u) / (2 * most_c)) / peak, 0.0)
    return abs(peak - u) / most_c, hold, peak / most_c


def least_time(left: float, most_u: float, most_c: float) -> float:
    """Return the seconds of the entire change from a steady omega."""
    return sum(shortest(abs(left), 0.0, most_u, most_c)) if most_c > 0.0 and most_u > 0.0 else inf


def phases(left: float, u: float, most_u: float, most_c: float, h: float) -> list[Phase] | None:
    """Lead u to 0 in full periods of h while omega changes by `left`; None where these bounds do not suffice."""
    flip = 1.0 if left >= u * abs(u) / (2 * most_c) else -1.0
    left, u = flip * left, flip * u
    one, hold, two = (ceil(t / h - SLACK) for t in shortest(left, u, most_u, most_c))
    for more in range(LONGER):
        for first, middle, last in ((one, hold + more, two), (one + more, hold, two + more)):
            sum_ = 0.5 * (first + last) + middle
            if sum_ == 0.0:
                continue
            peak = (left / h - 0.5 * first * u) / sum_
            ups, downs = abs(peak - u), abs(peak)
            if downs <= most_u * (1 + SLACK) and ups <= most_c * h * first * (1 + SLACK) and downs <= most_c * h * last * (1 + SLACK):
                found = ((first, flip * (peak - u)), (middle, 0.0), (last, -flip * peak))
                return [Phase(count, step / (count * h)) for count, step in found if count]
    return None


def calmed(u: float, most_c: float, h: float) -> list[Phase]:
    """From u to 0 as fast as may be."""
    count = max(ceil(abs(u) / (most_c * h) - SLACK), 1)
    return [Phase(count, -u / (count * h))]


class Travel(NamedTuple):
    """Result of a row of phases: way made in tau, lowest and highest omega, omega at the end."""

    way: float
    lowest: float
    highest: float
    end: float


def travel(row: list[Phase], w: float, u: float, h: float) -> Travel:
    """From omega and u at the beginning."""
    way, low, high = 0.0, w, w
    for count, c in row:
        t = count * h
        if c != 0.0 and 0.0 < -u / c < t:
            turn = w - 0.5 * u * u / c
            low, high = min(low, turn), max(high, turn)
        way += t * (w + t * (0.5 * u + t * c / 6))
        w, u = w + t * (u + 0.5 * t * c), u + t * c
        low, high = min(low, w), max(high, w)
    return Travel(way, low, high, w)
