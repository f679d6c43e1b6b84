"""Print the addresses at the command sources of a cell: Modbus registers, data blocks, signals, wiring."""

import argparse
import pathlib

from gateway.pure.reports.tables import FORMS, render
from gateway.tools.address_map import SHEETS
from gateway.tools.cell_argument import load
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate map demo --modbus                                all registers, counted from 0 and from 1
  axisgate map cell.toml --db --format csv -o blocks.csv    for a spreadsheet: semicolon, decimal comma
  axisgate map cell.toml --wiring --signals --format html -o map.html    prints on A4
exit code: 0 printed, 1 the cell has nothing of it, 2 cell invalid, 3 the file cannot be written"""
FOOTER = "axisgate is not a safety device: emergency stop, guards and enabling devices belong in certified hardware."


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate map", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell")
    for name in SHEETS:
        parser.add_argument(f"--{name}", action="store_true")
    parser.add_argument("--format", choices=FORMS, default="md")
    parser.add_argument("--json", action="store_true", help="the same as --format json")
    parser.add_argument("-o", "--output", metavar="FILE", help="instead of standard output")
    arguments = parser.parse_args(argv)
    wanted = [name for name in SHEETS if getattr(arguments, name)]
    if not wanted:
        parser.error(f"name at least one of {', '.join(f'--{name}' for name in SHEETS)}")
    cell = load(arguments.cell)
    if isinstance(cell, int):
        return cell
    sheets = [sheet for name in wanted for sheet in SHEETS[name](cell)]
    if not sheets:
        complain("map", f"{arguments.cell} has no {' and no '.join(wanted)}; axisgate map --wiring shows what it has")
        return FINDING
    text = render(cell.cell.name, sheets, "json" if arguments.json else arguments.format, FOOTER)
    if not arguments.output:
        print(text, end="")
        return DONE
    try:
        pathlib.Path(arguments.output).write_text(text, encoding="utf-8", newline="")
    except OSError as error:
        complain("map", f"{arguments.output}: {error.strerror}; name another file with -o")
        return ENVIRONMENT
    return DONE
