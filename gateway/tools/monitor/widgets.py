"""Tables that change in place, and the page of keys."""

from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.coordinate import Coordinate
from textual.screen import ModalScreen
from textual.widgets import DataTable, Static

from gateway.tools.monitor.tables import Table

STYLES = {"bad": "bold red", "warn": "yellow", "old": "dim"}


class LiveTable(DataTable[Text]):
    """Only changed and visible cells are drawn again; the cursor stays on its line."""

    def __init__(self, name: str) -> None:
        super().__init__(cursor_type="row", zebra_stripes=True, id=name)
        self._columns: tuple[str, ...] = ()
        self._drawn: list[tuple[tuple[str, ...], str]] = []  # rows with their marks as shown in the widget

    def show(self, table: Table) -> None:
        """A table with other columns or another number of rows is rebuilt."""
        self.border_title = table.title
        marks = table.marks or ("",) * len(table.rows)
        rows = list(zip(table.rows, marks, strict=True)) or [((table.empty or "none", *[""] * (len(table.columns) - 1)), "")]
        if self._columns != table.columns or len(self._drawn) != len(rows):
            self._build(table.columns, rows)
            return
        first = max(int(self.scroll_offset.y) - 1, 0)
        for y in range(first, min(first + max(self.size.height, 1) + 2, len(rows))):
            if rows[y] != self._drawn[y]:
                self._redraw(y, *rows[y])

    def _redraw(self, y: int, row: tuple[str, ...], mark: str) -> None:
        last, before = self._drawn[y]
        for x, cell in enumerate(row):
            if cell != last[x] or mark != before:
                self.update_cell_at(Coordinate(y, x), Text(cell, STYLES.get(mark, "")), update_width=len(cell) > len(last[x]))
        self._drawn[y] = row, mark

    def _build(self, columns: tuple[str, ...], rows: list[tuple[tuple[str, ...], str]]) -> None:
        at = self.cursor_row
        self.clear(columns=self._columns != columns)
        if self._columns != columns:
            self.add_columns(*columns)
        self._columns, self._drawn = columns, rows
        for row, mark in rows:
            self.add_row(*(Text(cell, STYLES.get(mark, "")) for cell in row))
        self.move_cursor(row=min(at, len(rows) - 1))


class Help(ModalScreen[None]):
    """All keys; any of them closes it."""

    BINDINGS: ClassVar[list[BindingType]] = [("escape,question_mark,q,enter,space", "dismiss", "close")]
    CSS = "Help { align: center middle; } #keys { width: auto; height: auto; border: round $primary; padding: 1 2; background: $panel; }"

    def __init__(self, words: str) -> None:
        super().__init__()
        self._words = words

    def compose(self) -> ComposeResult:
        yield Static(self._words, id="keys", markup=False)
