"""Before the first enable on real drives: six sentences, a typed confirmation with a name, stored with a fingerprint of the drives.

Source: users.md 5 (text).  Required again after every change of drive, EDS or DBC, mechanics or zero, because the fingerprint changes.
"""

import dataclasses
import hashlib
import json
import pathlib
from collections.abc import Callable

from gateway.assembly import axis_zeros as zeros
from gateway.assembly.axis_zeros import rows_of
from gateway.assembly.drive_buses import listening
from gateway.files.find import ConfigNotFound, beside
from gateway.files.safe_file import append_line
from gateway.pure.cell.cell import Cell
from gateway.registry import DRIVE_FAMILIES
from gateway.runtime.clock import wall

TEXT = (
    "Before the first enable on real drives:\n"
    "  1. Emergency stop tested today, with drives on.\n"
    "  2. Hard limit switches tested.\n"
    "  3. Vertical axes supported or brake tested.\n"
    "  4. The guarded area is clear, one hand is at the emergency stop.\n"
    "  5. Motor data and commutation set with the drive maker's tool.\n"
    "  6. Stop time at bus loss measured: axisgate drive loss-test.\n"
    "Vor dem ersten Einschalten echter Antriebe: Not-Halt heute unter Leistung geprueft, Endschalter geprueft, senkrechte Achsen\n"
    "abgestuetzt oder Bremse geprueft, niemand im Schutzbereich, Motordaten und Kommutierung gesetzt, Anhaltezeit gemessen."
)
WORDS = "I HAVE TESTED THIS"


def percent(text: str) -> float:
    """ "20 %" -> 0.2."""
    return float(text.rstrip(" %")) / 100.0


def fingerprint(cell: Cell) -> dict[str, str]:
    """By axis: a digest of drive, data sheet, mechanics, zero and following error."""
    found = {}
    for axis in cell.axis:
        bus = next((bus for bus in cell.bus if bus.name == axis.drive.bus), None)
        sheet = axis.drive.eds if DRIVE_FAMILIES[axis.drive.type].objects else bus.layout if bus is not None else ""
        parts = [
            json.dumps(dataclasses.asdict(axis.drive), sort_keys=True),
            json.dumps(dataclasses.asdict(axis.mechanics), sort_keys=True),
            _digest_of(cell, sheet),
            str(zeros.zero_inc(cell, axis.name)),
        ]
        found[axis.name] = hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]
    return found


def _digest_of(cell: Cell, name: str) -> str:
    try:
        return hashlib.sha256(beside(cell.file, name, "drives").read_bytes()).hexdigest() if name else ""
    except (ConfigNotFound, OSError):
        return "missing"


def log_of(cell: Cell) -> pathlib.Path:
    """Next to the zeros."""
    return zeros.path_of(cell).with_suffix(".enable.jsonl")


def unconfirmed(cell: Cell) -> list[str]:
    """Axes not confirmed in their present state."""
    try:
        entries = rows_of(log_of(cell).read_text(errors="replace"))[0]
    except OSError:
        entries = []
    known: dict[str, str] = {}
    for entry in entries:
        axes = entry.get("axes")
        known |= {str(axis): str(digest) for axis, digest in axes.items()} if isinstance(axes, dict) else {}
    return [axis for axis, digest in fingerprint(cell).items() if known.get(axis) != digest]


def needed(cell: Cell, *, simulated: bool) -> list[str]:
    """Axes that need a confirmation before this cell may run on its real buses."""
    real = {bus.name for bus in cell.bus if not bus.simulated} - set(listening(cell, simulated=simulated))  # nothing is enabled on those
    if simulated or cell.cell.target == "simulation":
        return []
    return [axis for axis in unconfirmed(cell) if cell.axis_named(axis).drive.bus in real]


def confirm(cell: Cell, axes: list[str], ask: Callable[[str], str], say: Callable[[str], None]) -> bool:
    """Show the text, ask for the words and a name, store them; False when anything else was typed."""
    say(TEXT)
    say(f"New or changed since the last confirmation: {', '.join(axes)}")
    typed = ask(f'Type "{WORDS}" and your name: ').strip()
    words, name = typed[: len(WORDS)], typed[len(WORDS) :].strip(" ,.")
    if words.upper() != WORDS or len(name) < 2:
        say("Not confirmed: nothing is enabled.")
        return False
    digests = fingerprint(cell)
    path = log_of(cell)
    append_line(path, json.dumps({"wall": wall(), "who": name, "typed": typed, "axes": {axis: digests[axis] for axis in axes}}))
    say(f"Confirmed by {name}; written to {path}")
    return True
