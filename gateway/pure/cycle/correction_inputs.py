"""The correction of an application (VAL 3 alter) as the RC inputs of [alter] that the cycle reads.  Pure."""

import struct

from gateway.pure.image.records.cell import InputImage, Quality
from gateway.pure.image.records.correction import NUMBERS, ProgramCorrection

_VALUES = struct.Struct(f">{NUMBERS}f")  # as [alter] with type = "REAL" has them
OCTETS = _VALUES.size + 1  # the last one has alterEnd in its lowest bit
LARGEST = 3e38


def end_bit(byte: int) -> int:
    """Return the RC input of alterEnd, which follows a correction from this byte on."""
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
