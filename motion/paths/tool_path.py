"""Way and turning of the tool as columns of a path: quintics whose slopes are |p'| and |w| to TRUE, for limits of the tool act on them.

Their values are the integrals of the slopes (Gauss, 5 points), so marks and times find the true way in them.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

from motion.paths.base import Derivatives, dot, norm
from motion.paths.corner import hermite
from motion.paths.polynomial import Row, value

TRUE = 2e-4  # of a slope (AX-380)
LOW = 0.05  # of the largest slope nearby: a smaller one is met to TRUE of this
NOISE = 1e-9
FINEST = 1 / 256  # of the curve: shorter parts stay as they are; only where the tool turns back are they ever asked for
GAUSS = ((0.046910077030668, 0.118463442528095), (0.230765344947158, 0.239314335249683), (0.5, 0.284444444444444),
         (0.769234655052842, 0.239314335249683), (0.953089922969332, 0.118463442528095))  # fmt: skip


class Rate(NamedTuple):
    """By s: slopes of way (m) and turning (rad), and how the slopes change."""

    way: float
    turn: float
    way_bend: float = 0.0
    turn_bend: float = 0.0


def rate_of(tcp: Derivatives) -> Rate:
    """Of a curve."""
    way, turn = norm(tcp.p1), norm(tcp.w)
    return Rate(way, turn, dot(tcp.p1, tcp.p2) / way if way > 0.0 else 0.0, dot(tcp.w, tcp.w1) / turn if turn > 0.0 else 0.0)


def tool_rows(
    rate: Callable[[float], Rate], start: float, end: float, ends: tuple[Rate, Rate], made: tuple[float, float], anyhow: bool = False
) -> tuple[Row, Row] | None:
    """Way and turning over start .. end, in s - start; made: their values at the start.  None: one quintic does not follow them (anyhow:
    the nearest one)."""
    h = end - start
    inside = [(share * h, weight, rate(start + share * h)) for share, weight in GAUSS]
    rows: list[Row] = []
    for k in (0, 1):
        found = [slopes[k] for _, _, slopes in inside]
        total = h * sum([weight * slope for (_, weight, _), slope in zip(inside, found, strict=True)])
        (first, bend), (last, last_bend) = [(each[k], each[k + 2]) for each in ends]
        if not any((first, bend, last, last_bend, *found)):
            rows.append((made[k], 0.0, 0.0, 0.0, 0.0, 0.0))
            continue
        row = hermite(h, (made[k], first, bend), (made[k] + total, last, last_bend))
        low = LOW * max(first, last, *found)
        if not anyhow:
            for (u, _, _), slope in zip(inside, found, strict=True):
                if abs(_slope(row, u) - slope) > TRUE * max(slope, low) + NOISE:
                    return None
        rows.append(row)
    return rows[0], rows[1]


def divided(
    rate: Callable[[float], Rate], start: float, end: float, made: tuple[float, float], finest: float
) -> Iterator[tuple[float, Row, Row]]:
    """Way and turning over start .. end, halved until they follow: (where each part ends, its rows).  made: their values at the start;
    finest: a part that short stays as it is."""
    todo, here, before = [end], start, rate(start)
    while todo:
        there = todo[-1]
        behind = rate(there)
        tool = tool_rows(rate, here, there, (before, behind), made, there - here <= finest)
        if tool is None:
            todo.append(0.5 * (here + there))
            continue
        yield todo.pop(), *tool
        made = value(tool[0], there - here), value(tool[1], there - here)
        here, before = there, behind


def _slope(row: Row, u: float) -> float:
    _, b, c, d, e, f = row
    return b + u * (2 * c + u * (3 * d + u * (4 * e + u * 5 * f)))
