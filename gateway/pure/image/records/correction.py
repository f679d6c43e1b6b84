"""The correction of an application (VAL 3 alter): a region of the interpreter that the cycle lays over the RC inputs of [alter]."""

import struct
from dataclasses import dataclass
from typing import Annotated

from gateway.pure.image.records.cell import InputImage, Quality
from gateway.pure.image.records.layout import I64, Code, Layout, Yes

NUMBERS = 6
_VALUES = struct.Struct(f">{NUMBERS}f")  # as [alter] with type = "REAL" has them
OCTETS = _VALUES.size + 1  # the last one has alterEnd in its lowest bit
LARGEST = 3e38


@dataclass(frozen=True, slots=True)
class ProgramCorrection:
    """stamp: of the turn it was given in, 0: there is none; values: x, y, z in mm, rx, ry, rz in deg; ended: alterEnd."""

    stamp: I64 = 0
    values: Annotated[tuple[float, ...], Code(f"{NUMBERS}d")] = (0.0,) * NUMBERS
    ended: Yes = False


_RECORD = Layout(ProgramCorrection, "correction/1")
CORRECTION_SIZE, CORRECTION_LAYOUT = _RECORD.size, _RECORD.text
pack_correction, unpack_correction = _RECORD.pack, _RECORD.unpack


def end_bit(byte: int) -> int:
    """RC input of alterEnd, behind a correction from this byte on."""
    return (byte + _VALUES.size) * 8


def laid_over(image: InputImage, correction: ProgramCorrection, byte: int) -> InputImage:
    """The inputs with a correction from this byte on; a copy."""
    if not correction.stamp:
        return image
    made = InputImage(bytearray(image.values), bytearray(image.quality), list(image.stamps))
    values = [value if abs(value) < LARGEST else float("nan") for value in correction.values]
    made.values[byte : byte + OCTETS] = _VALUES.pack(*values) + bytes([correction.ended])
    made.quality[byte : byte + OCTETS] = bytes([Quality.GOOD]) * OCTETS
    made.stamps[byte : byte + OCTETS] = [correction.stamp] * OCTETS
    return made
