"""Mapping tables as rows: data blocks, their entries, routes, symbols; to and from CSV text and the assignment list of STEP 5 (AX-405).

CSV: semicolon, decimal comma, first line the column names; as saved by a German spreadsheet.  Z0.SEQ: operand, symbol and comment of
one line, between them a tabulator or at least two blanks.
"""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields

NUMBERS = ("min", "max", "scale", "offset", "loss_value")
WHOLE = ("words", "every_ms", "pulse_ms", "debounce_ms", "within_ms", "loss_after_ms")
TABLES = ("block", "db", "route", "symbol")
NEEDED = {"block": ("block", "words", "writer"), "db": ("block", "at"), "route": ("name",), "symbol": ("name",)}
OPERANDS = "EAMTZIQFC"
SYMBOL_CHARACTERS = 24  # longest symbol STEP 5 accepts
SEQUENCE_COMMENT = 40


class MappingFault(ValueError):
    """A table that cannot be read; the message names line and column."""


@dataclass(frozen=True, slots=True)
class Row:
    """One line; an empty field has no meaning.  Numbers are text with a decimal point."""

    table: str  # block | db (an entry of a block) | route | symbol
    block: str = ""  # number of the data block
    kind: str = ""  # of the block, as its line: blocks of one number on two lines are two
    line: str = ""
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
    loss_value: str = ""
    loss_after_ms: str = ""
    order: str = ""
    to_order: str = ""
    pulse_ms: str = ""
    debounce_ms: str = ""
    every_ms: str = ""
    within_ms: str = ""
    valid: str = ""
    life: str = ""
    words: str = ""  # of a block, as the four that follow
    writer: str = ""
    on_change: str = ""  # 1
    at_partner: str = ""
    flag: str = ""
    comment: str = ""

    @property
    def place(self) -> tuple[str, str, str]:
        """Identity of a block."""
        return self.block, self.kind or "D", self.line


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
                raise MappingFault(f"line {number}, {name}: {cells[name]!r} is not a number") from None
        if name in (*WHOLE, "block") and text and not text.isdecimal():
            raise MappingFault(f"line {number}, {name}: {cells[name]!r} is not a whole number")
        values["from_" if name == "from" else name] = text
    missing = next((name for name in NEEDED.get(values["table"], ()) if not values[name]), "")
    if missing:
        raise MappingFault(f"line {number}, {missing}: a row of table {values['table']} has it")
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
    for place in dict.fromkeys(row.place for row in rows if row.table in ("block", "db")):
        entries = [row for row in rows if row.table == "db" and row.place == place]
        said = next((row for row in rows if row.table == "block" and row.place == place), None)
        lines += ["", "[[db]]", *_block(said or _guessed(entries))]
        if entries:
            lines += ["entries = [", *(f"  {{ {', '.join(_entry(row))} }}," for row in entries), "]"]
    for row in rows:
        if row.table == "route":
            lines += ["", "[[route]]", *_route(row)]
    return "\n".join(lines).lstrip("\n") + "\n"


def _guessed(entries: Sequence[Row]) -> Row:
    """A block without a row of its own: its length follows from its last entry, and it is ours if every entry is."""
    first, ours = entries[0], all(row.from_ for row in entries)
    words = 1 + max(_last_word(row.at) for row in entries)
    return Row("block", first.block, first.kind, first.line, words=str(words), writer="axisgate" if ours else "plc")


def _block(row: Row) -> list[str]:
    lines = [f"number = {row.block}", f"words = {row.words}"]
    texts = (("writer", row.writer), ("kind", row.kind), ("line", row.line), ("at_partner", row.at_partner), ("flag", row.flag))
    lines += [f"{key} = {_text(value)}" for key, value in texts if value]
    lines += [f"every_ms = {row.every_ms}"] if row.every_ms else []
    lines += ["on_change = true"] if row.on_change else []
    return lines + ([f"comment = {_text(row.comment)}"] if row.comment else [])


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
    texts = ("name", "from", "to", "type", "order", "to_type", "to_order", "edge", "on_loss", "valid", "life")
    given = {name.rstrip("_"): getattr(row, name) for name in (field.name for field in fields(Row))}
    lines = [f"{key} = {_text(given[key])}" for key in texts if given[key]]
    lines += [f"{key} = {_number(given[key])}" for key in ("scale", "offset", "loss_value") if given[key]]
    lines += [f"{key} = {given[key]}" for key in WHOLE if given[key] and key != "words"]
    return lines + ([f"comment = {_text(row.comment)}"] if row.comment else [])


def _text(value: str) -> str:
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def _number(value: str) -> str:
    """A TOML float: 1 becomes 1.0."""
    return repr(float(value))
