"""Number formats of STEP 5 data words: values <-> bytes, high byte first, high word first (AX-010, AX-056).

KG is the floating point of the S5 135U/155U and not IEEE: value = mantissa / 2^23 x 2^exponent, byte 0 the exponent, bytes 1..3 the
mantissa, both two's complement.  Range as the 155U manual prints it: 7F7FFFFFh = 0.1701412E+39.
"""

import math
import struct
from enum import Enum

from protocols.base.errors import DecodeError, EncodeError

Value = bool | int | float | str | tuple[int, int]


class Step5Type(Enum):
    """The value is the name written in a cell file."""

    BIT = "bit"  # bool; a word of its own here, for one bit of a word see get_bit, with_bit
    KF = "KF"  # int, fixed point 16 bit: -32768..32767
    DH = "DH"  # int, double word fixed point: -2147483648..2147483647
    KH = "KH"  # int, hexadecimal word: 0..FFFFh
    KM = "KM"  # int, bit pattern: 0..FFFFh
    KY = "KY"  # (int, int), two bytes 0..255: left, right
    KC = "KC"  # str, two characters
    KT = "KT"  # (int, int), timer: 0..999 and time base 0..3 = 0.01, 0.1, 1, 10 s
    KZ = "KZ"  # int, counter: 0..999
    KG = "KG"  # float, 32 bit, not IEEE
    REAL = "REAL"  # float, 32 bit, IEEE single
    BCD = "BCD"  # int, four decimal digits: 0..9999

    @property
    def size(self) -> int:
        """Bytes: 2 or 4."""
        return 4 if self in _LONG else 2


_LONG = (Step5Type.DH, Step5Type.KG, Step5Type.REAL)
_RANGES = {
    Step5Type.KF: (-0x8000, 0x7FFF),
    Step5Type.DH: (-0x8000_0000, 0x7FFF_FFFF),
    Step5Type.KH: (0, 0xFFFF),
    Step5Type.KM: (0, 0xFFFF),
    Step5Type.KZ: (0, 999),
    Step5Type.BCD: (0, 9999),
}
_KG_ZERO = b"\x80\x00\x00\x00"
_KG_SMALLEST = 2.0**-129
_KG_LARGEST = (2**23 - 1) * 2.0**104
_REAL_LARGEST = (2**24 - 1) * 2.0**104


def encode(kind: Step5Type, value: Value, low_word_first: bool = False) -> bytes:
    """The bytes of one value; EncodeError names value and range.  Floats are rounded to the nearest number of the format."""
    data = _encode(kind, value)
    return data[2:] + data[:2] if low_word_first else data


def decode(kind: Step5Type, data: bytes, low_word_first: bool = False) -> Value:
    """The value of the bytes; DecodeError for a wrong length or an invalid pattern (digit A..F, NaN, infinite)."""
    if len(data) != kind.size:
        raise DecodeError(f"{kind.value}: {kind.size} bytes expected, {len(data)} received: {data.hex(' ')}")
    return _decode(kind, data[2:] + data[:2] if low_word_first else bytes(data))


def range_of(kind: Step5Type) -> tuple[float, float]:
    """Least and largest number the format holds; EncodeError for KY, KC and KT, which are not one number."""
    match kind:
        case Step5Type.BIT:
            return 0, 1
        case Step5Type.KG:
            return -_KG_LARGEST, _KG_LARGEST
        case Step5Type.REAL:
            return -_REAL_LARGEST, _REAL_LARGEST
        case Step5Type.KY | Step5Type.KC | Step5Type.KT:
            raise EncodeError(f"{kind.value} is not one number: it has no range")
    return _RANGES[kind]


def get_bit(word: bytes, bit: int) -> bool:
    """D n.bit of one data word; bit 0 is the lowest bit of the right byte."""
    _need_bit(word, bit)
    return bool(int.from_bytes(word, "big") >> bit & 1)


def with_bit(word: bytes, bit: int, value: bool) -> bytes:
    """The word with one bit set or cleared."""
    _need_bit(word, bit)
    number = int.from_bytes(word, "big") & ~(1 << bit) | value << bit
    return number.to_bytes(2, "big")


def _need_bit(word: bytes, bit: int) -> None:
    if len(word) != 2:
        raise DecodeError(f"bit: 2 bytes expected, {len(word)} received: {word.hex(' ')}")
    if not 0 <= bit <= 15:
        raise EncodeError(f"bit = {bit}, range 0..15")


