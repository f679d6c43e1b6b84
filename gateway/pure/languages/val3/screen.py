"""The text page of s7: 14 lines of 40 characters (assumed)."""

from collections import deque
from dataclasses import dataclass, field

from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.strings import finite

COLUMNS, LINES = 40, 14
MOST_KEYS = 32  # that wait to be read; the oldest is dropped


@dataclass(slots=True)
class Screen:
    """Text, cursor, title."""

    lines: list[str] = field(default_factory=lambda: [" " * COLUMNS] * LINES)
    column: int = 0
    line: int = 0
    title: str = ""
    said: str = ""  # written since the last line began
    keys: "deque[float]" = field(default_factory=lambda: deque(maxlen=MOST_KEYS))

    def press(self, key: str) -> bool:
        """A character, or the number of a key code; False: neither."""
        code = code_of(key)
        if code is not None:
            self.keys.append(code)
        return code is not None

    def clear(self) -> None:
        """cls."""
        self.lines, self.column, self.line, self.said = [" " * COLUMNS] * LINES, 0, 0, ""

    def go(self, column: int, line: int) -> None:
        """gotoxy; 70 outside."""
        if not (0 <= column < COLUMNS and 0 <= line < LINES):
            raise Rte(70, f"gotoxy({column}, {line}): {COLUMNS} columns, {LINES} lines")
        self.column, self.line, self.said = column, line, ""

    def put(self, text: str) -> None:
        """Write at the cursor; a long text continues in the next line."""
        self.said = (self.said + text)[-COLUMNS * LINES :]
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


def code_of(key: str) -> float | None:
    """Code of a character, or a number that is one; None: neither."""
    return float(ord(key)) if len(key) == 1 else finite(key)
