"""Belts of the cycle process: what a cell with [[belt]] needs in addition to the core; kinematics are loaded only there."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import isnan, nan

from gateway.assembly.belts import belt_facts
from gateway.assembly.contact_regions import COUNTERS_LAYOUT, MOST_BELTS, OFFSETS, OFFSETS_LAYOUT
from gateway.assembly.limits import limits_of
from gateway.assembly.programs import robots_placed
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.belts import CoreBelts
from gateway.runtime.regions import RegionWriter


@dataclass(slots=True)
class Encoder:
    """A belt's measuring system on a bus: a count, low byte first, in its own telegram."""

    belts: CoreBelts
    place: int
    first: int  # byte
    size: int  # 2 | 4 bytes
    last: int | None = None
    count: int = 0  # rolled out

    def hear(self, data: bytes) -> int:
        """Its telegram; 1: it was received for the first time in this cycle."""
        octets = data[self.first : self.first + self.size]
        if len(octets) != self.size:
            return 0
        new, value, half = not self.belts.encoders.heard[self.place], int.from_bytes(octets, "little"), 1 << (8 * self.size - 1)
        if self.last is None:  # a counter begins at 0 at start-up, unless its offset was kept
            self.belts.begins(self.place, value, 2 * half)
        else:
            self.count += (value - self.last + half) % (2 * half) - half
        self.last = value
        self.belts.count(self.place, self.count)
        return int(new)


class BeltOffsets:
    """Offsets of the belts for the services to keep; written after a move of half an increment; rounding is not a change."""

    def __init__(self, belts: CoreBelts, fd: int) -> None:
        self._belts, self._region = belts, RegionWriter(fd, "belts", OFFSETS_LAYOUT)
        self._written = [nan] * MOST_BELTS
        self._write(0)

    def turn(self, now: int) -> None:
        """Once per cycle."""
        found = [self._belts.offset(place) for place in range(len(self._belts.facts))]
        for place, (new, old) in enumerate(zip(found, self._written, strict=False)):
            if not isnan(new) and not abs(new - old) < 0.5 * abs(self._belts.facts[place].data.increment):
                self._written[place] = new
                self._write(now)

    def _write(self, now: int) -> None:
        self._region.write(OFFSETS.pack(*self._written), now)


def pack_counters(belts: CoreBelts) -> bytes:
    """As programs of a language read them."""
    return OFFSETS.pack(*(*(belt.counter for belt in belts.all.all), *[0.0] * MOST_BELTS)[:MOST_BELTS])


class BeltCounters:
    """Counters of the belts for the process that runs programs of a language."""

    def __init__(self, belts: CoreBelts, fd: int) -> None:
        self._belts, self._region = belts, RegionWriter(fd, "belt_counters", COUNTERS_LAYOUT)

    def turn(self, now: int) -> None:
        """Once per cycle."""
        self._region.write(pack_counters(self._belts), now)


def belt_regions(belts: CoreBelts | None, fds: Mapping[str, int]) -> list[BeltOffsets | BeltCounters]:
    """The belts' regions for other processes, if the run has them."""
    if belts is None:
        return []
    offsets = [BeltOffsets(belts, fds["belts"])] if "belts" in fds else []
    return [*offsets, *([BeltCounters(belts, fds["belt_counters"])] if "belt_counters" in fds else [])]


def belts_of(cell: Cell, p5_ms: int) -> CoreBelts:
    """Belts of a checked cell."""
    return CoreBelts(belt_facts(cell), robots_placed(cell), [limits_of(axis) for axis in cell.axis], p5_ms / 1000.0)


def encoders_of(cell: Cell, bus: str, belts: CoreBelts) -> dict[int, Encoder]:
    """Those on one drive bus, by the identifier of their telegrams."""
    found = {}
    for place, belt in enumerate(cell.belt):
        if belt.bus == bus:
            belts.expect(place)
            found[belt.id] = Encoder(belts, place, belt.byte, belt.bytes)
    return found
