"""Where the axes were at an instant between two cycles: positions of the last cycles, interpolated.

A straight line between two cycles would miss by a h^2 / 8 (20 um at 10 m/s2 and 4 ms); cubics do not.  With the speeds of both ends
(set values have them) the cubic meets both, without them it goes through the last four samples.
"""

from collections import deque
from collections.abc import Sequence
from math import isfinite
from typing import NamedTuple

from motion.errors import MotionError

KEPT = 64  # cycles an edge may come late


class _Place(NamedTuple):
    stamp_ns: int
    q: tuple[float, ...]
    qd: tuple[float, ...] | None


class History:
    """add() once a cycle with the stamp the positions belong to; at() for any instant that is still kept."""

    def __init__(self, axes: int, kept: int = KEPT) -> None:
        if axes < 1 or kept < 4:
            raise MotionError(f"a history of {axes} axes and {kept} cycles: 1 and 4 are the least")
        self._axes = axes
        self._places: deque[_Place] = deque(maxlen=kept)

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the last positions; None: none yet."""
        return self._places[-1].stamp_ns if self._places else None

    @property
    def oldest_ns(self) -> int | None:
        """Stamp of the first positions still kept."""
        return self._places[0].stamp_ns if self._places else None

    @property
    def stamps(self) -> list[int]:
        """Of everything that is kept, rising."""
        return [place.stamp_ns for place in self._places]

    def add(self, stamp_ns: int, q: Sequence[float], qd: Sequence[float] | None = None) -> None:
        """Positions (m or rad) at this instant, and their speeds (per s) where they are known."""
        if len(q) != self._axes or (qd is not None and len(qd) != self._axes):
            raise MotionError(f"{len(q)} positions for {self._axes} axes")
        if not all(map(isfinite, (*q, *(qd or ())))):
            raise MotionError(f"positions {tuple(q)} are not all numbers")
        if self._places and stamp_ns <= self._places[-1].stamp_ns:
            raise MotionError(f"positions of {stamp_ns} ns come after those of {self._places[-1].stamp_ns} ns")
        self._places.append(_Place(stamp_ns, tuple(q), None if qd is None else tuple(qd)))

    def at(self, stamp_ns: int) -> tuple[float, ...]:
        """Positions then; MotionError for an instant that is not kept any more, or that is still to come."""
        places = self._places
        if not places or not places[0].stamp_ns <= stamp_ns <= places[-1].stamp_ns:
            kept = f"{places[0].stamp_ns} .. {places[-1].stamp_ns} ns" if places else "nothing"
            raise MotionError(f"position at {stamp_ns} ns: {kept} is kept")
        after = next(n for n in range(len(places)) if places[n].stamp_ns >= stamp_ns)
        if places[after].stamp_ns == stamp_ns:
            return places[after].q
        before, behind = places[after - 1], places[after]
        if before.qd is not None and behind.qd is not None:
            return _with_speeds(before, behind, before.qd, behind.qd, stamp_ns)
        first = max(min(after - 2, len(places) - 4), 0)
        return _through([places[n] for n in range(first, min(first + 4, len(places)))], stamp_ns)


def _with_speeds(a: _Place, b: _Place, speed_a: Sequence[float], speed_b: Sequence[float], stamp_ns: int) -> tuple[float, ...]:
    """Cubic with both positions and both speeds."""
    h = (b.stamp_ns - a.stamp_ns) * 1e-9
    x = (stamp_ns - a.stamp_ns) / (b.stamp_ns - a.stamp_ns)
    y = 1.0 - x
    return tuple(
        p + (q - p) * x * x * (3 - 2 * x) + h * x * y * (y * v - x * w) for p, q, v, w in zip(a.q, b.q, speed_a, speed_b, strict=True)
    )


def _through(places: Sequence[_Place], stamp_ns: int) -> tuple[float, ...]:
    """The polynomial through all these places, relative to the first position so that long travels lose no digits."""
    base = places[0].q
    weights = []
    for n, place in enumerate(places):
        weight = 1.0
        for m, other in enumerate(places):
            if m != n:
                weight *= (stamp_ns - other.stamp_ns) / (place.stamp_ns - other.stamp_ns)
        weights.append(weight)
    return tuple(
        base[axis] + sum(weight * (place.q[axis] - base[axis]) for weight, place in zip(weights, places, strict=True))
        for axis in range(len(base))
    )
