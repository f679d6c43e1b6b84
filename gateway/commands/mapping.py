"""Convert mapping tables between a cell and PLC tools: CSV (semicolon, decimal comma), XLSX, the assignment list Z0.SEQ."""

import argparse
import pathlib
import zipfile
from collections.abc import Iterable

from gateway.files.signal_lists import signal_list
from gateway.pure.cell.cell import Cell
from gateway.pure.image.addresses import pic
from gateway.tools.cell_argument import load
from gateway.tools.command_support import DONE, ENVIRONMENT, FINDING, USAGE
from gateway.tools.mapping_tables import (
    COLUMNS,
    MappingFault,
    Row,
    from_cells,
    from_csv,
    from_sequence,
    to_cells,
    to_csv,
    to_sequence,
    to_toml,
)
from gateway.tools.usage_language import complain

EXAMPLES = """examples:
  axisgate mapping s5-rk512 blocks.csv               entries and routes of a cell, to be read in a spreadsheet
  axisgate mapping demo signals.seq --encoding cp437  the signals of the interface as an assignment list for STEP 5
  axisgate mapping blocks.xlsx tables.toml           [[db]] and [[route]] tables for a cell file; then: axisgate check CELL
"""
ENCODINGS = ("utf-8-sig", "cp437", "cp850")
SHEET = "mapping"


def main(argv: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="axisgate mapping", description=__doc__, epilog=EXAMPLES, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("source", help="a cell, or FILE.csv, FILE.xlsx, FILE.seq")
    parser.add_argument("target", type=pathlib.Path, help="FILE.csv, FILE.xlsx, FILE.seq or FILE.toml")
    parser.add_argument("--encoding", choices=ENCODINGS, default="utf-8-sig", help="of CSV and SEQ; default UTF-8 with BOM")
    arguments = parser.parse_args(argv)
    kind = arguments.target.suffix.lower()
    if kind not in (".csv", ".xlsx", ".seq", ".toml"):
        complain("mapping", f"{arguments.target}: ends in .csv, .xlsx, .seq or .toml")
        return USAGE
    try:
        rows = _read(arguments.source, arguments.encoding)
        if isinstance(rows, int):
            return rows
        written = _write(arguments.target, rows, arguments.encoding)
    except MappingFault as fault:
        complain("mapping", f"{arguments.source}: {fault}")
        return USAGE
    except UnicodeError as fault:
        complain("mapping", f"{arguments.encoding} does not fit: {fault}; try --encoding {' or '.join(ENCODINGS)}")
        return USAGE
    except OSError as fault:
        complain("mapping", fault)
        return ENVIRONMENT
    print(f"{arguments.target}: {written} rows")
    return DONE if written else FINDING


def _read(source: str, encoding: str) -> list[Row] | int:
    suffix = pathlib.Path(source).suffix.lower()
    if suffix == ".xlsx":
        import openpyxl  # heavy, and nothing else needs it
        from openpyxl.utils.exceptions import InvalidFileException

        try:
            book = openpyxl.load_workbook(source, read_only=True, data_only=True)
        except (InvalidFileException, zipfile.BadZipFile, KeyError, ValueError) as fault:
            raise MappingFault(f"no XLSX file: {fault}") from None
        return from_cells(book.worksheets[0].iter_rows(values_only=True))
    if suffix in (".csv", ".seq"):
        text = pathlib.Path(source).read_bytes().decode(encoding)
        return from_csv(text) if suffix == ".csv" else from_sequence(text)
    cell = load(source)
    return cell if isinstance(cell, int) else rows_of(cell)


def rows_of(cell: Cell) -> list[Row]:
    """Data blocks with their entries, routes, and the signals of the interface."""
    rows = [
        Row(
            "block", str(block.number), block.kind, block.line, words=str(block.words), writer=block.writer,
            every_ms=_whole(block.every_ms), on_change="1" if block.on_change else "",
            at_partner=block.at_partner, flag=block.flag, comment=block.comment,
        )
        for block in cell.db
    ]  # fmt: skip
    rows += [
        Row(
            "db", str(block.number), block.kind, block.line, at=entry.at, type=entry.type, to=entry.to or "", from_=entry.from_ or "",
            unit="" if entry.unit == "1" else entry.unit, min=_number(entry.min), max=_number(entry.max), edge=entry.edge or "",
            comment=entry.comment,
        )
        for block in cell.db
        for entry in block.entries
    ]  # fmt: skip
    rows += [
        Row(
            "route", name=route.name, type=route.type, to=route.to, from_=route.from_, to_type=route.to_type,
            edge="" if route.edge == "level" else route.edge, scale="" if route.scale == 1 else _number(route.scale),
            offset="" if route.offset == 0 else _number(route.offset), on_loss=route.on_loss,
            loss_value=_number(route.loss_value) if route.on_loss == "value" else "", loss_after_ms=_whole(route.loss_after_ms),
            order="" if route.order == "ABCD" else route.order, to_order="" if route.to_order == "ABCD" else route.to_order,
            pulse_ms="" if route.edge in ("level", "change") else str(route.pulse_ms), debounce_ms=_whole(route.debounce_ms),
            every_ms=_whole(route.every_ms), within_ms=_whole(route.within_ms), valid=route.valid, life=route.life, comment=route.comment,
        )
        for route in cell.route
    ]  # fmt: skip
    return rows + [Row("symbol", name=signal.name, at=_german(pic(signal.at)), comment=signal.de) for signal in signal_list().all]


def _german(operand: str) -> str:
    """I8.0 -> E 8.0, O3.2 -> A 3.2: the form of old STEP 5."""
    return f"{'E' if operand[0] == 'I' else 'A'} {operand[1:]}"


def _whole(value: int) -> str:
    """Empty for 0."""
    return str(value) if value else ""


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.9g}"


def _write(target: pathlib.Path, rows: list[Row], encoding: str) -> int:
    """How many rows are in the file."""
    match target.suffix.lower():
        case ".seq":
            text = to_sequence(rows)
            target.write_bytes(text.encode("cp437" if encoding == "utf-8-sig" else encoding))
            return text.count("\r\n")
        case ".toml":
            target.write_text(to_toml(rows))
            return len(rows)
    tables = [row for row in rows if row.table != "symbol"] or rows
    if target.suffix.lower() == ".csv":
        target.write_bytes(to_csv(tables).encode(encoding))
    else:
        _write_xlsx(target, tables)
    return len(tables)


def _write_xlsx(target: pathlib.Path, rows: Iterable[Row]) -> None:
    import openpyxl

    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.title = SHEET
    sheet.append(list(COLUMNS))
    for row in rows:
        sheet.append(to_cells(row))
    book.save(target)
