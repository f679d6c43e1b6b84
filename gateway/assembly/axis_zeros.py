"""Zeros of absolute axes: one record for each that was ever set, in the retained data of the cell (gateway.runtime.retained.writer); the
last one counts.

Lines of zero/CELL.jsonl, where earlier versions wrote them, are read first.  Where the files of a cell lie:
gateway.runtime.state_folder.
"""

import contextlib
import json
import pathlib

from gateway.assembly.axis_scaling import scaling_of
from gateway.pure.cell.cell import Axis, Cell
from gateway.runtime.clock import wall
from gateway.runtime.state_folder import place
from motion.geometry.units import to_si

Entry = dict[str, object]


def path_of(cell: Cell) -> pathlib.Path:
    """Path where earlier versions kept the history of this cell; the last places of its axes are stored next to it."""
    return place(cell.file, "zero", f"{pathlib.Path(cell.file).resolve().stem}.jsonl")


def history(cell: Cell, axis: str) -> list[Entry]:
    """Every zero of an axis, oldest first."""
    try:
        entries = rows_of(path_of(cell).read_text(errors="replace"))[0]
    except OSError:
        entries = []
    return [entry for entry in [*entries, *_kept(cell)] if entry.get("axis") == axis]


def rows_of(text: str) -> tuple[list[Entry], list[int]]:
    """The rows of a history, and the numbers of lines that are none: cut by a full disk or a power failure, passed over."""
    rows: list[Entry] = []
    torn: list[int] = []
    for number, line in enumerate(text.splitlines(), 1):
        try:
            row = json.loads(line) if line.strip() else None
        except ValueError:
            row = False
        if isinstance(row, dict):
            rows.append(row)
        elif row is not None:
            torn.append(number)
    return rows, torn


def torn_lines(cell: Cell) -> list[str]:
    """A sentence for each file of this cell's histories in which lines cannot be read."""
    said = []
    for path in (path_of(cell), path_of(cell).with_suffix(".enable.jsonl")):
        with contextlib.suppress(OSError):
            if torn := rows_of(path.read_text(errors="replace"))[1]:
                said.append(f"{path}: line {', '.join(map(str, torn))}: cut off and passed over; check what it held, then remove it")
    return said


def _kept(cell: Cell) -> list[Entry]:
    from gateway.runtime.retained import writer as retain  # only where there is something to read

    path = retain.path_of(cell)
    try:
        return retain.history(path, "zero") if path.exists() else []
    except OSError:  # reported and set aside by the run; without a zero the axis is not referenced
        return []


def zero_inc(cell: Cell, axis: str) -> float | None:
    """Increments at which the axis reads 0; None: never set."""
    found = history(cell, axis)
    return float(str(found[-1]["zero_inc"])) if found else None


def raw_inc(cell: Cell, axis: Axis, reading: float) -> int:
    """Increments of the drive at this axis reading, by the present zero; for an endless axis modulo full revolutions."""
    scaling = scaling_of(axis).with_zero(zero_inc(cell, axis.name) or 0.0)
    return scaling.to_inc(to_si(reading, axis.unit))


def entry(cell: Cell, axis: Axis, reading: float, at: float, who: str) -> Entry:
    """The line that sets the reading `reading` to `at`."""
    raw = raw_inc(cell, axis, reading)
    zero = raw - to_si(at, axis.unit) * scaling_of(axis).inc_per_unit
    old = zero_inc(cell, axis.name)
    drive = axis.drive.serial or f"{axis.drive.type} {axis.drive.node or axis.drive.module}"
    return {
        "wall": wall(), "who": who, "axis": axis.name, "at": at, "unit": axis.unit, "raw_inc": raw, "zero_inc": round(zero, 3),
        "old_zero_inc": old, "inc_per_turn": axis.drive.inc_per_turn, "drive": drive,
    }  # fmt: skip


def append(cell: Cell, line: Entry) -> pathlib.Path:
    """Permanent; no entry is ever removed.  Returns the file.  RetainError: it was not written."""
    from gateway.runtime.retained import writer as retain

    path = retain.path_of(cell)
    retain.append(path, "zero", line)
    return path
