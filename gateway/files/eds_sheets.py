"""Data sheets (EDS, DCF) of a cell's CANopen drives, read tolerantly."""

import functools
import pathlib
from dataclasses import dataclass

from gateway.files.find import ConfigNotFound, beside
from gateway.pure.cell.cell import Axis, Cell
from protocols.canopen import eds
from protocols.canopen.dictionary import ObjectDictionary

OUR_EDS = "axisgate_402.eds"  # of the emulated drives


@dataclass(frozen=True, slots=True)
class EdsFile:
    """A data sheet as read; `faults`: each with its line and its treatment."""

    path: pathlib.Path
    dictionary: ObjectDictionary
    faults: tuple[eds.Fault, ...]


def read_eds(cell: Cell, axis: Axis, *, simulated: bool) -> EdsFile | None:
    """The axis' EDS or DCF; under simulation the emulated drive's own where the cell's is not there; None: the cell names none."""
    names = [name for name in (axis.drive.eds, OUR_EDS if simulated else "") if name]
    for name in names:
        try:
            path = beside(cell.file, name, "drives")
        except ConfigNotFound:
            continue
        dictionary, faults = parsed(path.read_bytes())
        return EdsFile(path, dictionary, faults)
    return None


@functools.lru_cache(maxsize=8)
def parsed(data: bytes) -> tuple[ObjectDictionary, tuple[eds.Fault, ...]]:
    """Dictionary and faults of one file: most drives of a cell share it, and reading it takes a tenth of a second."""
    return eds.parse(data.decode("utf-8", "replace"))
