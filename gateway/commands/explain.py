"""Explain a key of a cell (value, unit, source), a P number, a word, an address, an error or a decision."""

import argparse
import dataclasses
import json
import os
import pathlib
import re

from gateway.cell_file.explain import Explainer, Line, address, decision_lines, parameter_of_any_cell, word
from gateway.cell_file.load import load_cell
from gateway.files.error_catalogue import explain as errors_of
from gateway.files.find import ConfigNotFound
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.error_entries import Entry, number_of
from gateway.pure.lines.texts import LANGUAGES, language_of
from gateway.runtime.exit_codes import Exit
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate explain axis.1 --cell cell.toml                all values of the first axis and where each comes from
  axisgate explain axis.A1.limits.speed --cell demo       one value
  axisgate explain P5 --cell rho3-servodyn                a machine parameter and what it sets
  axisgate explain P303                                   what a machine parameter sets, without a cell
  axisgate explain AX-334                                 a decision of axisgate
  axisgate explain QVZ                                    a word; also ZVZ, KF, KG, Kv, SYNC
  axisgate explain "RC 7.3"                               an address: number, PIC, CL300, RC, meaning
  axisgate explain 647                                    an error: text, cause, what to do, reset, what the partner shows
  axisgate explain rk512 14h                              the number of one catalogue: rho3, reis, val3, servodyn, cia402, rk512, 3964r
Without --cell the file cell.toml in this folder is taken where there is one.
exit code: 0 explained, 2 nothing of that name, or the cell file is invalid"""

LABELS = (("cause", "what to do", "reset", "partner shows"), ("Ursache", "Abhilfe", "Ruecksetzen", "Partner zeigt"))


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate explain", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("key", metavar="KEY", nargs="+")
    parser.add_argument("--cell", metavar="CELL", help="cell file, or the name of a shipped one")
    parser.add_argument("--json", action="store_true", help="a list of JSON objects on standard output")
    parser.add_argument("--language", choices=LANGUAGES, help="of errors; else the cell's, else the system's")
    options = parser.parse_args(argv)
    options.key = " ".join(options.key)
    path = options.cell or ("cell.toml" if pathlib.Path("cell.toml").is_file() else None)
    try:
        cell = load_cell(path) if path else None
        spoken = language_of(options.language or (cell.cell.language if cell else None), os.environ)
        lines = explain(options.key, cell, path, spoken)
    except CellFaults as found:
        complain("explain", f"{path} has {len(found.faults)} faults; axisgate check {path} names them")
        return Exit.INVALID
    except (ConfigNotFound, OSError) as error:
        complain("explain", error)
        return Exit.INVALID
    if not lines:
        complain("explain", f"{options.key}: {unknown(options.key, cell)}")
        return Exit.INVALID
    print(json.dumps([dataclasses.asdict(line) for line in lines], indent=1) if options.json else "\n".join(table(lines)))
    return Exit.OK


def explain(key: str, cell: Cell | None, path: str | None, spoken: str = "en") -> list[Line]:
    """What is known about a key; [] if nothing is."""
    last = key.rsplit(maxsplit=1)[-1:]
    numbered = errors_of(key) if last and number_of(last[0]) is not None else []
    if decided := re.fullmatch(r"[Aa][Xx]-?(\d{3,4})", key):
        return decision_lines(f"AX-{decided[1]}")
    parameter = re.fullmatch(r"(?:rho3\.)?[Pp](\d+)", key)
    if parameter and cell is None:
        return parameter_of_any_cell(f"P{parameter[1]}")
    if cell is not None and path is not None:
        explainer = Explainer(cell, path)
        if parameter:
            return explainer.parameter(f"P{parameter[1]}")
        if lines := explainer.key(key) or explainer.block_place(key):
            return lines
    found = word(key, cell) or address(key, cell.cell.language if cell else "en", cell)
    errors = numbered or ([] if found or len(key) < 4 else errors_of(key))
    return [*(line for entry in errors for line in error_lines(entry, spoken)), *found]


def error_lines(entry: Entry, language: str) -> list[Line]:
    """An error of the catalogue, one line for each thing to know about it."""
    words = LABELS[language == "de"]
    source = f"axisgate ({entry.source})" if entry.ours else entry.source
    known = (entry.cause, entry.todo, entry.reset_words(), entry.shown)
    name = f"{entry.family} {entry.number}"
    return [
        Line(name, entry.text.text(language), "", source),
        *(Line(f"  {label}", each.text(language)) for label, each in zip(words, known, strict=True)),
    ]


def unknown(key: str, cell: Cell | None) -> str:
    """Why nothing was found."""
    if re.fullmatch(r"[Pp]\d+", key):
        return f"the rho 3 has no machine parameter {key.upper()}"
    if cell is None:
        return "no word, address, P number, decision or error of that name; keys of a cell need --cell CELL"
    return f"no such key, word or address; keys begin with axis.{cell.axis[0].name if cell.axis else 'NAME'}, line., bus., db., cell."


def table(lines: list[Line]) -> list[str]:
    """Columns: key, value with unit, source."""
    values = [f"{line.value} {line.unit}".strip() for line in lines]
    widths = max(len(line.key) for line in lines), min(44, max(len(value) for value in values))
    rows = zip(lines, values, strict=True)
    return [f"{line.key:<{widths[0]}}  {value:<{widths[1]}}  {line.source}".rstrip() for line, value in rows]
