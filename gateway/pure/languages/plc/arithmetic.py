"""Accumulators of 32 bits, signed, two's complement."""

LOW, HIGH = -0x80000000, 0x7FFFFFFF
BCD_HIGH = 99_999_999


def wrap(value: int) -> int:
    """The low 32 bits as a signed number."""
    value &= 0xFFFFFFFF
    return value - 0x100000000 if value > HIGH else value


def divide(dividend: int, divisor: int) -> tuple[int, int] | None:
    """(quotient towards zero, rest with the sign of the dividend); None: by zero, or the quotient has no 32 bits."""
    if divisor == 0:
        return None
    quotient = abs(dividend) // abs(divisor)
    if (dividend < 0) != (divisor < 0):
        quotient = -quotient
    return None if quotient > HIGH else (quotient, dividend - quotient * divisor)


def shift_right(value: int, places: int) -> int:
    """Zeros move in from the left."""
    return wrap((value & 0xFFFFFFFF) >> places)


def shift_left(value: int, places: int) -> int:
    """Zeros move in from the right."""
    return wrap(value << places)


def rotate_left(value: int, places: int) -> int:
    """Bits that leave on the left come back on the right."""
    bits = value & 0xFFFFFFFF
    return wrap(bits << places | bits >> 32 - places)


def rotate_right(value: int, places: int) -> int:
    """Bits that leave on the right come back on the left."""
    return rotate_left(value, (32 - places) % 32)


def to_bcd(value: int) -> int:
    """The decimal digits as nibbles; a value that has no eight digits remains."""
    return wrap(int(str(value), 16)) if 0 <= value <= BCD_HIGH else value


def from_bcd(value: int) -> int:
    """The nibbles as decimal digits; a value with a nibble above 9 remains."""
    digits = f"{value & 0xFFFFFFFF:x}"
    return int(digits) if digits.isdecimal() else value
