"""Typed fields of a raw block: values <-> bytes.

Source: rho 3 Releases part 1, section 7.1, READ and WRITE with protocol 8 (rho3 1.3): BINARY 1 byte 0 or 1, CHARACTER 1, INTEGER and
REAL 4 (normal order: low byte first), POINT and JC_POINT one REAL for each coordinate, TEXT 80 bytes ended by NUL.  BYTE, WORD and KF were
packed by BAPS subroutines for a PLC (the application layer's job there).  Choices where the manual is open: AX-191.
"""

import math
import struct
from dataclasses import dataclass
from enum import Enum

from protocols.base.errors import DecodeError, EncodeError

Scalar = bool | int | float | str
Value = Scalar | tuple[Scalar, ...]


class Order(Enum):
    """Byte order of numbers; the value is the word of the cell file."""

    LITTLE = "little"
    BIG = "big"


class Kind(Enum):
    """The value is the type's name in a cell file."""

    BINARY = "BINARY"  # bool
    CHARACTER = "CHARACTER"  # str of `count` characters, Latin-1
    BYTE = "BYTE"  # int, 0..255
    WORD = "WORD"  # int, 0..65535
    KF = "KF"  # int, -32768..32767
    INTEGER = "INTEGER"  # int, 32 bits
    REAL = "REAL"  # float, IEEE single
    POINT = "POINT"  # tuple of `count` REALs, no separator
    JC_POINT = "JC_POINT"  # the same for axes
    TEXT = "TEXT"  # str of up to 80 characters, ended by NUL


SIZES = {Kind.WORD: 2, Kind.KF: 2, Kind.INTEGER: 4, Kind.REAL: 4, Kind.POINT: 4, Kind.JC_POINT: 4, Kind.TEXT: 80}  # all others 1
RANGES = {Kind.BYTE: (0, 0xFF), Kind.WORD: (0, 0xFFFF), Kind.KF: (-0x8000, 0x7FFF), Kind.INTEGER: (-0x8000_0000, 0x7FFF_FFFF)}
TEXTS = (Kind.CHARACTER, Kind.TEXT)
POINTS = (Kind.POINT, Kind.JC_POINT)
REAL_LARGEST = (2**24 - 1) * 2.0**104


@dataclass(frozen=True, slots=True)
class Field:
    """`count` items of one kind from byte `byte` on; value = raw x scale, in `unit`."""

    kind: Kind
    name: str  # the named value it is written to or read from
    byte: int
    count: int = 1
    order: Order = Order.LITTLE
    scale: float = 1.0
    unit: str = ""
    low: float | None = None  # smallest and largest legal value, in unit
    high: float | None = None

    @property
    def size(self) -> int:
        """Bytes it covers."""
        return SIZES.get(self.kind, 1) * self.count

    @property
    def end(self) -> int:
        """The first byte after it."""
        return self.byte + self.size

    @property
    def single(self) -> bool:
        """One value, not a tuple."""
        return self.count == 1 and self.kind not in POINTS


def decode(field: Field, data: bytes) -> Value:
    """The field's value in a block.  DecodeError names field, bytes and fault."""
    raw = data[field.byte : field.end]
    if len(raw) < field.size:
        raise DecodeError(f"{field.name}: bytes {field.byte}..{field.end - 1} expected, the block has {len(data)}")
    if field.kind in TEXTS:
        text = raw.decode("latin-1")
        return text.partition("\0")[0] if field.kind is Kind.TEXT else text
    step = SIZES.get(field.kind, 1)
    values = tuple(_decoded(field, raw[at : at + step]) for at in range(0, field.size, step))
    return values[0] if field.single else values


def encode(field: Field, value: Value) -> bytes:
    """The field's bytes.  EncodeError holds name, value and range."""
    if field.kind in TEXTS:
        return _text_bytes(field, value)
    if field.single:
        return _encoded(field, value)
    if not isinstance(value, tuple) or len(value) != field.count:
        raise EncodeError(f"{field.name} = {value!r}, {field.count} values of {field.kind.value} expected")
    return b"".join(_encoded(field, each) for each in value)


def span(field: Field) -> tuple[float, float]:
    """Least and largest value a number's field holds, in its unit."""
    low, high = RANGES.get(field.kind, (-REAL_LARGEST, REAL_LARGEST))
    ends = sorted((low * field.scale, high * field.scale))
    return ends[0] if field.low is None else max(ends[0], field.low), ends[1] if field.high is None else min(ends[1], field.high)


def _decoded(field: Field, raw: bytes) -> Scalar:
    if field.kind is Kind.BINARY:
        if raw[0] > 1:
            raise DecodeError(f"{field.name}: BINARY is 0 or 1, {raw[0]:02X}h received")
        return bool(raw[0])
    if field.kind in RANGES:
        count = int.from_bytes(raw, "little" if field.order is Order.LITTLE else "big", signed=RANGES[field.kind][0] < 0)
        number: int | float = count if field.scale == 1.0 else count * field.scale
    else:
        number = struct.unpack(_real(field), raw)[0] * field.scale
        if not math.isfinite(number):
            raise DecodeError(f"{field.name}: {raw.hex(' ')} is not a number (REAL)")
    low, high = span(field)
    if not low <= number <= high:
        raise DecodeError(f"{field.name} = {number:g} is outside {_said(low, high, field)}: {raw.hex(' ')}")
    return number


def _encoded(field: Field, value: Value) -> bytes:
    if isinstance(value, str | tuple):
        raise EncodeError(f"{field.name} = {value!r}, one {field.kind.value} expected")
    if field.kind is Kind.BINARY:
        if value not in (0, 1):
            raise EncodeError(f"{field.name} = {value!r}, range 0..1")
        return bytes((int(value),))
    low, high = span(field)
    if not low <= value <= high:  # a NaN is on no side of anything
        raise EncodeError(f"{field.name} = {value!r}, range {_said(low, high, field)}")
    if field.kind in RANGES:
        least, most = RANGES[field.kind]
        count = min(max(round(value / field.scale), least), most)  # the range's end itself must not round beyond it
        return count.to_bytes(field.size // field.count, "little" if field.order is Order.LITTLE else "big", signed=least < 0)
    return struct.pack(_real(field), value / field.scale)


def _text_bytes(field: Field, value: Value) -> bytes:
    if not isinstance(value, str):
        raise EncodeError(f"{field.name} = {value!r}, a text expected")
    try:
        data = value.encode("latin-1")
    except UnicodeEncodeError as error:
        raise EncodeError(f"{field.name} = {value!r}, only characters 00h..FFh (Latin-1)") from error
    if field.kind is Kind.TEXT and len(data) <= field.size:
        return data.ljust(field.size, b"\0")
    if len(data) != field.size:
        wanted = f"{field.size} characters" if field.kind is Kind.CHARACTER else f"at most {field.size} characters"
        raise EncodeError(f"{field.name} = {value!r}, {wanted} expected")
    return data


def _real(field: Field) -> str:
    return "<f" if field.order is Order.LITTLE else ">f"


def _said(low: float, high: float, field: Field) -> str:
    return f"{low:.10g}..{high:.10g}{' ' if field.unit else ''}{field.unit}"
