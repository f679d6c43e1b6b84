"""A measured time is an interval: what the adapter, the length of a character and the lateness of the host leave open."""

from dataclasses import dataclass
from enum import Enum, auto

from protocols.base.machine import Ns


class Place(Enum):
    """Where an interval lies to its limits."""

    INSIDE = auto()
    OUTSIDE = auto()
    ACROSS = auto()


@dataclass(frozen=True, slots=True)
class Measure:
    """One time.  least and most: its limits; None: only recorded, or open to that side."""

    what: str
    ns: Ns
    least: Ns | None
    most: Ns | None
    uncertainty: Ns
    clock: str

    def place(self) -> Place:
        """Return inside or outside only where the entire interval is."""
        low, high = self.ns - self.uncertainty, self.ns + self.uncertainty
        least = low if self.least is None else self.least
        most = high if self.most is None else self.most
        if least <= low and high <= most:
            return Place.INSIDE
        return Place.OUTSIDE if high < least or low > most else Place.ACROSS

    def limits(self) -> str:
        """In words."""
        if self.least is not None and self.most is not None:
            return f"{self.least / 1e6:.1f} to {self.most / 1e6:.1f} ms"
        if self.most is not None:
            return f"at most {self.most / 1e6:.1f} ms"
        return "no limit" if self.least is None else f"at least {self.least / 1e6:.1f} ms"
