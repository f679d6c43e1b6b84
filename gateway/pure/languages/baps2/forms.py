"""Values as bytes: binary as protocol 8 (3964R) and BNR files have them, characters for all else (rho 3 releases L1957-1983, 6942-6944)."""

import struct

from gateway.pure.languages.baps2.types import CODE_PAGE, TEXT_SIZE
from gateway.pure.languages.baps2.values import MOST_REAL, Array

REAL_WIDTH = 8  # CHR(9) with the final NUL (L9853-9857)
BLANKS = b" \t,;\r\n\0"
SIZES = {"BINARY": 1, "CHAR": 1, "INTEGER": 4, "REAL": 4, "TEXT": TEXT_SIZE}


class BadForm(Exception):
    """The bytes are not of the type.  `code`: value of CONDITION."""

    def __init__(self, code: int) -> None:
        super().__init__(str(code))
        self.code = code


def encode(base: str, value: object, *, binary: bool, file: bool = False) -> bytes:
    """One value of a WRITE, or all elements of an array."""
    separator = b" " if file else b","  # a readable file (L7214-7245); AX-164
    if isinstance(value, Array):
        between = b"" if binary or base == "CHAR" else separator
        return between.join(encode(base, item, binary=binary, file=file) for item in value.items)
    return _binary(base, value, file) if binary else _letters(base, value, separator)


def _binary(base: str, value: object, file: bool) -> bytes:
    if isinstance(value, tuple):
        return b"".join(_single(each) for each in value)
    if base == "TEXT":
        return _octets(str(value)).ljust(TEXT_SIZE, b"\0")[:TEXT_SIZE]
    if base == "CHAR":
        return _octets(str(value))[:1]
    if base == "REAL":
        return _single(value)
    number = int(value) if isinstance(value, int | float) else 0
    return bytes([number & 1]) if base == "BINARY" and not file else number.to_bytes(4, "little", signed=True)


def _single(value: object) -> bytes:
    number = float(value) if isinstance(value, int | float) else 0.0
    return struct.pack("<f", max(-MOST_REAL, min(MOST_REAL, number)))


def _octets(text: str) -> bytes:
    return text.encode(CODE_PAGE, "replace")


def _letters(base: str, value: object, separator: bytes) -> bytes:
    if isinstance(value, tuple):
        return separator.join(_letters("REAL", each, separator) for each in value)
    if base == "REAL" and isinstance(value, int | float):
        return real_text(float(value)).encode()
    if base == "TEXT":
        return _octets(str(value).partition("\0")[0])
    return _octets(str(value))


def real_text(value: float) -> str:
    """A REAL in eight characters, right-aligned (L9853-9857, AX-1821): the digits that fit, an exponent where it is more exact."""
    text = _positional(value)
    if float(text or "inf") != value:
        exponent = next(each for each in (f"{value:.{digits}E}" for digits in (2, 1, 0)) if len(each) <= REAL_WIDTH)
        text = exponent if not text or abs(float(exponent) - value) < abs(float(text) - value) else text
    return text.rjust(REAL_WIDTH)


def _positional(value: float) -> str:
    """Without an exponent and without zeros at its end; "": it does not fit."""
    for decimals in range(REAL_WIDTH - 2, 0, -1):
        text = f"{value:.{decimals}f}"
        if len(text) <= REAL_WIDTH:
            whole, _, behind = text.partition(".")
            return f"{whole}.{behind.rstrip('0') or '0'}"
    return next((text for text in (f"{value:#.0f}", f"{value:.0f}") if len(text) <= REAL_WIDTH), "")


def decode_binary(base: str, size: int, data: bytes, file: bool) -> object:
    """One value of exactly its bytes.  BadForm: a BINARY that is not 0 or 1, a REAL that is none."""
    if base in ("POINT", "JC_POINT"):
        return tuple(_real(data[at : at + 4]) for at in range(0, size * 4, 4))
    if base == "TEXT":
        return data.partition(b"\0")[0].decode(CODE_PAGE)
    if base == "CHAR":
        return data.decode(CODE_PAGE)
    if base == "REAL":
        return _real(data)
    number = int.from_bytes(data, "little", signed=base == "INTEGER" or file)
    if base == "BINARY" and number not in (0, 1):
        raise BadForm(-9)
    return number


def _real(data: bytes) -> float:
    (number,) = struct.unpack("<f", data)
    if not abs(number) <= MOST_REAL:
        raise BadForm(-10)
    return float(number)


def bytes_of(base: str, size: int, file: bool) -> int:
    """Bytes of one value in binary form."""
    if base in ("POINT", "JC_POINT"):
        return 4 * size
    return 4 if file and base == "BINARY" else SIZES[base]


def decode_letters(base: str, size: int, data: bytes) -> tuple[object, int]:
    """Return one value from characters and the number of characters used.  Raise BadForm for an invalid value."""
    if base == "CHAR":
        return data[:1].decode(CODE_PAGE), 1
    if base == "TEXT":
        return _line(data)
    if base in ("POINT", "JC_POINT"):
        found, at = [], 0
        for _ in range(max(size, 1)):
            number, taken = _number("REAL", data[at:])
            found.append(float(number))
            at += taken
        return tuple(found), at
    return _number(base, data)


def _line(data: bytes) -> tuple[str, int]:
    end = next((at for at, sign in enumerate(data) if sign in b"\r\n\0"), len(data))
    taken = min(end, TEXT_SIZE)
    return data[:taken].decode(CODE_PAGE), taken + (_end(data, end) if taken == end else 0)


def _end(data: bytes, at: int) -> int:
    """Characters of the line end there."""
    return 2 if data[at : at + 2] == b"\r\n" else 1 if at < len(data) else 0


def _number(base: str, data: bytes) -> tuple[int | float, int]:
    begin = len(data) - len(data.lstrip(BLANKS))
    end = next((at for at in range(begin, len(data)) if data[at] in BLANKS), len(data))
    text, taken = data[begin:end].decode(CODE_PAGE), end + _end(data, end)
    try:
        value = float(text) if base == "REAL" else int(text)
    except ValueError:
        raise BadForm(-10 if base == "REAL" else -9) from None
    if (
        "_" in text  # a number to Python
        or (base == "REAL" and not abs(value) <= MOST_REAL)
        or (base == "BINARY" and value not in (0, 1))
        or (not -(2**31) <= value < 2**31 and base != "REAL")
    ):
        raise BadForm(-10 if base == "REAL" else -9)
    return value, taken
