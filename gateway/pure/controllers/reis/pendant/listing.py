"""The lines of a directory or a program with the cursor, as the PHG scrolls them.  Source: robotstar 8.2 (L1058-1096, L1466-1488)."""

from dataclasses import dataclass, field

WIDE, HIGH = 20, 15  # columns and lines with SHIFT (L1062, L1092)
NUMBER = 5  # cursor and number of the step


@dataclass(slots=True)
class Listing:
    """path: of the directory or the program below S:/; rows: step 1 is the head; cursor: number of a step; column: first one shown."""

    path: str = ""
    rows: tuple[str, ...] = ()
    cursor: int = 1
    column: int = 0
    program: bool = False
    names: tuple[str, ...] = field(default=())  # of a directory: the entry of each row; "" is none

    def move(self, key: str, shift: str, width: int) -> None:
        """An arrow key, after SHIFT or ALT ("" for neither)."""
        if key in ("UP", "DOWN"):
            far = {"SHIFT": HIGH, "ALT": len(self.rows)}.get(shift, 1)
            self.go(self.cursor + (far if key == "DOWN" else -far))
            return
        room = max(width - NUMBER, 1)
        if shift == "ALT":
            self.column = 0 if key == "LEFT" else max(len(self.now) - (room if self.program else room // 2), 0)
            return
        far = WIDE if shift == "SHIFT" else 1
        longest = max((len(row) for row in self.rows), default=0)
        self.column = min(max(self.column + (far if key == "RIGHT" else -far), 0), max(longest - 1, 0))

    @property
    def now(self) -> str:
        """The row of the cursor."""
        return self.rows[self.cursor - 1] if self.rows else ""

    def go(self, step: int) -> None:
        """The cursor on a step, at most the first or the last one."""
        self.cursor = min(max(step, 1), max(len(self.rows), 1))

    def find(self, words: str) -> bool:
        """Go to the next row after the cursor with these characters, wrapping to the top; False: none has them."""
        order = [*range(self.cursor, len(self.rows)), *range(self.cursor)]
        found = next((at for at in order if words.upper() in self.rows[at].upper()), None)
        if found is not None:
            self.cursor = found + 1
        return found is not None

    def shown(self, height: int, width: int, done: int = 0) -> list[str]:
        """The window around the cursor; `done`: the step that was executed last, marked by "-" (L1484)."""
        first = min(max(self.cursor - 1 - height // 2, 0), max(len(self.rows) - height, 0))
        return [self._row(at, width, done) for at in range(first, min(first + height, len(self.rows)))]

    def _row(self, at: int, width: int, done: int) -> str:
        mark = ">" if at + 1 == self.cursor else "-" if at + 1 == done else " "
        return f"{mark}{at + 1:>3} {self.rows[at][self.column :]}"[:width]
