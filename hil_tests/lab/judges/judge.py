"""Verdicts of the demo, out of what the gateway cannot write: the emulator's own record, the broker's log, the line process' record."""

import bisect
import itertools
import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from drivers.emulator.servo.record import Record, Row
from drivers.ports.serial.line_format import Run
from gateway.assembly.plant import motor_rad
from gateway.pure.cell.cell import Cell
from hil_tests.lab.judges.bus_log import Logged
from protocols.servodyn.plan import SYNC_ID

INC = 16384
STX = 0x02
EVEN_NS = 200_000  # a SYNC late by this lets the lag shrink by Kv x 0.2 ms, 1.6 %: later ones say nothing about the drive
SLOWEST_INC = 50  # per SYNC: below it an increment of rounding is more than a percent
SETTLED_S = 0.12  # about ten time constants of the position loop (Kv 80): at constant speed the lag is steady by then


@dataclass(frozen=True, slots=True)
class Verdict:
    """One line of the summary."""

    name: str
    value: float
    limit: str
    ok: bool

    def line(self) -> str:
        value = "not measured" if math.isnan(self.value) else f"{self.value:.4g}"
        return f"{'ok  ' if self.ok else 'FAIL'}  {self.name}: {value} ({self.limit})"


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
        self._kv = [_kv(record, axis.drive.module or axis.drive.node or 0) for axis in cell.axis]
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


class SetPath:
    """Set values as sent on the bus, from the bus' own log, which no part of axisgate writes."""

    def __init__(self, cell: Cell, frames: Iterable[Logged]) -> None:
        self._axes = cell.axis
        self._stamps: list[int] = []
        self._bursts: list[dict[int, int]] = []
        for frame in frames:
            if frame.identifier == SYNC_ID:
                self._stamps.append(frame.stamp_ns)
                self._bursts.append({})
            elif self._bursts and 210 <= frame.identifier <= 260 and len(frame.data) == 8:
                self._bursts[-1][(frame.identifier - 200) // 10] = int.from_bytes(frame.data[2:6], "little", signed=True)

    def off_line(self, move: Move) -> float:
        """Largest distance (increments) of any axis' set value from the straight line start..target, by the longest axis' own progress."""
        modules = [axis.drive.module or 0 for axis in self._axes]
        start, target = (
            [_inc(motor_rad(axis, v)) for axis, v in zip(self._axes, values, strict=True)] for values in (move.start, move.target)
        )
        travel = [b - a for a, b in zip(start, target, strict=True)]
        longest = max(range(len(travel)), key=lambda n: abs(travel[n]))
        first, last = bisect.bisect_left(self._stamps, move.start_ns), bisect.bisect_right(self._stamps, move.end_ns)
        bursts = [[burst[m] for m in modules] for burst in self._bursts[first:last] if all(m in burst for m in modules)]
        if not bursts:
            return math.inf
        turns = [
            round((end - value) / INC) * INC for end, value in zip(bursts[-1], target, strict=True)
        ]  # drives count turns from power-up
        worst = 0.0
        for burst in bursts:
            progress = (burst[longest] - turns[longest] - start[longest]) / travel[longest]
            off = (abs(burst[n] - turns[n] - start[n] - progress * way) for n, way in enumerate(travel))
            worst = max(worst, *off)
        return worst


def _kv(record: Record, module: int) -> float:
    """Position loop gain (1/s) the emulated drive says it ran with."""
    settings = record.header["settings"]
    assert isinstance(settings, dict)
    drives = {**settings["axes"], **settings.get("nodes", {})}
    return float(drives[str(module)]["kv_per_s"])


def _inc(rad: float) -> float:
    return rad / (2.0 * math.pi) * INC


def _steady(rows: Sequence[Row], n: int) -> list[tuple[float, float]]:
    """(speed inc/s, lag inc) of every row that ends a stretch of constant set speed on an even grid of SYNC."""
    found: list[tuple[float, float]] = []
    period = statistics.median(b.stamp_ns - a.stamp_ns for a, b in itertools.pairwise(rows)) if len(rows) > 2 else 0.0
    begin = 0
    for index in range(2, len(rows)):
        now, last, before = rows[index], rows[index - 1], rows[index - 2]
        step, step_before = now.axes[n].set_inc - last.axes[n].set_inc, last.axes[n].set_inc - before.axes[n].set_inc
        uneven = abs(now.stamp_ns - last.stamp_ns - period) > EVEN_NS
        if uneven or abs(step - step_before) > max(1.0, 0.002 * abs(step)) or abs(step) < SLOWEST_INC:
            begin = index
        elif now.stamp_ns - rows[begin].stamp_ns > SETTLED_S * 1e9:
            first = rows[max(begin, index - 10)]
            speed = (now.axes[n].set_inc - first.axes[n].set_inc) / ((now.stamp_ns - first.stamp_ns) / 1e9)
            found.append((speed, float(now.axes[n].set_inc - now.axes[n].position_inc)))
    return found


def repeats_while_unplugged(items: Sequence[Run], unplugged_ns: int, plugged_ns: int) -> int:
    """STX sent again into the broken cable, by whichever side had something to say; the first one is the attempt, not a repeat."""
    lost = [item.side for item in items if unplugged_ns < item.stamp_ns < plugged_ns and item.data == bytes((STX,))]
    return max(lost.count("A") - 1, lost.count("B") - 1, 0)


def recovery_s(items: Sequence[Run], plugged_ns: int) -> float:
    """From the plug to the first whole reaction telegram of the gateway: 00 00 00 00, DLE ETX, check character."""
    heard = b""
    for item in items:
        if item.side == "B" and item.stamp_ns > plugged_ns:
            heard += item.data
            if b"\x00\x00\x00\x00" in heard and b"\x10\x03" in heard:
                return (item.stamp_ns - plugged_ns) / 1e9
    return math.inf
