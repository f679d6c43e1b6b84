"""Data types of the object dictionary.  Source: CiA 301, 7.1.4 (encoding, little endian) and 7.4.7.1 (codes of the types)."""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto

from protocols.base.errors import DecodeError, EncodeError

Value = int | float | str | bytes


class Kind(Enum):
    BOOLEAN = auto()
    SIGNED = auto()
    UNSIGNED = auto()
    REAL = auto()
    TEXT = auto()
    BYTES = auto()


@dataclass(frozen=True, slots=True)
class DataType:
    code: int
    name: str
    kind: Kind
    bits: int  # 0: of any length

    @property
    def size(self) -> int:
        """Bytes in an SDO; 0: any length."""
        return (self.bits + 7) // 8

    @property
    def low(self) -> int:
        return -(1 << (self.bits - 1)) if self.kind is Kind.SIGNED else 0

    @property
    def high(self) -> int:
        return (1 << (self.bits - 1)) - 1 if self.kind is Kind.SIGNED else (1 << self.bits) - 1

    @property
    def whole(self) -> bool:
        """Its values are integers."""
        return self.kind in (Kind.BOOLEAN, Kind.SIGNED, Kind.UNSIGNED)

    @property
    def zero(self) -> Value:
        return "" if self.kind is Kind.TEXT else b"" if self.kind is Kind.BYTES else 0.0 if self.kind is Kind.REAL else 0


def _table() -> dict[int, DataType]:
    signed = {2: 8, 3: 16, 4: 32, 0x10: 24, 0x12: 40, 0x13: 48, 0x14: 56, 0x15: 64}
    unsigned = {5: 8, 6: 16, 7: 32, 0x16: 24, 0x18: 40, 0x19: 48, 0x1A: 56, 0x1B: 64}
    types = [DataType(1, "BOOLEAN", Kind.BOOLEAN, 1)]
    types += [DataType(code, f"INTEGER{bits}", Kind.SIGNED, bits) for code, bits in signed.items()]
    types += [DataType(code, f"UNSIGNED{bits}", Kind.UNSIGNED, bits) for code, bits in unsigned.items()]
    types += [DataType(8, "REAL32", Kind.REAL, 32), DataType(0x11, "REAL64", Kind.REAL, 64)]
    types += [DataType(9, "VISIBLE_STRING", Kind.TEXT, 0), DataType(0xB, "UNICODE_STRING", Kind.TEXT, 0)]
    types += [DataType(0xA, "OCTET_STRING", Kind.BYTES, 0), DataType(0xF, "DOMAIN", Kind.BYTES, 0)]
    types += [DataType(0xC, "TIME_OF_DAY", Kind.BYTES, 48), DataType(0xD, "TIME_DIFFERENCE", Kind.BYTES, 48)]
    return {item.code: item for item in types}


TYPES: Mapping[int, DataType] = _table()
BY_NAME: Mapping[str, DataType] = {item.name: item for item in TYPES.values()}
DOMAIN = BY_NAME["DOMAIN"]
UNSIGNED8, UNSIGNED16, UNSIGNED32 = BY_NAME["UNSIGNED8"], BY_NAME["UNSIGNED16"], BY_NAME["UNSIGNED32"]
INTEGER8, INTEGER16, INTEGER32 = BY_NAME["INTEGER8"], BY_NAME["INTEGER16"], BY_NAME["INTEGER32"]


def encode(kind: DataType, value: Value) -> bytes:
    """The value's bytes.  Raises EncodeError when it is of another kind or out of range."""
    if kind.whole and isinstance(value, int) and kind.low <= value <= kind.high:
        return (value & ((1 << 8 * kind.size) - 1)).to_bytes(kind.size, "little")
    if kind.kind is Kind.REAL and isinstance(value, int | float):
        return struct.pack("<f" if kind.bits == 32 else "<d", value)
    if kind.kind is Kind.TEXT and isinstance(value, str):
        return value.encode("utf-16-le" if kind.name == "UNICODE_STRING" else "latin-1", "replace")
    if kind.kind is Kind.BYTES and isinstance(value, bytes) and kind.size in (0, len(value)):
        return value
    raise EncodeError(f"{value!r} is not a value of {kind.name}" + (f" ({kind.low}..{kind.high})" if kind.whole else ""))


def decode(kind: DataType, data: bytes) -> Value:
    """Raises DecodeError when the length is not that of the type."""
    if kind.size and len(data) != kind.size:
        raise DecodeError(f"{kind.name}: {kind.size} bytes expected, {len(data)} received: {data.hex(' ')}")
    if kind.whole:
        return int.from_bytes(data, "little", signed=kind.kind is Kind.SIGNED)
    if kind.kind is Kind.REAL:
        return float(struct.unpack("<f" if kind.bits == 32 else "<d", data)[0])
    if kind.kind is Kind.TEXT:
        return data.decode("utf-16-le" if kind.name == "UNICODE_STRING" else "latin-1", "replace")
    return data
