"""Emulate the drives of a cell on a CAN bus, for a gateway or a real controller elsewhere on that bus."""

import argparse
import pathlib
import sys
import tempfile

from drivers.drives.masters import masters_in
from drivers.ports.base import PortError
from drivers.ports.can.open import open_can
from gateway.assembly.drive_buses import DRIVE_PROTOCOLS
from gateway.assembly.plant import write_settings
from gateway.links.canopen.listen_first import listen, taken_nodes
from gateway.pure.cell.cell import Bus, Cell
from gateway.registry import BUS_PROTOCOLS
from gateway.simulation.drives import process as emulator
from gateway.tools.cell_argument import load
from gateway.tools.command_support import BANNER, ENVIRONMENT
from gateway.tools.usage_language import complain

LOCAL = ("broker:", "socketcan:vcan")  # buses without metal
EXAMPLES = """examples:
  axisgate emulate demo --bus socketcan:vcan0   six drives of the demo cell on vcan0
  axisgate emulate demo --bus broker:bench      on the local bus `python -m gateway.simulation.bus.broker --name bench`
  axisgate emulate cell.toml --bus socketcan:can1 --record plant.rec
"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate emulate", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell", help="cell file, or the name of a shipped one")
    parser.add_argument("--bus", required=True, help="socketcan:IFACE or broker:NAME")
    parser.add_argument("--drives", help="which [[bus]] of the cell, when it has several")
    parser.add_argument("--beside", action="store_true", help="also on a real bus where a master is active")
    parser.add_argument("--record", type=pathlib.Path, help="file for the emulator's own record")
    arguments = parser.parse_args(argv)
    cell = load(arguments.cell)
    if isinstance(cell, int):
        return cell
    buses = [bus for bus in cell.bus if bus.protocol in DRIVE_PROTOCOLS and arguments.drives in (None, bus.name)]
    if len(buses) != 1:
        known = ", ".join(bus.name for bus in cell.bus if bus.protocol in DRIVE_PROTOCOLS)
        complain("emulate", f"--drives NAME: one drive bus of {known or 'none'}")
        return ENVIRONMENT
    if words := look_first(cell, buses[0], arguments.bus, beside=arguments.beside):
        complain("emulate", words)
        return ENVIRONMENT
    print(BANNER, flush=True)
    kept = ["--record", str(arguments.record)] if arguments.record else []
    with tempfile.TemporaryDirectory(prefix="axisgate-emulate-") as folder:
        settings = write_settings(cell, buses[0].name, pathlib.Path(folder), buses[0].cycle_ms)
        return emulator.main(["--settings", str(settings), "--bus", arguments.bus, *kept])


def look_first(cell: Cell, bus: Bus, url: str, *, beside: bool) -> str:
    """Why no drives are emulated there: real ones, or another emulator's, have the same numbers; or the bus is that of a machine."""
    try:
        port = open_can(url)
    except PortError:
        return ""  # the emulator waits for the bus
    try:
        heard = listen(port)
    except PortError as error:
        return str(error)
    finally:
        port.close()
    if BUS_PROTOCOLS[bus.protocol].nodes:
        taken = taken_nodes(heard, [axis.drive.node for axis in cell.axis if axis.drive.bus == bus.name and axis.drive.node])
        if taken:
            return f"{url}: node {', '.join(map(str, taken))} is on this bus already; two devices with one number disturb each other"
    master = masters_in(heard, bus.protocol)
    if master and not beside and not url.startswith(LOCAL):
        return (
            f"{url}: a master is active on this bus: {master}; emulated drives would answer it as its own: stop it first, or add --beside"
        )
    if master:
        print(f"{url}: a master is already active: {master}", file=sys.stderr, flush=True)
    return ""
