"""Verdicts of the demo, out of what the gateway cannot write: the emulator's own record, the broker's log, the line process' record."""

import bisect
import math
from collections.abc import Sequence
from dataclasses import dataclass

from drivers.emulator.record import Record, Row
from drivers.ports.linewire import Note, Run
from gateway.cell import Axis, Cell
from gateway.plant import motor_rad

INC = 16384
STX = 0x02
SETTLED_S = 0.25  # ten time constants of the position loop at constant speed: the lag is steady


@dataclass(frozen=True, slots=True)
class Verdict:
    """One line of the summary."""

    name: str
    value: float
    limit: str
    ok: bool

    def line(self) -> str:
        return f"{'ok  ' if self.ok else 'FAIL'}  {self.name}: {self.value:.4g} ({self.limit})"


@dataclass(frozen=True, slots=True)
class Move:
    """One finished move as the PLC that commanded it saw it."""

    start_ns: int
    end_ns: int
    start: tuple[float, ...]  # axis units
    target: tuple[float, ...]


class Judge:
    """All rows of one run."""

    def __init__(self, cell: Cell, record: Record) -> None:
        self._axes = cell.axis
        self._kv = [cell.plant.axis[axis.name].kv if cell.plant else 60.0 for axis in cell.axis]
        self.rows = record.rows
        self._stamps = [row.stamp_ns for row in record.rows]

    def between(self, start_ns: int, end_ns: int) -> Sequence[Row]:
        """Rows stamped start..end."""
        return self.rows[bisect.bisect_left(self._stamps, start_ns) : bisect.bisect_right(self._stamps, end_ns)]

    def at(self, stamp_ns: int) -> Row:
        """The last row not later than the stamp."""
        return self.rows[max(bisect.bisect_right(self._stamps, stamp_ns) - 1, 0)]

    def missed_by(self, move: Move) -> float:
        """Increments between the mechanical position at the end of the move and its target; the worst axis."""
        row = self.at(move.end_ns)
        return max(abs(_inc(row.axes[n].position_rad - motor_rad(axis, move.target[n]))) for n, axis in enumerate(self._axes))

    def lag_error(self, move: Move) -> float | None:
        """Worst relative difference of lag and v / Kv where the speed was steady; None when it never was."""
        rows = self.between(move.start_ns, move.end_ns)
        worst: float | None = None
        for n in range(len(self._axes)):
            for speed, lag in _steady(rows, n):
                error = abs(lag - speed / self._kv[n]) / abs(speed / self._kv[n])
                worst = error if worst is None else max(worst, error)
        return worst

    def off_path(self, move: Move) -> float:
        """Largest distance (increments) of any axis' set value from the straight line start..target, by the longest axis' own progress."""
        start, target = (self._motor(values) for values in (move.start, move.target))
        travel = [b - a for a, b in zip(start, target, strict=True)]
        longest = max(range(len(travel)), key=lambda n: abs(travel[n]))
        rows = self.between(move.start_ns, move.end_ns)
        offset = self._turns_offset(rows, target)
        worst = 0.0
        for row in rows:
            progress = (row.axes[longest].set_inc - offset[longest] - start[longest]) / travel[longest]
            for n, way in enumerate(travel):
                worst = max(worst, abs(row.axes[n].set_inc - offset[n] - start[n] - progress * way))
        return worst

    def _motor(self, values: Sequence[float]) -> list[float]:
        return [_inc(motor_rad(axis, value)) for axis, value in zip(self._axes, values, strict=True)]

    @staticmethod
    def _turns_offset(rows: Sequence[Row], target: Sequence[float]) -> list[int]:
        """The drives count whole turns from power-up: the difference to the mechanical position is a whole number of turns."""
        return [round((rows[-1].axes[n].set_inc - value) / INC) * INC for n, value in enumerate(target)]

    def moved(self, start_ns: int, end_ns: int) -> float:
        """Largest way (increments) any axis' mechanics made in that time."""
        rows = self.between(start_ns, end_ns)
        if not rows:
            return math.nan
        spans = [[row.axes[n].position_rad for row in rows] for n in range(len(self._axes))]
        return max(abs(_inc(max(span) - min(span))) for span in spans)

    def rest_after(self, stamp_ns: int, until_ns: int) -> float | None:
        """Seconds from the stamp until no set value changes any more; None when it never rests before `until_ns`."""
        rows = self.between(stamp_ns, until_ns)
        for index in range(len(rows) - 1, 0, -1):
            if any(a.set_inc != b.set_inc for a, b in zip(rows[index].axes, rows[index - 1].axes, strict=True)):
                return (rows[index].stamp_ns - stamp_ns) / 1e9 if index < len(rows) - 1 else None
        return 0.0


def _inc(rad: float) -> float:
    return rad / (2.0 * math.pi) * INC


def _steady(rows: Sequence[Row], n: int) -> list[tuple[float, float]]:
    """(speed inc/s, lag inc) of every row that ends a stretch of constant set speed."""
    found = []
    begin = 0
    for index in range(2, len(rows)):
        before = rows[index - 1].axes[n].set_inc - rows[index - 2].axes[n].set_inc
        step = rows[index].axes[n].set_inc - rows[index - 1].axes[n].set_inc
        if abs(step - before) > max(1.0, 0.002 * abs(step)) or abs(step) < 50:
            begin = index
            continue
        span = (rows[index].stamp_ns - rows[begin].stamp_ns) / 1e9
        if span > SETTLED_S:
            first = rows[index - 10]
            speed = (rows[index].axes[n].set_inc - first.axes[n].set_inc) / ((rows[index].stamp_ns - first.stamp_ns) / 1e9)
            axis = rows[index].axes[n]
            found.append((speed, float(axis.set_inc - axis.position_inc)))
    return found


def repeats_while_unplugged(items: Sequence[Run | Note], unplugged_ns: int, plugged_ns: int) -> int:
    """STX the PLC sent again into the broken cable; the first one of the outage is the attempt, not a repeat."""
    tries = 0
    for item in items:
        if isinstance(item, Run) and item.sender == "A" and unplugged_ns < item.stamp_ns < plugged_ns and item.data == bytes((STX,)):
            tries += 1
    return max(tries - 1, 0)


def recovery_s(items: Sequence[Run | Note], plugged_ns: int) -> float:
    """From the plug to the first whole reaction telegram of the gateway: 00 00 00 00, DLE ETX, check character."""
    heard = b""
    for item in items:
        if isinstance(item, Run) and item.sender == "B" and item.stamp_ns > plugged_ns:
            heard += item.data
            if b"\x00\x00\x00\x00" in heard and b"\x10\x03" in heard:
                return (item.stamp_ns - plugged_ns) / 1e9
    return math.inf


def axis_names(axes: Sequence[Axis]) -> list[str]:
    """For the table."""
    return [axis.name for axis in axes]
