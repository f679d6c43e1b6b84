"""`axisgate explain KEY`: a value of a cell with unit and source, a P number, a word, or an address in all worlds."""

import argparse
import dataclasses
import json
import pathlib
import re
import sys

from gateway.cell import Cell
from gateway.config import load_cell
from gateway.errors import Exit
from gateway.explained import Explainer, Line, address, word
from gateway.faults import CellFaults
from gateway.files import ConfigNotFound

EXAMPLES = """examples:
  axisgate explain axis.1 --cell cell.toml                all values of the first axis and where each comes from
  axisgate explain axis.A1.limits.speed --cell demo       one value
  axisgate explain P5 --cell rho3-servodyn                a machine parameter and what it sets
  axisgate explain QVZ                                    a word; also ZVZ, KF, KG, Kv, SYNC
  axisgate explain "RC 7.3"                               an address: number, PIC, CL300, RC, meaning
Without --cell the file cell.toml in this folder is taken where there is one.
exit code: 0 explained, 2 nothing of that name, or the cell file is invalid"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate explain", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("key", metavar="KEY")
    parser.add_argument("--cell", metavar="CELL", help="cell file, or the name of a shipped one")
    parser.add_argument("--json", action="store_true", help="a list of JSON objects on standard output")
    options = parser.parse_args(argv)
    path = options.cell or ("cell.toml" if pathlib.Path("cell.toml").is_file() else None)
    try:
        cell = load_cell(path) if path else None
        lines = explain(options.key, cell, path)
    except CellFaults as found:
        print(f"axisgate explain: {path} has {len(found.faults)} faults; axisgate check {path} names them", file=sys.stderr)
        return Exit.INVALID
    except (ConfigNotFound, OSError) as error:
        print(f"axisgate explain: {error}", file=sys.stderr)
        return Exit.INVALID
    if not lines:
        print(f"axisgate explain: {options.key}: {unknown(options.key, cell)}", file=sys.stderr)
        return Exit.INVALID
    print(json.dumps([dataclasses.asdict(line) for line in lines], indent=1) if options.json else "\n".join(table(lines)))
    return Exit.OK


def explain(key: str, cell: Cell | None, path: str | None) -> list[Line]:
    """What is known about a key; [] when nothing is."""
    if cell is not None and path is not None:
        explainer = Explainer(cell, path)
        if re.fullmatch(r"(rho3\.)?[Pp]\d+", key):
            return explainer.parameter(key.removeprefix("rho3.").upper())
        if lines := explainer.key(key) or explainer.block_place(key):
            return lines
    return word(key, cell) or address(key, cell.cell.language if cell else "en", cell)


def unknown(key: str, cell: Cell | None) -> str:
    """Why nothing was found."""
    if cell is None:
        return "no word or address of that name; keys of a cell need --cell CELL"
    return f"no such key, word or address; keys begin with axis.{cell.axis[0].name if cell.axis else 'NAME'}, line., bus., db., cell."


def table(lines: list[Line]) -> list[str]:
    """Columns: key, value with unit, source."""
    values = [f"{line.value} {line.unit}".strip() for line in lines]
    widths = max(len(line.key) for line in lines), min(44, max(len(value) for value in values))
    rows = zip(lines, values, strict=True)
    return [f"{line.key:<{widths[0]}}  {value:<{widths[1]}}  {line.source}".rstrip() for line, value in rows]
