"""Import old data into a cell file: `axisgate import p-list FILE` reads the printed machine-parameter list of a rho 3."""

import argparse
import dataclasses
import json
import pathlib
import sys

from gateway.cell_file.load import load_cell
from gateway.pure.cell.faults import CellFaults
from gateway.pure.controllers.rho3.parameter_list.cell_file import Report, import_list
from gateway.runtime.exit_codes import Exit
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate import p-list plist.txt                     the cell file on standard output, the report on standard error
  axisgate import p-list plist.txt -o robot2.toml      both: the file there, the report here; then: axisgate check robot2.toml
  axisgate import p-list plist.txt --json              file and report for a program
exit code: 0 the file passes `axisgate check`, 1 it does not yet (the report lists what is missing), 2 nothing to read"""


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        "axisgate import", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("kind", choices=("p-list",), help="p-list: P1..P615 as printed, typed or scanned, one value a line")
    parser.add_argument("file", type=pathlib.Path, metavar="FILE", help="text file, UTF-8 or cp1252")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="CELL", help="write the cell file there")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args(argv)
    try:
        text = _read(options.file)
    except OSError as error:
        complain("import", f"{options.file}: {error.strerror or error}")
        return Exit.INVALID
    cell, report = import_list(text, options.output.stem if options.output else options.file.stem)
    if not report.taken:
        complain("import", f"{options.file}: no machine parameter was recognised in {len(text.splitlines())} lines")
        return Exit.INVALID
    faults = check(cell)
    if options.output:
        options.output.write_text(cell)
    if options.json:
        print(json.dumps({"cell": cell, **dataclasses.asdict(report), "faults": faults}, indent=1))
    else:
        if not options.output:
            print(cell)
        print("\n".join(report_lines(report, faults, options.output)), file=sys.stdout if options.output else sys.stderr)
    return Exit.FINDING if faults or report.missing else Exit.OK


def _read(path: pathlib.Path) -> str:
    data = path.read_bytes()
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def check(cell: str) -> list[str]:
    """Faults that `axisgate check` finds in the file."""
    try:
        load_cell("cell.toml", cell)
    except CellFaults as found:
        return [str(fault) for fault in found.faults]
    return []


def report_lines(report: Report, faults: list[str], output: pathlib.Path | None) -> list[str]:
    """The report for a person."""
    lines = [f"{len(report.taken)} values taken, {len(report.assumed)} assumptions, {len(report.ignored)} lines left aside"]
    for word, entries in (("assumed", report.assumed), ("missing", report.missing), ("ignored", report.ignored), ("check", faults)):
        lines += [f"{word:<8} {entry}" for entry in entries]
    return [*lines, f"next: axisgate check {output}" if output else "next: axisgate import p-list FILE -o cell.toml"]
