"""[rho3] P30..P32 and P601 of a cell on its buses: the cycle's frames there, and the emulated modules of a simulated run."""

import time

from drivers.drives.family import BusFamily
from drivers.drives.servodyn_download import Download
from gateway.assembly.rho3_blocks import blocks_of
from gateway.pure.cell.cell import Bus, Cell
from gateway.pure.controllers.rho3.can.blocks import IoBus, IoSettings
from gateway.pure.controllers.rho3.can.download import download
from gateway.pure.controllers.rho3.can.family import Parameters, RhoFamily
from protocols.base.machine import ms

IO_PROTOCOL = "rho3-io"  # a bus with digital I/O and no axes


def io_settings(cell: Cell, bus: Bus) -> IoSettings | None:
    """The I/O blocks of a bus; None: it has none."""
    number = cell.bus.index(bus) + 1
    inputs, outputs = (blocks_of(blocks, number) for blocks in ((cell.rho3.P31, cell.rho3.P32) if cell.rho3 else ((), ())))
    if not inputs and not outputs:
        return None
    watch = ms(bus.coupling_ms) if bus.coupling_ms else None
    return IoSettings(number, inputs, outputs, watch, zero_on_loss=bus.on_loss == "zero")


def downloads(cell: Cell, bus: Bus) -> dict[int, Parameters]:
    """Module -> parameters to send at the start; empty where P601 is FALSE."""
    found = {}
    for index, axis in enumerate(cell.axis):
        if cell.rho3 is not None and axis.drive.bus == bus.name and axis.drive.module is not None:
            values = [(each.row.number, each.value) for each in download(cell.rho3, axis, index)]
            if values:
                found[axis.drive.module] = Parameters(index, Download(values))
    return found


def with_rho3(cell: Cell, bus: Bus, drives: BusFamily | None) -> BusFamily:
    """The drives' own family where the bus carries nothing else."""
    settings, sent = io_settings(cell, bus), downloads(cell, bus)
    if drives is not None and settings is None and not sent:
        return drives
    return RhoFamily(IoBus(settings, time.monotonic_ns()) if settings else None, drives, sent, cell.bus.index(bus) + 1)


def module_arguments(cell: Cell, bus: Bus, url: str) -> tuple[str, ...]:
    """Command line of the emulated I/O modules; empty: the bus has none."""
    settings = io_settings(cell, bus)
    if settings is None:
        return ()
    inputs = ",".join(f"{block.identifier}:{block.length}" for block in settings.inputs)
    return ("--bus", url, "--inputs", inputs, "--outputs", ",".join(str(block.identifier) for block in settings.outputs))
