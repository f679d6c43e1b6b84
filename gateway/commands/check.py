"""`axisgate check CELL`: everything that is wrong with a cell file in one run, and what is worth knowing about it."""

import argparse
import dataclasses
import json
import os
import sys

from gateway.cell_file.load import load_cell
from gateway.files.find import ConfigNotFound
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults, Fault
from gateway.runtime.exit_codes import Exit

EXAMPLES = """examples:
  axisgate check cell.toml            all faults, warnings and notes of a file
  axisgate check demo                 a shipped cell by its name: demo, s5-rk512, rho3-servodyn
  axisgate check cell.toml --json     the same for a program
exit code: 0 valid, 1 valid but --strict found a warning, 2 file or command line invalid"""
COLOURS = {"error": "\033[31m", "warning": "\033[33m", "note": "\033[36m"}


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate check", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell", metavar="CELL", help="cell file, or the name of a shipped one")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--strict", action="store_true", help="exit 1 when there are warnings")
    options = parser.parse_args(argv)
    try:
        cell = load_cell(options.cell)
    except CellFaults as found:
        print(json.dumps(as_json(options.cell, found.faults), indent=1) if options.json else "\n".join(told(options.cell, found.faults)))
        return Exit.INVALID
    except (ConfigNotFound, OSError) as error:
        print(f"axisgate check: {error}", file=sys.stderr)
        return Exit.INVALID
    print(json.dumps(valid_json(cell), indent=1) if options.json else "\n".join(valid(options.cell, cell)))
    return Exit.FINDING if options.strict and cell.warnings else Exit.OK


def valid(name: str, cell: Cell) -> list[str]:
    """The lines for a valid file."""
    parts = ((len(cell.axis), "axis", "axes"), (len(cell.line), "line", "lines"), (len(cell.bus), "bus", "buses"))
    counted = ", ".join(_plural(*part) for part in parts)
    warnings, notes = _plural(len(cell.warnings), "warning", "warnings"), _plural(len(cell.notes), "note", "notes")
    lines = [f"{name}: {counted}: 0 errors, {warnings}, {notes}"]
    lines += [f"{_level(notice.level)}{notice.where}: {notice.text}" for notice in cell.notices]
    if cell.not_playable() or not cell.axis:
        first = f"axis.{cell.axis[0].name}" if cell.axis else "cell"
        return [*lines, f"next: axisgate explain {first} --cell {name}"]
    return [*lines, f"next: axisgate run {name} --sim      then: axisgate explain axis.{cell.axis[0].name} --cell {name}"]


def told(name: str, faults: tuple[Fault, ...]) -> list[str]:
    """The lines for a file with faults."""
    crossed = sum(fault.kind == "cross" for fault in faults)
    kinds = f" ({len(faults) - crossed} in single keys, {crossed} between keys)" if crossed else ""
    lines = [f"{name}: {_plural(len(faults), 'error', 'errors')}{kinds}"]
    lines += [_level("error") + str(fault) for fault in faults]
    return [*lines, f"next: correct them, then: axisgate check {name}"]


def as_json(name: str, faults: tuple[Fault, ...]) -> dict[str, object]:
    """A file with faults, for a program."""
    return {"file": name, "valid": False, "errors": [dataclasses.asdict(fault) for fault in faults], "warnings": [], "notes": []}


def valid_json(cell: Cell) -> dict[str, object]:
    """A valid file, for a program."""
    return {
        "file": cell.file,
        "valid": True,
        "errors": [],
        "warnings": [dataclasses.asdict(notice) for notice in cell.warnings],
        "notes": [dataclasses.asdict(notice) for notice in cell.notes],
        "axes": [axis.name for axis in cell.axis],
        "lines": [line.name for line in cell.line],
        "buses": [bus.name for bus in cell.bus],
        "not_playable": cell.not_playable(),
    }


def _plural(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"


def _level(level: str) -> str:
    """The level in a column of nine characters, coloured only on a terminal."""
    if sys.stdout.isatty() and not os.environ.get("NO_COLOR"):
        return f"{COLOURS[level]}{level:<9}\033[0m"
    return f"{level:<9}"
