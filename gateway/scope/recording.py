"""A scope recording: a line of JSON, then rows of float64 (little endian), time first.  It can be reopened while it is being written.

{"format": "axisgate-scope/1", "channels": [["axis.A1.lag", "mm"], ...], "period_s": 0.004, "trigger": "...", ...}\\n
"""

import csv
import json
import pathlib
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

FORMAT = "axisgate-scope/1"
AT_ONCE = 8192  # rows written together
SUFFIXES = (".csv", ".mf4")


class RecordingError(Exception):
    """A file that is not a recording, or a format it cannot be written in; the message names the file and the remedy."""


@dataclass(slots=True)
class Recording:
    """`time`: s from the trigger (n,); `values`: (n, channels) in the units named."""

    names: Sequence[str]
    units: Sequence[str]
    time: npt.NDArray[np.float64]
    values: npt.NDArray[np.float64]
    period_s: float = 0.0
    cell: str = ""
    trigger: str = ""
    started: str = ""  # ISO 8601, of the trigger
    lost: int = 0  # records of the cycle that never came
    notes: dict[str, str] = field(default_factory=dict)

    def column(self, name: str) -> npt.NDArray[np.float64]:
        """Values of one channel; RecordingError names those there are."""
        if name not in self.names:
            raise RecordingError(f"{name}: not recorded; {', '.join(self.names)}")
        return self.values[:, list(self.names).index(name)]


def save(recording: Recording, path: pathlib.Path) -> None:
    """Write the complete recording."""
    head = {
        "format": FORMAT,
        "channels": [list(pair) for pair in zip(recording.names, recording.units, strict=True)],
        "period_s": recording.period_s,
        "cell": recording.cell,
        "trigger": recording.trigger,
        "started": recording.started,
        "lost": recording.lost,
    }
    with path.open("wb") as file:
        file.write(json.dumps(head).encode() + b"\n")
        for at in range(0, len(recording.time), AT_ONCE):  # a long recording is not laid out a second time in memory
            part = slice(at, at + AT_ONCE)
            file.write(np.column_stack((recording.time[part], recording.values[part])).astype("<f8").tobytes())


def load(path: pathlib.Path) -> Recording:
    """Raises RecordingError for a file that is not a recording; a half row at the end is left out."""
    try:
        head_line, _, body = path.read_bytes().partition(b"\n")
        head = json.loads(head_line)
        channels = head["channels"] if head["format"] == FORMAT else None
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}; axisgate scope record makes one") from error
    except (ValueError, KeyError, TypeError) as error:
        raise RecordingError(f"{path}: no scope recording ({error}); axisgate scope record makes one") from error
    if not channels:
        raise RecordingError(f"{path}: format {head['format']}; this version reads {FORMAT}")
    width = len(channels) + 1
    whole = len(body) // (8 * width)
    rows = np.frombuffer(body[: whole * 8 * width], "<f8").reshape(whole, width)
    return Recording(
        [name for name, _ in channels],
        [unit for _, unit in channels],
        rows[:, 0],
        rows[:, 1:],
        float(head["period_s"]),
        str(head["cell"]),
        str(head["trigger"]),
        str(head["started"]),
        int(head["lost"]),
    )


def export(recording: Recording, path: pathlib.Path) -> None:
    """As CSV (semicolon, decimal point, UTF-8 with BOM) or MF4, by the file's suffix; raises RecordingError."""
    suffix = path.suffix.lower()
    if suffix == ".csv":
        _csv(recording, path)
    elif suffix == ".mf4":
        _mf4(recording, path)
    else:
        raise RecordingError(f"{path}: .csv or .mf4 is written")


def _csv(recording: Recording, path: pathlib.Path) -> None:
    titles = [f"{name} [{unit}]" if unit else name for name, unit in zip(recording.names, recording.units, strict=True)]
    with path.open("w", encoding="utf-8-sig", newline="") as file:
        writer = csv.writer(file, delimiter=";")
        writer.writerow(["t [s]", *titles])
        for time, row in zip(recording.time, recording.values, strict=True):
            writer.writerow([f"{time:.6f}", *(f"{value:.9g}" for value in row)])


def _mf4(recording: Recording, path: pathlib.Path) -> None:
    """One channel group, master channel time."""
    try:
        from asammdf import MDF, Signal
    except ImportError as error:
        raise RecordingError(f"{path}: MF4 needs the package asammdf (pip install 'axisgate[files]'); .csv needs none") from error
    signals = [
        Signal(samples=recording.values[:, place], timestamps=recording.time - recording.time[0], name=name, unit=unit)
        for place, (name, unit) in enumerate(zip(recording.names, recording.units, strict=True))
    ]
    with MDF(version="4.10") as file:
        file.append(signals, comment=f"axisgate {recording.cell}, trigger {recording.trigger or 'none'}, {recording.started}")
        file.save(path, overwrite=True)
