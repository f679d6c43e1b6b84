"""The report of `axisgate drive loss-test --running`, read as evidence that a type of drive stops when the gateway fails."""

import hashlib
import json
import pathlib
from dataclasses import dataclass

from gateway.files.find import ConfigNotFound, beside, read_octets
from gateway.pure.cell.axes import Axis
from gateway.pure.cell.cell import Cell

UNTESTED = "untested"  # stop_evidence of the cell in which the loss test is made
ON_BUS = "bus"  # `evidence` of a report on real drives
MOST_BYTES = 1 << 20


class NoEvidence(ValueError):
    """Why the report proves nothing for this axis, and the remedy."""


@dataclass(frozen=True, slots=True)
class StopEvidence:
    """One axis of the test whose drive is of the same type."""

    file: str
    axis: str
    wall: str  # when it was measured
    reaction_ms: float


def sheet_digest(cell: Cell, axis: Axis) -> str:
    """Hash of the axis' data sheet, which identifies the type of drive; empty: the cell names none, or it is not there."""
    try:
        return hashlib.sha256(beside(cell.file, axis.drive.eds, "drives").read_bytes()).hexdigest() if axis.drive.eds else ""
    except (ConfigNotFound, OSError):
        return ""


def stop_evidence(cell: Cell, axis: Axis) -> StopEvidence:
    """The measurement of a drive of this type in the report named by `stop_evidence`.  NoEvidence."""
    name = axis.stop_evidence
    digest = sheet_digest(cell, axis)
    if not digest:
        raise NoEvidence("only drives of one data sheet can be compared: name it in drive.eds, here and in the cell of the test")
    report = _report(pathlib.Path(cell.file).parent / name, name)
    if report.get("evidence") != ON_BUS:
        raise NoEvidence(f"{name} was measured on emulated drives; on the machine: axisgate drive loss-test CELL --running")
    sheets = report.get("data_sheets")
    same = [each for each, found in sheets.items() if found == digest] if isinstance(sheets, dict) else []
    stops = report.get("stops")
    rows = [row for row in stops if isinstance(row, dict) and row.get("axis") in same] if isinstance(stops, list) else []
    if not rows:
        raise NoEvidence(f"{name} has no drive with the data sheet {axis.drive.eds}; repeat the loss test with such a drive")
    bad = [str(row.get("axis")) for row in rows if row.get("good") is not True]
    if bad:
        raise NoEvidence(f"{name}: the drive of {', '.join(bad)} did not stop as required; axisgate does not run such a drive")
    row = rows[0]
    reaction = row.get("reaction_ms")
    return StopEvidence(name, str(row["axis"]), str(report.get("wall", "")), float(reaction) if isinstance(reaction, int | float) else 0.0)


def _report(path: pathlib.Path, name: str) -> dict[str, object]:
    try:
        found = json.loads(read_octets(path, MOST_BYTES))
    except OSError as error:
        why = error.strerror or str(error)
        raise NoEvidence(
            f"{name}: {why}; put the JSON of `axisgate drive loss-test CELL --running` into the folder of the cell file"
        ) from error
    except (ValueError, RecursionError) as error:
        raise NoEvidence(f"{name} is not a report of axisgate drive loss-test (JSON)") from error
    if not isinstance(found, dict):
        raise NoEvidence(f"{name} is not a report of axisgate drive loss-test (JSON)")
    return found
