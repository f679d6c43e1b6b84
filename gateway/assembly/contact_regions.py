"""Regions and processes a run has only where its cell joins values or has contacts: the cycle's wake-up, contacts out and in."""

import os
import struct
from collections.abc import Mapping

from gateway.pure.buses.contacts import SAID_BYTES, SAID_LAYOUT
from gateway.pure.cell.cell import Cell
from gateway.pure.controllers.rho3.can.ledger import LEDGER_BYTES, LEDGER_LAYOUT
from gateway.pure.image.records.cell import RC_BYTES
from gateway.runtime.regions import create_region

MARKS_LAYOUT = f"marks/1 quality of {RC_BYTES} RC output bytes"
MOST_BELTS = 8
OFFSETS = struct.Struct(f"={MOST_BELTS}d")  # m or rad, NaN: nothing to keep
OFFSETS_LAYOUT = f"belts/1 {OFFSETS.format} offsets"
COUNTERS_LAYOUT = f"belt counters/1 {OFFSETS.format}"  # m or rad
SHAPES = {
    "belts": (OFFSETS.size, OFFSETS_LAYOUT),
    "belt_counters": (OFFSETS.size, COUNTERS_LAYOUT),
    "marks": (RC_BYTES, MARKS_LAYOUT),
    "io_errors": (LEDGER_BYTES, LEDGER_LAYOUT),
}


def chips(cell: Cell) -> bool:
    """Whether contacts are on a gpiochip: those have a process of their own."""
    return any(io.device.type == "gpiochip" for io in cell.io)


def joined_regions(cell: Cell) -> tuple[str, ...]:
    """Names for cycle and services."""
    joined = ("wake", "marks") if cell.io or cell.route else ()
    contacts = ("io_out", "io_in", *(("io_chip",) if chips(cell) else ())) if cell.io else ()
    blocks = ("io_errors",) if cell.rho3 is not None else ()
    belts = (*(("belts",) if keeps_belts(cell) else ()), *(("belt_counters",) if reads_belts(cell) else ()))
    return (*joined, *contacts, *blocks, *belts)


def keeps_belts(cell: Cell) -> bool:
    """Offsets of belts outlive power-off here (AX-480)."""
    named = cell.retain is not None and any(pattern.startswith("belt.") for pattern in cell.retain.values)
    return named and any(belt.bus for belt in cell.belt)


def reads_belts(cell: Cell) -> bool:
    """Programs of a language read the counters of its belts."""
    return bool(cell.belt) and cell.controller is not None and bool(cell.controller.memory)


def make_joined(cell: Cell) -> dict[str, int]:
    """One event descriptor (AX-398) and one memfd per region; the supervisor keeps them for its lifetime."""
    return {name: _made(name) for name in joined_regions(cell)}


def _made(name: str) -> int:
    if name == "wake":
        return os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
    return create_region(name, *SHAPES.get(name, (SAID_BYTES, SAID_LAYOUT)))


def simulated_couplers(cell: Cell, slug: str, buses: Mapping[str, str]) -> dict[str, tuple[str, ...]]:
    """Bus -> arguments of the process that emulates its couplers in a simulated run."""
    absent = cell.plant.absent if cell.plant else ()
    nodes: dict[str, set[int]] = {}
    for io in cell.io:
        if io.device.type == "canopen-401" and io.device.node is not None and io.device.bus in buses and io.device.bus not in absent:
            nodes.setdefault(io.device.bus, set()).add(io.device.node)
    return {
        bus: ("--bus", buses[bus], "--name", f"{slug}-{bus}-io", "--nodes", ",".join(map(str, sorted(found))))
        for bus, found in nodes.items()
    }
