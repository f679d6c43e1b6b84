"""Where the touch probe of an emulated CiA 402 drive switched, by the emulator's own record: places of the mechanics, and its settings."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

from drivers.emulator.servo.model import INC_PER_RAD
from drivers.emulator.servo.record import Record


@dataclass(frozen=True)
class Edge:
    """places: (axes,) increments of the drives at the edge, not rounded."""

    rising: bool
    places: tuple[float, ...]


def edges(record: Record, since: int) -> list[Edge]:
    """Of probe 1 of the first drive, after that stamp, in their order."""
    return list(_edges(record, since))


def _edges(record: Record, since: int) -> Iterator[Edge]:
    settings = record.header["settings"]
    assert isinstance(settings, dict)
    drive = settings["nodes"][str(record.axes[0])]
    low, high = drive["probe_1_from_rad"], drive["probe_1_to_rad"]
    rows = [row for row in record.rows if row.stamp_ns >= since]
    for before, after in itertools.pairwise(rows):
        a, b = before.axes[0].position_rad, after.axes[0].position_rad
        for place, rises_upwards in ((low, True), (high, False)):
            if (a - place) * (b - place) < 0.0:
                share = (place - a) / (b - a)
                ways = [(y.position_rad - x.position_rad) * INC_PER_RAD * share for x, y in zip(before.axes, after.axes, strict=True)]
                yield Edge(rises_upwards is (b > a), tuple(x.position_inc + 0.5 + way for x, way in zip(before.axes, ways, strict=True)))
