"""Tables of the monitor: plain words in columns, for the screen, for a pipe and as JSON alike."""

import json
from collections.abc import Sequence
from dataclasses import dataclass

GAP = "  "


@dataclass(frozen=True, slots=True)
class Table:
    """`marks` of the rows: "", "old", "warn" or "bad"; each colours a row and is always also given in words."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...] = ()
    marks: tuple[str, ...] = ()
    empty: str = ""  # text shown instead of rows

    def records(self) -> list[dict[str, str]]:
        """Rows by column, for JSON."""
        return [dict(zip(self.columns, row, strict=True)) for row in self.rows]


def plain(table: Table, width: int = 0) -> str:
    """Left-aligned columns without a colour; `width`: longest line, 0 for any."""
    rows = [table.columns, *table.rows]
    sizes = [max(len(row[n]) for row in rows) for n in range(len(table.columns))]
    lines = [GAP.join(cell.ljust(size) for cell, size in zip(row, sizes, strict=True)).rstrip() for row in rows]
    if not table.rows:
        lines = [table.empty or "none"]
    return "\n".join([table.title, *(f"{GAP}{line}"[: width or None] for line in lines)])


def as_json(tables: dict[str, Table], head: dict[str, object]) -> str:
    """{"head": {..}, "axes": [{..}], ..}; every value a string as it is shown."""
    return json.dumps({"head": head, **{name: table.records() for name, table in tables.items()}}, ensure_ascii=False)


def number(value: object, decimals: int = 3) -> str:
    """A figure as it is read; nothing for nothing."""
    if isinstance(value, float):
        return f"{value:.{decimals}f}"
    return "" if value is None else str(value)


def sentence(words: Sequence[str]) -> str:
    """The non-empty words, joined."""
    return ", ".join(word for word in words if word)
