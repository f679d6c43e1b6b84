"""The text page of s7: 14 lines of 40 characters (assumed)."""

from dataclasses import dataclass, field

from gateway.pure.languages.val3.errors import Rte

COLUMNS, LINES = 40, 14


@dataclass(slots=True)
class Screen:
    """Text, cursor, title."""

    lines: list[str] = field(default_factory=lambda: [" " * COLUMNS] * LINES)
    column: int = 0
    line: int = 0
    title: str = ""

    def clear(self) -> None:
        """cls."""
        self.lines, self.column, self.line = [" " * COLUMNS] * LINES, 0, 0

    def go(self, column: int, line: int) -> None:
        """gotoxy; 70 outside."""
        if not (0 <= column < COLUMNS and 0 <= line < LINES):
            raise Rte(70, f"gotoxy({column}, {line}): {COLUMNS} columns, {LINES} lines")
        self.column, self.line = column, line

    def put(self, text: str) -> None:
        """At the cursor; what is too long runs on into the next line."""
        for letter in text:
            if self.column >= COLUMNS:
                self.newline()
            row = self.lines[self.line]
            self.lines[self.line] = row[: self.column] + letter + row[self.column + 1 :]
            self.column += 1

    def newline(self) -> None:
        """The last line scrolls."""
        self.column = 0
        if self.line + 1 < LINES:
            self.line += 1
        else:
            self.lines = [*self.lines[1:], " " * COLUMNS]
