"""Emulate the drives of a cell on a CAN bus, for a gateway (or a real controller) somewhere else on that bus."""

import argparse
import pathlib
import sys
import tempfile

from gateway.commands.common import BANNER, ENVIRONMENT, load
from gateway.families import DRIVE_PROTOCOLS
from gateway.plant import write_settings
from gateway.processes import emulator

EXAMPLES = """examples:
  axisgate emulate demo --bus socketcan:vcan0   six drives of the demo cell on vcan0
  axisgate emulate demo --bus broker:bench      on the local bus `python -m gateway.processes.broker --name bench`
  axisgate emulate cell.toml --bus socketcan:can1 --record plant.rec
"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate emulate", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell", help="cell file, or the name of a shipped one")
    parser.add_argument("--bus", required=True, help="socketcan:IFACE or broker:NAME")
    parser.add_argument("--drives", help="which [[bus]] of the cell, when it has several")
    parser.add_argument("--record", type=pathlib.Path, help="file for the emulator's own record")
    arguments = parser.parse_args(argv)
    cell = load(arguments.cell)
    if isinstance(cell, int):
        return cell
    buses = [bus for bus in cell.bus if bus.protocol in DRIVE_PROTOCOLS and arguments.drives in (None, bus.name)]
    if len(buses) != 1:
        known = ", ".join(bus.name for bus in cell.bus if bus.protocol in DRIVE_PROTOCOLS)
        print(
            f"axisgate emulate: --drives NAME: one drive bus of {known or 'none'}",
            file=sys.stderr,
        )
        return ENVIRONMENT
    print(BANNER, flush=True)
    kept = ["--record", str(arguments.record)] if arguments.record else []
    with tempfile.TemporaryDirectory(prefix="axisgate-emulate-") as folder:
        settings = write_settings(cell, buses[0].name, pathlib.Path(folder), buses[0].cycle_ms)
        return emulator.main(["--settings", str(settings), "--bus", arguments.bus, *kept])
