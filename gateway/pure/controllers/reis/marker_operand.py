"""Markers as a person names them: M10.0, M10 or MB 10, MD10; which of them may be written by hand.  Source: robotstar 5.2, 5.8."""

import re
from dataclasses import dataclass

from gateway.pure.controllers.reis.markers import INPUTS, PLC_KEEPS, SYSTEM

FORM = re.compile(r"M(B|D)?\s*(\d{1,5})(?:\.(\d))?$", re.IGNORECASE)
HEXADECIMAL = re.compile(r"[0-9A-F]{1,8}H$", re.IGNORECASE)
FREE = 512  # M0 to M511 are the program's (L2283)


class MarkerFault(ValueError):
    """The operand or its value; the text names what may be written."""


@dataclass(frozen=True, slots=True)
class MarkerOperand:
    """`bit` None: `size` bytes."""

    byte: int
    bit: int | None = None
    size: int = 1

    @property
    def name(self) -> str:
        """As the PLC program has it, double words as MD."""
        return f"M{self.byte}.{self.bit}" if self.bit is not None else f"{'MD' if self.size == 4 else 'M'}{self.byte}"

    def number(self, text: str) -> int:
        """A value for it: decimal, or hexadecimal with H.  MarkerFault."""
        text = text.strip()
        if HEXADECIMAL.match(text):
            value = int(text[:-1], 16)
        elif re.fullmatch(r"-?\d{1,10}", text):
            value = int(text)
        else:
            raise MarkerFault(f"{self.name} = {text!r}: a whole number is expected, decimal or hexadecimal with H (12H)")
        low, high = (0, 1) if self.bit is not None else (0, 255) if self.size == 1 else (-0x80000000, 0xFFFFFFFF)
        if not low <= value <= high:
            raise MarkerFault(f"{self.name} = {text}: outside {low} .. {high}")
        return value

    def data(self, value: int) -> bytes:
        """The bytes, the lowest first."""
        return (value & (1 << 8 * self.size) - 1).to_bytes(self.size, "little")


def marker_of(text: str) -> MarkerOperand:
    """A marker that a person may write: all but those the robot writes.  MarkerFault."""
    found = FORM.fullmatch(text.strip())
    if found is None or (found[1] and found[3] is not None):
        raise MarkerFault(f"{text!r}: a marker is written as M10.0 (bit), M10 (byte) or MD10 (double word)")
    byte, bit, size = int(found[2]), None if found[3] is None else int(found[3]), 4 if (found[1] or "").upper() == "D" else 1
    if bit is not None and bit > 7:
        raise MarkerFault(f"{text.strip()}: bits are 0 to 7")
    if byte + size > INPUTS:
        raise MarkerFault(f"{text.strip()}: M0 to M{INPUTS - size} are markers; inputs are forced, outputs are the program's")
    operand = MarkerOperand(byte, bit, size)
    for row in SYSTEM if byte + size > FREE else ():
        touched = row.byte < byte + size and byte < row.byte + row.bytes
        if touched and row.writer == "robot" and (row.byte, row.bit) not in PLC_KEEPS and (bit is None or row.bit in (None, bit)):
            raise MarkerFault(f"{operand.name}: the robot writes it ({row.name})")
    return operand
