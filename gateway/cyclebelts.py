"""Belts of the cycle process: what a cell with [[belt]] needs beside the core; kinematics are loaded only there."""

from dataclasses import dataclass

from gateway.axes import limits_of
from gateway.beltplan import belt_facts
from gateway.cell import Cell
from gateway.programplan import machine_of_cell
from gateway.pure.corebelts import CoreBelts


@dataclass(slots=True)
class Encoder:
    """A belt's measuring system on a bus: a count, low byte first, in a telegram of its own."""

    belts: CoreBelts
    place: int
    first: int  # byte
    size: int  # 2 | 4 bytes
    last: int | None = None
    count: int = 0  # rolled out

    def hear(self, data: bytes) -> int:
        """Its telegram; 1: it was heard for the first time in this cycle."""
        octets = data[self.first : self.first + self.size]
        if len(octets) != self.size:
            return 0
        new, value, half = not self.belts.heard[self.place], int.from_bytes(octets, "little"), 1 << (8 * self.size - 1)
        if self.last is not None:  # a counter begins at 0 at start-up
            self.count += (value - self.last + half) % (2 * half) - half
        self.last = value
        self.belts.count(self.place, self.count)
        return int(new)


def belts_of(cell: Cell, p5_ms: int) -> CoreBelts:
    """Belts of a checked cell; its robot stands on its first axes."""
    return CoreBelts(belt_facts(cell), machine_of_cell(cell).kinematics, [limits_of(axis) for axis in cell.axis], p5_ms / 1000.0)


def encoders_of(cell: Cell, bus: str, belts: CoreBelts) -> dict[int, Encoder]:
    """Those on one drive bus, by the identifier of their telegrams."""
    found = {}
    for place, belt in enumerate(cell.belt):
        if belt.bus == bus:
            belts.expect(place)
            found[belt.id] = Encoder(belts, place, belt.byte, belt.bytes)
    return found
