"""Tables for people and for spreadsheets: one table, four formats.

CSV is what German spreadsheets open with a double click: semicolon, decimal comma, UTF-8 with a byte-order mark (users.md 3.2).
"""

import html
import json
from collections.abc import Sequence
from dataclasses import dataclass

Cell = str | int | float | None
FORMS = ("md", "csv", "json", "html")
BOM = "\ufeff"
STYLE = (
    "@page{size:A4 landscape;margin:12mm}body{font:12px sans-serif}h1{font-size:16px}h2{font-size:14px}"
    "table{border-collapse:collapse;width:100%}th,td{border:1px solid #888;padding:1px 5px;text-align:left;vertical-align:top}"
    "th{background:#eee}thead{display:table-header-group}tr{break-inside:avoid}"
)


@dataclass(frozen=True, slots=True)
class Sheet:
    """A titled table; every row has one cell for each column."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""


def render(name: str, sheets: Sequence[Sheet], form: str, footer: str = "") -> str:
    """All tables of one document `name` in one of FORMS."""
    match form:
        case "md":
            return _markdown(name, sheets, footer)
        case "csv":
            return BOM + "\r\n".join(line for sheet in sheets for line in _csv(sheet)) + "\r\n"
        case "json":
            return json.dumps({"name": name, "sheets": [_plain(sheet) for sheet in sheets]}, indent=1, ensure_ascii=False) + "\n"
    return _html(name, sheets, footer)


def _plain(sheet: Sheet) -> dict[str, object]:
    rows = [dict(zip(sheet.columns, row, strict=True)) for row in sheet.rows]
    return {"title": sheet.title, "note": sheet.note, "rows": rows}


def _text(cell: Cell) -> str:
    if isinstance(cell, float):
        return f"{cell:.9g}"
    return "" if cell is None else str(cell)


def _markdown(name: str, sheets: Sequence[Sheet], footer: str) -> str:
    lines = [f"# {name}", ""]
    for sheet in sheets:
        lines += [f"## {sheet.title}", "", *([sheet.note, ""] if sheet.note else [])]
        lines += ["| " + " | ".join(sheet.columns) + " |", "|" + "---|" * len(sheet.columns)]
        lines += ["| " + " | ".join(_text(cell).replace("|", "\\|") for cell in row) + " |" for row in sheet.rows]
        lines.append("")
    return "\n".join([*lines, *([footer, ""] if footer else [])])


def _csv(sheet: Sheet) -> list[str]:
    def field(cell: Cell) -> str:
        text = _text(cell).replace(".", ",") if isinstance(cell, float) else _text(cell)
        return '"' + text.replace('"', '""') + '"' if any(mark in text for mark in ';"\r\n') else text

    return [sheet.title, ";".join(map(field, sheet.columns)), *(";".join(map(field, row)) for row in sheet.rows), ""]


def _html(name: str, sheets: Sequence[Sheet], footer: str) -> str:
    parts = [f'<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>{html.escape(name)}</title><style>{STYLE}</style>']
    parts.append(f"<h1>{html.escape(name)}</h1>")
    for sheet in sheets:
        parts.append(f"<h2>{html.escape(sheet.title)}</h2>" + (f"<p>{html.escape(sheet.note)}</p>" if sheet.note else ""))
        parts.append("<table><thead><tr>" + "".join(f"<th>{html.escape(column)}" for column in sheet.columns) + "</thead>")
        parts += ["<tr>" + "".join(f"<td>{html.escape(_text(cell))}" for cell in row) for row in sheet.rows]
        parts.append("</table>")
    return "\n".join([*parts, f"<p>{html.escape(footer)}</p></html>", ""])
