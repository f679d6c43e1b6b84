"""Belts of a cell as BAPS2 programs count them: channels 501.., counters in mm or deg, values after the axes in points (rho 3 releases,
L6021-6460).  Pure.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.base.hosting import Port
from motion.program.passing import Presets

FIRST_CHANNEL = 500  # and the number of the belt
PARALLEL, CAM = 1, 3  # types


@dataclass(frozen=True, slots=True)
class CellBelt:
    """A [[belt]] of the cell.  robots: numbers of those that follow it."""

    name: str
    unit: str
    robots: frozenset[int]


@dataclass(frozen=True, slots=True)
class CellSetup:
    """Facts of a cell other than its robots.  presets: of R and R_PTP, by kinematic; wires: measuring inputs, and the RC input of each
    (-1: a drive has it).
    """

    presets: Sequence[Presets] = ()
    belts: Sequence[CellBelt] = ()
    wires: Mapping[int, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class CellBelts:
    """All of them, numbered from 1 in the order of the cell file."""

    all: Sequence[CellBelt]
    port: Port

    def number(self, channel: int) -> int:
        """Return the belt of a channel 501..508, or of a number of special functions.  Raise a runtime error for an unknown belt."""
        number = channel % FIRST_CHANNEL
        if not 1 <= number <= len(self.all):
            raise fault(93, str(number))
        return number

    def named(self, number: int) -> CellBelt:
        """A belt that is there."""
        return self.all[number - 1]

    def counter(self, number: int) -> float:
        """Its counter now."""
        counters = self.port.view.belts
        return counters[number - 1] if number <= len(counters) else 0.0

    def kind(self, number: int) -> int:
        """Its type now (special function 21)."""
        kinds = self.port.view.belt_types
        return kinds[number - 1] if number <= len(kinds) else PARALLEL

    def followed(self, robot: int) -> list[int]:
        """Return the belts that this robot follows: components of its points after its axes, in this order."""
        return [number for number, belt in enumerate(self.all, 1) if robot in belt.robots]

    def values(self, robot: int, count: int) -> tuple[float, ...]:
        """Counters of the first `count` belts of a robot, 0 for components no belt of the cell has."""
        found = [self.counter(number) for number in self.followed(robot)]
        return tuple((*found, *[0.0] * count)[:count])

    def length(self, number: int, value: float) -> str:
        """A value as the text form has it."""
        return f"{value:.10g}{self.named(number).unit}"