def _encode(kind: Step5Type, value: Value) -> bytes:
    match kind:
        case Step5Type.BIT:
            return b"\x00\x01" if _whole(kind, value, 0, 1) else b"\x00\x00"
        case Step5Type.KY:
            return bytes(_pair(kind, value, 255, 255))
        case Step5Type.KT:
            count, base = _pair(kind, value, 999, 3)
            return (base << 12 | _to_digits(count)).to_bytes(2, "big")
        case Step5Type.KC:
            return _characters(value)
        case Step5Type.KG:
            return _encode_kg(_finite(kind, value, _KG_LARGEST))
        case Step5Type.REAL:
            return _encode_real(_finite(kind, value, _REAL_LARGEST))
        case _:
            number = _whole(kind, value, *_RANGES[kind])
            if kind in (Step5Type.KZ, Step5Type.BCD):
                number = _to_digits(number)
            return number.to_bytes(kind.size, "big", signed=number < 0)


def _decode(kind: Step5Type, data: bytes) -> Value:
    word = int.from_bytes(data, "big")
    match kind:
        case Step5Type.BIT:
            if word > 1:
                raise DecodeError(f"bit: 0 or 1 expected: {data.hex(' ')}")
            return bool(word)
        case Step5Type.KF | Step5Type.DH:
            return int.from_bytes(data, "big", signed=True)
        case Step5Type.KY:
            return data[0], data[1]
        case Step5Type.KC:
            return data.decode("latin-1")
        case Step5Type.KT:
            if word >> 12 > 3:
                raise DecodeError(f"KT: time base 0..3 expected: {data.hex(' ')}")
            return _from_digits(kind, word & 0xFFF, data), word >> 12
        case Step5Type.KZ:
            if word >> 12:
                raise DecodeError(f"KZ: 0..999 expected: {data.hex(' ')}")
            return _from_digits(kind, word, data)
        case Step5Type.BCD:
            return _from_digits(kind, word, data)
        case Step5Type.KG:
            return _decode_kg(data)
        case Step5Type.REAL:
            return _decode_real(data)
        case _:
            return word


# ---- permitted values
def _whole(kind: Step5Type, value: Value, least: int, most: int) -> int:
    if not isinstance(value, int) or not least <= value <= most:
        raise EncodeError(f"{kind.value} = {value!r}, range {least}..{most}, whole number")
    return int(value)


def _pair(kind: Step5Type, value: Value, most_left: int, most_right: int) -> tuple[int, int]:
    if not isinstance(value, tuple) or len(value) != 2:
        raise EncodeError(f"{kind.value} = {value!r}, range 0..{most_left} and 0..{most_right}, two numbers")
    return _whole(kind, value[0], 0, most_left), _whole(kind, value[1], 0, most_right)


def _characters(value: Value) -> bytes:
    try:
        data = value.encode("latin-1") if isinstance(value, str) else b""
    except UnicodeEncodeError:
        data = b""
    if len(data) != 2:
        raise EncodeError(f"KC = {value!r}, range two characters of one byte each")
    return data


def _finite(kind: Step5Type, value: Value, largest: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not -largest <= value <= largest:
        raise EncodeError(f"{kind.value} = {value!r}, range {-largest:.9g}..{largest:.9g}, number")
    return float(value)


# ---- digits and floats
def _to_digits(number: int) -> int:
    return int(str(number), 16)


def _from_digits(kind: Step5Type, word: int, data: bytes) -> int:
    text = f"{word:x}"
    if not text.isdecimal():
        raise DecodeError(f"{kind.value}: a digit above 9: {data.hex(' ')}")
    return int(text)


def _encode_kg(value: float) -> bytes:
    fraction, exponent = math.frexp(value)  # 0.5 <= |fraction| < 1
    mantissa = round(fraction * 2**23)
    if abs(mantissa) == 2**23:  # rounded up to 1.0: KG has it as 0.5 x 2
        mantissa, exponent = mantissa // 2, exponent + 1
    if mantissa == 0 or abs(value) <= _KG_SMALLEST / 2:
        return _KG_ZERO
    if exponent < -128:  # nearer to the smallest number than to zero
        mantissa, exponent = int(math.copysign(2**22, value)), -128
    return struct.pack(">b", exponent) + mantissa.to_bytes(3, "big", signed=True)


def _decode_kg(data: bytes) -> float:
    exponent, mantissa = struct.unpack(">b", data[:1])[0], int.from_bytes(data[1:], "big", signed=True)
    if mantissa == 0 and exponent not in (-128, 0):
        raise DecodeError(f"KG: zero is 80 00 00 00 or 00 00 00 00: {data.hex(' ')} is not KG; it looks like an IEEE number")
    return math.ldexp(mantissa, exponent - 23)


def _encode_real(value: float) -> bytes:
    return struct.pack(">f", value)


def _decode_real(data: bytes) -> float:
    value: float = struct.unpack(">f", data)[0]
    if not math.isfinite(value):
        raise DecodeError(f"REAL: not a number: {data.hex(' ')}")
    return value
