"""Touch probes inside drives: the edge that ends a block or is measured on the way, as the drives caught it.  Pure.

A drive reports where it was at an edge, not when.  The instant is found where its own positions, latched at each SYNC, passed that place;
axes whose drives did not catch the edge are measured at that instant (AX-569).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from drivers.drives.family import Latched, Latching
from gateway.pure.cycle.axis import HeldAxis
from motion.measure.history import History

TOGETHER = 3  # cycles the telegrams of one edge may come apart
LATE = 6  # cycles until an edge whose place no position passed is accepted: the axis was at rest
HALVINGS = 30


def latches(axes: Sequence[HeldAxis], actuals: Sequence[object]) -> list[tuple[Latched, HeldAxis] | None]:
    """actuals: (axes,) of this SYNC.  (axes,) what each drive's probe has caught so far, and what its increments mean now."""
    return [
        (actual.latched, axis) if isinstance(actual, Latching) and actual.latched is not None else None
        for axis, actual in zip(axes, actuals, strict=True)
    ]


@dataclass(slots=True)
class DriveProbe:
    """One measurement.  drives: axes (bit n-1 = axis n) whose probes count; edge: True positive."""

    drives: int
    edge: bool
    places: dict[int, float] = field(default_factory=dict)  # axis (from 0) -> m or rad: the first edge of each drive
    _known: dict[int, int] = field(default_factory=dict)  # edges of each drive when the measurement began
    _cycles: int = 0  # since the first edge

    @property
    def hit(self) -> bool:
        """One of the drives has caught the edge."""
        return bool(self.places)

    def hear(self, said: Sequence[tuple[Latched, HeldAxis] | None]) -> None:
        """Once a cycle."""
        self._cycles += self.hit
        for n, each in enumerate(said):
            if each is None or not self.drives >> n & 1 or n in self.places:
                continue
            latched, axis = each
            count, place = (latched.rises, latched.rising_inc) if self.edge else (latched.falls, latched.falling_inc)
            if count != self._known.setdefault(n, count):
                self.places[n] = axis.scaling.to_si(place)

    def instant(self, history: History) -> int | None:
        """When it was; None: not known yet."""
        if not self.hit or (len(self.places) < self.drives.bit_count() and self._cycles < TOGETHER):
            return None
        for axis, place in self.places.items():
            found = passed(history, axis, place)
            if found is not None:
                return found
        return history.newest_ns if self._cycles >= LATE else None


def passed(history: History, axis: int, place: float) -> int | None:
    """When the axis passed this place last; None: it did not, as far as is known."""
    stamps = history.stamps
    for before, after in zip(reversed(stamps[:-1]), reversed(stamps[1:]), strict=True):
        low, high = history.at(before)[axis] - place, history.at(after)[axis] - place
        if low * high > 0.0 or low == high:
            continue
        a, b = before, after
        for _ in range(HALVINGS):
            if b - a <= 1:
                break
            middle = (a + b) // 2
            if (history.at(middle)[axis] - place) * low > 0.0:
                a = middle
            else:
                b = middle
        return b
    return None
