"""Timers and counters in one range of cells, with the functions of STEP 5.  Source: robotstar 5.3, L2440-2447, L2587-2616; AX-741."""

import struct
from dataclasses import dataclass

CELLS = 32
TICK_NS = 10_000_000  # 1/100 s
COUNT_HIGH = 999
NONE, PULSE, EXTENDED, ON_DELAY, OFF_DELAY, COUNTER = range(6)
KINDS = {"I": PULSE, "V": EXTENDED, "E": ON_DELAY, "A": OFF_DELAY}
KEPT = struct.Struct("<BBq")  # kind, flags, remaining ns or count


@dataclass(slots=True)
class Cell:
    """One long word.  `end` counts while `runs`; `level` is the result at the last start command, the edges are those of a counter."""

    kind: int = NONE
    end: int = 0
    count: int = 0
    runs: bool = False
    level: bool = False
    up: bool = False
    down: bool = False
    preset: bool = False
    cleared: bool = False  # since the last start command


class Cells:
    """The cells at the moment `now`, which the executor moves on."""

    def __init__(self) -> None:
        self.now = 0
        self._cells = [Cell() for _ in range(CELLS)]

    def timer(self, number: int) -> bool:
        """The state a query of the timer sees."""
        cell = self._cells[number]
        match cell.kind:
            case 1 | 2:
                return cell.runs and self.now < cell.end
            case 3:
                return cell.runs and self.now >= cell.end
            case 4:
                return (cell.level and not cell.cleared) or (cell.runs and self.now < cell.end)
        return False

    def counter(self, number: int) -> bool:
        """Whether the content is not 0."""
        return self.content(number) != 0

    def content(self, number: int) -> int:
        """Return the count, or the remaining time in 1/100 s, rounded up."""
        cell = self._cells[number]
        if cell.kind == COUNTER:
            return cell.count
        return max(0, -((self.now - cell.end) // TICK_NS)) if cell.runs else 0

    def is_counter(self, number: int) -> bool:
        """Whether the cell was last used as a counter."""
        return self._cells[number].kind == COUNTER

    def start(self, number: int, name: str, result: bool, time: int) -> None:
        """Start command of a timer with `time` in 1/100 s; each kind looks at the edges of the result on its own."""
        kind, cell = KINDS[name], self._cells[number]
        if cell.kind != kind:
            if not result:
                return
            self._become(cell, kind)
        rises, falls = result and not cell.level, cell.level and not result
        cell.level, cell.cleared = result, False
        if falls if kind == OFF_DELAY else rises:
            cell.runs, cell.end = True, self.now + max(0, time) * TICK_NS
        elif (kind in (PULSE, ON_DELAY) and not result) or (kind == OFF_DELAY and result):
            cell.runs = False

    def count(self, number: int, result: bool, step: int) -> None:
        """Counts at a rising edge of the result, between 0 and 999."""
        cell = self._counter(number, result)
        if cell is None:
            return
        before = cell.up if step > 0 else cell.down
        if step > 0:
            cell.up = result
        else:
            cell.down = result
        if result and not before:
            cell.count = min(COUNT_HIGH, max(0, cell.count + step))

    def preset(self, number: int, result: bool, value: int) -> None:
        """Sets the counter at a rising edge of the result."""
        cell = self._counter(number, result)
        if cell is None:
            return
        if result and not cell.preset:
            cell.count = min(COUNT_HIGH, max(0, value))
        cell.preset = result

    def reset(self, number: int, result: bool) -> None:
        """While the result is 1: the timer is stopped and its state is 0, the counter is 0.  Edges are kept: nothing restarts unasked."""
        if not result:
            return
        cell = self._cells[number]
        cell.runs, cell.count, cell.cleared = False, 0, True

    def kept(self) -> bytes:
        """All cells, timers with the time they still have to run."""
        return b"".join(self._kept(cell) for cell in self._cells)

    def restore(self, kept: bytes) -> None:
        """The reverse of `kept`, at the moment `now`.  ValueError: damaged."""
        if len(kept) != KEPT.size * CELLS:
            raise ValueError(f"{len(kept)} bytes of timers and counters, {KEPT.size * CELLS} expected")
        found = [self._restored(*KEPT.unpack_from(kept, KEPT.size * at)) for at in range(CELLS)]
        self._cells[:] = found

    def _counter(self, number: int, result: bool) -> Cell | None:
        """Return the cell as a counter; None: it belongs to a timer, and a command with the result 0 does not take it over."""
        cell = self._cells[number]
        if cell.kind != COUNTER:
            if not result:
                return None
            content = self.content(number)
            self._become(cell, COUNTER)
            cell.count = min(COUNT_HIGH, content)
        return cell

    def _become(self, cell: Cell, kind: int) -> None:
        cell.kind, cell.runs, cell.level, cell.count, cell.end = kind, False, False, 0, 0
        cell.up = cell.down = cell.preset = cell.cleared = False

    def _kept(self, cell: Cell) -> bytes:
        flags = cell.runs | cell.level << 1 | cell.up << 2 | cell.down << 3 | cell.preset << 4 | cell.cleared << 5
        return KEPT.pack(cell.kind, flags, cell.count if cell.kind == COUNTER else max(0, cell.end - self.now) if cell.runs else 0)

    def _restored(self, kind: int, flags: int, value: int) -> Cell:
        if kind > COUNTER or flags > 63 or value < 0 or (kind == COUNTER and value > COUNT_HIGH):
            raise ValueError(f"kind {kind}, flags {flags}, value {value}: no timer and no counter")
        runs, level, up, down, preset, cleared = (bool(flags >> bit & 1) for bit in range(6))
        counts = kind == COUNTER
        return Cell(kind, 0 if counts else self.now + value, value if counts else 0, runs, level, up, down, preset, cleared)
