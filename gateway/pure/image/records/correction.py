"""The correction of an application (VAL 3 alter): a region of the interpreter."""

from dataclasses import dataclass
from typing import Annotated

from gateway.pure.image.records.layout import I64, Code, Layout, Yes

NUMBERS = 6


@dataclass(frozen=True, slots=True)
class ProgramCorrection:
    """stamp: of the turn it was given in, 0: there is none; values: x, y, z in mm, rx, ry, rz in deg; ended: alterEnd."""

    stamp: I64 = 0
    values: Annotated[tuple[float, ...], Code(f"{NUMBERS}d")] = (0.0,) * NUMBERS
    ended: Yes = False


_RECORD = Layout(ProgramCorrection, "correction/1")
CORRECTION_SIZE, CORRECTION_LAYOUT = _RECORD.size, _RECORD.text
pack_correction, unpack_correction = _RECORD.pack, _RECORD.unpack
