"""Mapping tables as rows: entries of data blocks, routes, symbols; to and from CSV text and the assignment list of STEP 5 (AX-405).

CSV: semicolon, decimal comma, first line the column names; what users of a German spreadsheet save.  Z0.SEQ: operand, symbol and comment of
one line, between them a tabulator or at least two blanks.
"""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields

NUMBERS = ("min", "max", "scale", "offset")
TABLES = ("db", "route", "symbol")
OPERANDS = "EAMTZIQFC"
SYMBOL_CHARACTERS = 24  # longest symbol STEP 5 takes
SEQUENCE_COMMENT = 40


class MappingFault(ValueError):
    """A table that cannot be read; the message names line and column."""


@dataclass(frozen=True, slots=True)
class Row:
    """One line; an empty field says nothing.  Numbers are text with a decimal point."""

    table: str  # db | route | symbol
    block: str = ""  # number of the data block
    name: str = ""  # of a route, or a symbol
    at: str = ""  # place in the block, or operand
    type: str = ""
    to: str = ""
    from_: str = ""
    to_type: str = ""
    unit: str = ""
    min: str = ""
    max: str = ""
    edge: str = ""
    scale: str = ""
    offset: str = ""
    on_loss: str = ""
    comment: str = ""


COLUMNS = tuple(field.name.rstrip("_") for field in fields(Row))


def to_cells(row: Row) -> list[str]:
    """As a spreadsheet shows it: decimal comma, also in units (0,1 mm)."""
    return [_comma(name, getattr(row, field.name)) for name, field in zip(COLUMNS, fields(Row), strict=True)]


def _comma(name: str, text: str) -> str:
    return text.replace(".", ",") if name in NUMBERS or name == "unit" else text


def from_cells(lines: Iterable[Sequence[object]]) -> list[Row]:
    """The first line names the columns, in any order; unknown ones are a fault.  Raises MappingFault."""
    rows: list[Row] = []
    heads: list[str] | None = None
    for number, line in enumerate(lines, 1):
        cells = [("" if cell is None else f"{cell:g}" if isinstance(cell, float) else str(cell)).strip() for cell in line]
        if not any(cells):
            continue
        if heads is None:
            heads = [cell.lower() for cell in cells]
            unknown = [head for head in heads if head and head not in COLUMNS]
            if unknown or "table" not in heads:
                raise MappingFault(f"line {number}: columns {', '.join(unknown) or 'without table'}; known are {', '.join(COLUMNS)}")
            continue
        rows.append(_row(number, dict(zip(heads, cells, strict=False))))
    return rows


def _row(number: int, cells: Mapping[str, str]) -> Row:
    if cells.get("table") not in TABLES:
        raise MappingFault(f"line {number}, table: {cells.get('table')!r}; {' | '.join(TABLES)}")
    values: dict[str, str] = {}
    for name in COLUMNS:
        text = cells.get(name, "")
        if name in NUMBERS or name == "unit":
            text = text.replace(",", ".")
        if name in NUMBERS and text:
            try:
                float(text)
            except ValueError:
                raise MappingFault(f"line {number}, {name}: {cells[name]!r} is no number") from None
        values["from_" if name == "from" else name] = text
    return Row(**values)


def to_csv(rows: Iterable[Row]) -> str:
    """CRLF, semicolons."""
    out = io.StringIO()
    writer = csv.writer(out, delimiter=";", lineterminator="\r\n")
    writer.writerow(COLUMNS)
    writer.writerows(to_cells(row) for row in rows)
    return out.getvalue()


def from_csv(text: str) -> list[Row]:
    """Raises MappingFault."""
    return from_cells(csv.reader(io.StringIO(text.removeprefix("\ufeff")), delimiter=";"))


def to_sequence(rows: Iterable[Row]) -> str:
    """Symbols only: the list knows nothing of data words."""
    found = [row for row in rows if row.table == "symbol"]
    return "".join(f"{row.at}\t{row.name[:SYMBOL_CHARACTERS]}\t{row.comment[:SEQUENCE_COMMENT]}".rstrip() + "\r\n" for row in found)


def from_sequence(text: str) -> list[Row]:
    """Raises MappingFault for a line without operand and symbol; an end mark 1Ah of old editors ends the text."""
    rows: list[Row] = []
    for number, line in enumerate(text.partition("\x1a")[0].splitlines(), 1):
        if not line.strip() or line.lstrip().startswith(";"):
            continue
        parts = [part.strip() for part in (line.split("\t") if "\t" in line else line.replace("  ", "\t").split("\t")) if part.strip()]
        if len(parts) < 2 or parts[0][0].upper() not in OPERANDS:
            raise MappingFault(f"line {number}: operand, symbol and comment expected, as E 8.0 <tab> READY <tab> ready: {line.strip()!r}")
        rows.append(Row("symbol", name=parts[1], at=parts[0], comment=" ".join(parts[2:])))
    return rows


# ---- to a cell file --------------------------------------------------------------------------------------------------


def to_toml(rows: Sequence[Row]) -> str:
    """[[db]] and [[route]] tables, to be put into a cell file; symbols as remarks above them."""
    lines = [f"# {row.at:<10}{row.name:<26}{row.comment}".rstrip() for row in rows if row.table == "symbol"]
    for block in dict.fromkeys(row.block for row in rows if row.table == "db"):
        entries = [row for row in rows if row.table == "db" and row.block == block]
        ours = all(row.from_ for row in entries)
        words = 1 + max(_last_word(row.at) for row in entries)
        lines += ["", "[[db]]", f"number  = {block}", f"words   = {words}", f'writer  = "{"axisgate" if ours else "plc"}"', "entries = ["]
        lines += [f"  {{ {', '.join(_entry(row))} }}," for row in entries]
        lines.append("]")
    for row in rows:
        if row.table == "route":
            lines += ["", "[[route]]", *_route(row)]
    return "\n".join(lines).lstrip("\n") + "\n"


def _last_word(at: str) -> int:
    digits = at.rsplit(maxsplit=1)[-1].partition(".")[0]
    return (int(digits) if digits.isdecimal() else 0) + at.startswith("DD")


def _entry(row: Row) -> list[str]:
    pairs = [f"at = {_text(row.at)}", f"type = {_text(row.type)}"]
    pairs += [
        f"{key} = {_text(value)}" for key, value in (("to", row.to), ("from", row.from_), ("unit", row.unit), ("edge", row.edge)) if value
    ]
    pairs += [f"{key} = {_number(value)}" for key, value in (("min", row.min), ("max", row.max)) if value]
    return pairs + ([f"comment = {_text(row.comment)}"] if row.comment else [])


def _route(row: Row) -> list[str]:
    texts = (("name", row.name), ("from", row.from_), ("to", row.to), ("type", row.type), ("to_type", row.to_type), ("edge", row.edge))
    lines = [f"{key} = {_text(value)}" for key, value in (*texts, ("on_loss", row.on_loss)) if value]
    lines += [f"{key} = {_number(value)}" for key, value in (("scale", row.scale), ("offset", row.offset)) if value]
    return lines + ([f"comment = {_text(row.comment)}"] if row.comment else [])


def _text(value: str) -> str:
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _number(value: str) -> str:
    """A TOML float: 1 becomes 1.0."""
    return repr(float(value))
