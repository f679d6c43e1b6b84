"""Number forms at the ends of a route: raw bytes <-> number, in every byte order of registers and data words (AX-396).

Bytes are named as Modbus users do: ABCD is high byte first, high word first, the order of all command sources (AX-010); two-byte forms
read ABCD and CDAB as AB, BADC and DCBA as BA.
"""

import math

from protocols.base.errors import DecodeError, EncodeError
from protocols.base.step5 import Step5Type, decode, encode, range_of

ORDERS = ("ABCD", "CDAB", "BADC", "DCBA")
BIT = "bit"
_WHOLE = {"u8": (1, False), "s8": (1, True), "u16": (2, False), "s16": (2, True), "u32": (4, False), "s32": (4, True)}
_STEP5: dict[str, Step5Type] = {kind.value: kind for kind in Step5Type if kind.value in ("KF", "KH", "KM", "DH", "KZ", "KG", "REAL", "BCD")}
FORMS = (BIT, *_WHOLE, *_STEP5)
FLOATS = ("KG", "REAL")


def size_of(form: str) -> int:
    """Bytes; 0 for a bit.  KeyError: no such form."""
    if form == BIT:
        return 0
    return _WHOLE[form][0] if form in _WHOLE else _STEP5[form].size


def span_of(form: str) -> tuple[float, float]:
    """Least and largest number the form holds."""
    if form == BIT:
        return 0, 1
    if form in _STEP5:
        return range_of(_STEP5[form])
    size, signed = _WHOLE[form]
    return (-(1 << 8 * size - 1), (1 << 8 * size - 1) - 1) if signed else (0, (1 << 8 * size) - 1)


def number_of(form: str, order: str, raw: bytes) -> float:
    """Return the number of exactly size_of(form) bytes.  Raise DecodeError for an invalid pattern (digit A..F, NaN)."""
    if len(raw) != size_of(form):
        raise DecodeError(f"{form}: {size_of(form)} bytes expected, {len(raw)} received: {raw.hex(' ')}")
    data = _swapped(order, raw)
    if form in _WHOLE:
        return int.from_bytes(data, "big", signed=_WHOLE[form][1])
    value = decode(_STEP5[form], data)
    if not isinstance(value, int | float) or not math.isfinite(value):
        raise DecodeError(f"{form}: {raw.hex(' ')} is not a number")
    return value


def bytes_of(form: str, order: str, value: float) -> bytes:
    """The reverse, rounded to the nearest number of the form; EncodeError when it does not fit."""
    low, high = span_of(form)
    number = value if form in FLOATS else round(value)
    if not low <= number <= high:
        raise EncodeError(f"{value:g} does not fit {form}: {low:g}..{high:g}")
    if form in _WHOLE:
        size, signed = _WHOLE[form]
        return _swapped(order, int(number).to_bytes(size, "big", signed=signed))
    return _swapped(order, encode(_STEP5[form], number))


def _swapped(order: str, raw: bytes) -> bytes:
    """Its own inverse."""
    if len(raw) == 1 or order == "ABCD":
        return bytes(raw)
    if len(raw) == 2:
        return raw[::-1] if order in ("BADC", "DCBA") else bytes(raw)
    match order:
        case "CDAB":
            return raw[2:] + raw[:2]
        case "BADC":
            return bytes((raw[1], raw[0], raw[3], raw[2]))
    return raw[::-1]
