"""Check a cell file: reports all errors, warnings and notes in one run."""

import argparse
import dataclasses
import json
import os
import sys

from gateway.cell_file.load import load_cell
from gateway.checks.playable import not_playable
from gateway.files.find import ConfigNotFound
from gateway.files.texts import read_texts, spoken
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults, Fault
from gateway.pure.lines.texts import LANGUAGES, language_of
from gateway.pure.reports.sentences import Sentence, in_language
from gateway.runtime.exit_codes import Exit
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate check cell.toml            all errors, warnings and notes of a file
  axisgate check demo                 a shipped cell by its name: demo, s5-rk512, rho3-servodyn
  axisgate check cell.toml --json     the same as JSON
exit code: 0 valid, 1 valid but --strict found a warning, 2 file or command line invalid"""
TEXTS = read_texts("check")
COLOURS = {"error": "\033[31m", "warning": "\033[33m", "note": "\033[36m"}


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate check", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cell", metavar="CELL", help="cell file, or the name of a shipped one")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--strict", action="store_true", help="exit 1 when there are warnings")
    parser.add_argument("--language", choices=LANGUAGES, help="language of the report (default: the system's)")
    options = parser.parse_args(argv)
    language = language_of(options.language, dict(os.environ))
    try:
        cell = load_cell(options.cell)
    except CellFaults as found:
        rows = fault_lines(options.cell, found.faults, language)
        print(json.dumps(as_json(options.cell, found.faults), indent=1) if options.json else "\n".join(rows))
        return Exit.INVALID
    except (ConfigNotFound, OSError) as error:
        complain("check", error)
        return Exit.INVALID
    print(json.dumps(valid_json(cell), indent=1) if options.json else "\n".join(valid(options.cell, cell, language)))
    return Exit.FINDING if options.strict and cell.warnings else Exit.OK


def valid(name: str, cell: Cell, language: str = "en") -> list[str]:
    """The lines for a valid file."""
    parts = [_counted(len(cell.axis), "axis", "axes"), _counted(len(cell.line), "line", "lines"), _counted(len(cell.bus), "bus", "buses")]
    found = [_counted(len(cell.warnings), "warning", "warnings"), _counted(len(cell.notes), "note", "notes")]
    rows = [(notice.level, _said(notice.where, language), _said(notice.text, language)) for notice in cell.notices]
    lines = [TEXTS.said("valid", name, *parts, *found)]
    if not_playable(cell) or not cell.axis:
        last = TEXTS.said("explain", name, f"axis.{cell.axis[0].name}" if cell.axis else "cell")
    else:
        last = TEXTS.said("next", name, cell.axis[0].name)
    notice_lines = [f"{_level(level, language)}{where}: {text}" for level, where, text in rows]
    return [*(in_language(line, language) for line in lines), *notice_lines, in_language(last, language)]


def fault_lines(name: str, faults: tuple[Fault, ...], language: str = "en") -> list[str]:
    """The lines for a file with faults."""
    crossed = sum(fault.kind == "cross" for fault in faults)
    count = _counted(len(faults), "error", "errors")
    head = TEXTS.said("errors", name, count, len(faults) - crossed, crossed) if crossed else TEXTS.said("only_errors", name, count)
    rows = [_level("error", language) + _fault(fault, language) for fault in faults]
    return [in_language(head, language), *rows, in_language(TEXTS.said("correct", name), language)]


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
        "not_playable": not_playable(cell),
    }


def _said(text: str, language: str) -> str:
    """A notice or a hint; one that was made in both languages, or is found by its words."""
    if language != "de" or isinstance(text, Sentence):
        return in_language(text, language)
    return spoken("check-notices", "val3-files").german(text)


def _fault(fault: Fault, language: str) -> str:
    """File, line, key and value stay as they are in the file."""
    if language != "de":
        return str(fault)
    allowed = f": {_said(f'allowed {fault.range} {fault.unit}'.strip(), language)}" if fault.range else ""
    bare = str(dataclasses.replace(fault, range="", hint=""))
    return f"{bare}{allowed}{': ' if fault.hint else ''}{_said(fault.hint, language)}"


def _counted(count: int, one: str, many: str) -> Sentence:
    return TEXTS.said(f"one_{one}" if count == 1 else f"some_{many}", count)


def _level(level: str, language: str) -> str:
    """The level in a column of nine characters, coloured only on a terminal."""
    word = in_language(TEXTS.said(level), language)
    if sys.stdout.isatty() and not os.environ.get("NO_COLOR"):
        return f"{COLOURS[level]}{word:<9}\033[0m"
    return f"{word:<9}"
