"""BAPS values as the bytes of a 3964R block: binary, without conversion.  Source: rho 3 Releases part 1, sections 7.2 to 7.4."""

import math
import struct
from dataclasses import dataclass
from enum import Enum, auto

from gateway.pure.controllers.rho3.serial.setup import WORDS, Condition
from protocols.base.errors import ProtocolError

TEXT_BYTES = 80
INTEGERS = range(-(2**31), 2**31)
Value = bool | int | float | bytes | tuple["Value", ...] | None  # None: a point (or component) that is not defined
Item = tuple["BapsType", Value]


class Kind(Enum):
    """The types READ and WRITE know (7.2)."""

    BINARY = auto()  # bool
    CHARACTER = auto()  # int 0..255
    INTEGER = auto()  # int, 32 bits with sign
    REAL = auto()  # float, IEEE single
    POINT = auto()  # tuple of floats, one for each coordinate, belts counted
    JC_POINT = auto()  # tuple of floats, one for each axis, belts counted
    TEXT = auto()  # bytes, at most 80


@dataclass(frozen=True, slots=True)
class BapsType:
    """components: of a point, belts counted; length: elements of a one-dimensional FIELD, 0: no field."""

    kind: Kind
    components: int = 0
    length: int = 0

    @property
    def size(self) -> int:
        """Bytes in a block."""
        one = {Kind.BINARY: 1, Kind.CHARACTER: 1, Kind.TEXT: TEXT_BYTES}.get(self.kind, 4)
        return one * max(1, self.components) * max(1, self.length)

    @property
    def element(self) -> "BapsType":
        """Of a field."""
        return BapsType(self.kind, self.components)


BINARY, CHARACTER, INTEGER, REAL, TEXT = (BapsType(kind) for kind in (Kind.BINARY, Kind.CHARACTER, Kind.INTEGER, Kind.REAL, Kind.TEXT))


class ItemError(ProtocolError):
    """A value that cannot be written, or bytes that are not a value; with the resulting CONDITION code."""

    def __init__(self, condition: Condition, words: str) -> None:
        super().__init__(words)
        self.condition = condition


def point(coordinates: int, belts: int = 0) -> BapsType:
    """Return a POINT of a kinematic with these coordinates and belts."""
    return BapsType(Kind.POINT, coordinates + belts)


def jc_point(axes: int, belts: int = 0) -> BapsType:
    """Return a JC_POINT of a kinematic with these axes and belts."""
    return BapsType(Kind.JC_POINT, axes + belts)


def array(element: BapsType, length: int) -> BapsType:
    """FIELD [1..length] OF element.  Raises ItemError for a field of fields or of TEXT (7.2 names neither) and for no elements."""
    if element.length or element.kind is Kind.TEXT or length < 1:
        raise ItemError(Condition.PROTOCOL, f"FIELD [1..{length}] of {element}: one dimension, no TEXT, at least one element (7.2)")
    return BapsType(element.kind, element.components, length)


def pack(kind: BapsType, value: Value, low_byte_first: bool = True) -> bytes:
    """The bytes of one value.  Raises ItemError."""
    order = "<" if low_byte_first else ">"
    if kind.length:
        return b"".join(pack(kind.element, one, low_byte_first) for one in _several(kind, value, kind.length))
    match kind.kind:
        case Kind.BINARY:
            return bytes((whole(value, range(2), "BINARY"),))
        case Kind.CHARACTER:
            return bytes((whole(value, range(256), "CHARACTER"),))
        case Kind.INTEGER:
            return struct.pack(order + "i", whole(value, INTEGERS, "INTEGER"))
        case Kind.REAL:
            return _single(value, order)
        case Kind.TEXT:
            return text_bytes(value).ljust(TEXT_BYTES, b"\0")
        case Kind.POINT | Kind.JC_POINT:
            return b"".join(_single(one, order) for one in _several(kind, value, kind.components))


def unpack(kind: BapsType, data: bytes, low_byte_first: bool = True) -> Value:
    """Return the value of exactly kind.size bytes; TEXT returns all 80 (see as_text).  Raise ItemError: "Protocol error READ"."""
    if len(data) != kind.size:
        raise _no_value(kind, data)
    order = "<" if low_byte_first else ">"
    if kind.length:
        return _parts(kind.element, data, low_byte_first)
    match kind.kind:
        case Kind.BINARY:
            if data[0] > 1:
                raise _no_value(kind, data)
            return bool(data[0])
        case Kind.CHARACTER:
            return data[0]
        case Kind.INTEGER:
            return int(struct.unpack(order + "i", data)[0])
        case Kind.REAL:
            return _number(kind, data, order)
        case Kind.TEXT:
            return bytes(data)
        case Kind.POINT | Kind.JC_POINT:
            return _parts(REAL, data, low_byte_first)


def as_text(value: bytes) -> bytes:
    """What the text operations of BAPS see of a TEXT: NUL ends it (7.2)."""
    return value.partition(b"\0")[0]


def whole(value: Value, legal: range, name: str) -> int:
    """Raise ItemError for anything but an integer of this range."""
    if not isinstance(value, int) or value not in legal:
        raise ItemError(Condition.PROTOCOL, f"{name} {value!r}: {legal.start} to {legal.stop - 1}")
    return int(value)


def real(value: Value) -> float:
    """Raise ItemError for a value that is not a number or does not fit a single."""
    if isinstance(value, (int, float)) and math.isfinite(value) and abs(value) < 3.4028235677973366e38:
        return float(value)
    raise ItemError(Condition.POINT if value is None else Condition.DEC_VALUE, f"REAL {value!r}: a finite IEEE single")


def text_bytes(value: Value) -> bytes:
    """Raises ItemError for more than 80 characters."""
    if not isinstance(value, bytes) or len(value) > TEXT_BYTES:
        raise ItemError(Condition.LENGTH, f"TEXT {value!r}: at most {TEXT_BYTES} characters")
    return value


def components(kind: BapsType, value: Value) -> tuple[float, ...]:
    """Of a point.  Raises ItemError."""
    return tuple(real(one) for one in _several(kind, value, kind.components))


def _single(value: Value, order: str) -> bytes:
    return struct.pack(order + "f", real(value))


def _several(kind: BapsType, value: Value, count: int) -> tuple[Value, ...]:
    if not isinstance(value, tuple) or len(value) != count:
        code = Condition.POINT if kind.components and not kind.length else Condition.PROTOCOL
        raise ItemError(code, f"{kind.kind.name} {value!r}: {count} values expected ({WORDS[code]})")
    return value


def _parts(element: BapsType, data: bytes, low_byte_first: bool) -> tuple[Value, ...]:
    return tuple(unpack(element, data[at : at + element.size], low_byte_first) for at in range(0, len(data), element.size))


def _number(kind: BapsType, data: bytes, order: str) -> float:
    number = float(struct.unpack(order + "f", data)[0])
    if not math.isfinite(number):  # on the rho 3 an FPU trap (7.4)
        raise _no_value(kind, data)
    return number


def _no_value(kind: BapsType, data: bytes) -> ItemError:
    return ItemError(Condition.PROTOCOL, f"Protocol error READ: {kind.kind.name} needs {kind.size} bytes, not {data.hex(' ')}")
