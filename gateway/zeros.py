"""Zeros of absolute axes: one line for each that was ever set, in zero/CELL.jsonl beside the cell file; the last one of an axis counts.

A simulated or shipped cell keeps them in the runtime folder instead: packaged files are nobody's to write.
"""

import json
import os
import pathlib

from drivers.ports.base import runtime_dir
from gateway.axes import scaling_of
from gateway.cell import Axis, Cell
from gateway.clock import wall
from gateway.files import PACKAGED
from motion.units import to_si

Entry = dict[str, object]


def path_of(cell: Cell) -> pathlib.Path:
    """The history of this cell."""
    file = pathlib.Path(cell.file).resolve()
    folder = runtime_dir() if file.is_relative_to(PACKAGED) or not os.access(file.parent, os.W_OK) else file.parent
    return folder / "zero" / f"{file.stem}.jsonl"


def history(cell: Cell, axis: str) -> list[Entry]:
    """Every zero of an axis, oldest first."""
    try:
        lines = path_of(cell).read_text().splitlines()
    except OSError:
        return []
    entries: list[Entry] = [json.loads(line) for line in lines if line.strip()]
    return [entry for entry in entries if entry["axis"] == axis]


def zero_inc(cell: Cell, axis: str) -> float | None:
    """Increments at which the axis reads 0; None: never set."""
    found = history(cell, axis)
    return float(str(found[-1]["zero_inc"])) if found else None


def raw_inc(cell: Cell, axis: Axis, reading: float) -> int:
    """Increments the drive shows where the axis reads so, by the zero that counts now."""
    scaling = scaling_of(axis).with_zero(zero_inc(cell, axis.name) or 0.0)
    return scaling.to_inc(to_si(reading, axis.unit))


def entry(cell: Cell, axis: Axis, reading: float, at: float, who: str) -> Entry:
    """The line for: what reads `reading` now is `at`."""
    raw = raw_inc(cell, axis, reading)
    zero = raw - to_si(at, axis.unit) * scaling_of(axis).inc_per_unit
    old = zero_inc(cell, axis.name)
    drive = axis.drive.serial or f"{axis.drive.type} {axis.drive.node or axis.drive.module}"
    return {
        "wall": wall(), "who": who, "axis": axis.name, "at": at, "unit": axis.unit, "raw_inc": raw, "zero_inc": round(zero, 3),
        "old_zero_inc": old, "inc_per_turn": axis.drive.inc_per_turn, "drive": drive,
    }  # fmt: skip


def append(cell: Cell, line: Entry) -> pathlib.Path:
    """Kept for good; nothing is ever taken out."""
    path = path_of(cell)
    path.parent.mkdir(mode=0o755, parents=True, exist_ok=True)
    with path.open("a") as file:
        file.write(json.dumps(line) + "\n")
    return path
