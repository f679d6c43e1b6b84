"""The 256 x 128 pixels of a PHG 2000, written by programs in transparent mode.  Source: rho 3 Releases L9166-9202, L9474-9886; AX-1042.

An output that is meant for another mask than the one that is shown is discarded, -1 is always shown (L9582-9586).
"""

from dataclasses import dataclass, field

from gateway.pure.controllers.rho3.pendant.frames import EVERY_MASK, Command, FrameError, Part, parse
from gateway.pure.controllers.rho3.pendant.operation import operation

SIZES = ((6, 8), (9, 11))  # of a character, by character set
COLUMNS, ROWS = 42, 16  # of the small set
MOST_BYTES, MOST_LINES = 4096, 100


@dataclass(slots=True)
class Screen2000:
    """`take` receives the output of a WRITE."""

    p35: int = 0
    mask: int = 0  # that is shown
    dropped: int = 0  # outputs meant for another one
    fault: str = ""  # of the last output
    refreshed: dict[int, int] = field(default_factory=dict)  # variable list -> line of its cursor
    lines: list[tuple[int, ...]] = field(default_factory=list)
    _letters: dict[tuple[int, int], str] = field(default_factory=dict)  # pixel -> character
    _x: int = 0
    _y: int = 0
    _set: int = 0
    _held: bytearray = field(default_factory=bytearray)

    def take(self, data: bytes, *, more: bool) -> None:
        """Process a piece of an output; more: it continues."""
        self._held += data[: MOST_BYTES - len(self._held)]
        if more:
            return
        output, self._held = bytes(self._held), bytearray()
        if not operation(self.p35).transparent:
            self.fault = "P35 = 1: the pendant works as a PHG 3, which has no transparent output"
            return
        try:
            mask, parts = parse(output)
        except FrameError as error:
            self.fault = str(error)
            return
        self.fault = ""
        if mask not in (EVERY_MASK, self.mask):
            self.dropped += 1
            return
        for part in parts:
            self._do(part)

    def _do(self, part: Part) -> None:
        words = [int.from_bytes(part.data[at : at + 2], "little") for at in range(0, len(part.data) - 1, 2)]
        match part.command:
            case Command.CLS:
                self._letters.clear()
                self.lines.clear()
                self._x = self._y = 0
            case Command.GOTOXY:
                self._x, self._y = words
            case Command.N_MASKE:
                self.mask = words[0]
            case Command.CHARSET:
                self._set = part.data[0] & 1
            case Command.TEXT:
                self._text(part.data.partition(b"\0")[0].decode("cp437"))
            case Command.ZEI_REL:
                columns, rows = (int.from_bytes(part.data[at : at + 1], signed=True) for at in (0, 1))
                width, height = SIZES[self._set]
                self._x, self._y = self._x + columns * width, self._y + rows * height
            case Command.REFRESH:
                self.refreshed[words[0]] = words[1]
            case Command.LINIE:
                self.lines = [*self.lines, tuple(words)][-MOST_LINES:]

    def _text(self, text: str) -> None:
        for letter in text:
            self._letters[self._x, self._y] = letter
            self._x += SIZES[self._set][0]

    def shown(self) -> dict[str, object]:
        """Its characters in rows and columns of the small set, and what else was written."""
        grid = [[" "] * COLUMNS for _ in range(ROWS)]
        for (x, y), letter in self._letters.items():
            if 0 <= x // 6 < COLUMNS and 0 <= y // 8 < ROWS:
                grid[y // 8][x // 6] = letter
        rows = ["".join(row).rstrip() for row in grid]
        cursors = {str(code): line for code, line in self.refreshed.items()}
        return {
            "mask": self.mask, "rows": rows, "lines": [list(line) for line in self.lines], "cursors": cursors,
            "dropped": self.dropped, "fault": self.fault,
        }  # fmt: skip
