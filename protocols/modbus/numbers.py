"""Numbers wider than a register, in every word and byte order in use.

A 32-bit value ABCD (A the highest byte) is stored in two registers as AB CD, CD AB (words swapped), BA DC (bytes swapped) or DC BA (both).
V1.1b3, 4.2, fixes the bytes of one register (high first) and leaves more than one open; the default is ABCD.
64-bit values follow the same four letters: words in the given order, bytes in each as well.
"""

import struct
from collections.abc import Sequence

from protocols.base.errors import DecodeError, EncodeError

ORDERS = ("ABCD", "CDAB", "BADC", "DCBA")
CODES = {"INT16": "h", "UINT16": "H", "INT32": "i", "UINT32": "I", "INT64": "q", "UINT64": "Q", "REAL": "f", "LREAL": "d"}


def words_of(type_: str) -> int:
    """Number of registers for a value of this type; KeyError for a type not in CODES."""
    return struct.calcsize(CODES[type_]) // 2


def decode_number(words: Sequence[int], type_: str, order: str = "ABCD") -> float:
    """The value in these registers; DecodeError when their number does not fit the type."""
    if len(words) != words_of(type_):
        raise DecodeError(f"{type_} needs {words_of(type_)} registers, {len(words)} received: {list(words)}")
    value: float = struct.unpack(">" + CODES[type_], _arranged(struct.pack(f">{len(words)}H", *words), order))[0]
    return value


def encode_number(value: float, type_: str, order: str = "ABCD") -> tuple[int, ...]:
    """The registers of this value, integers rounded; EncodeError if it does not fit."""
    try:
        data = struct.pack(">" + CODES[type_], value if type_ in ("REAL", "LREAL") else round(value))
    except (struct.error, OverflowError, ValueError) as error:
        raise EncodeError(f"{value} does not fit {type_}: {error}") from error
    return struct.unpack(f">{len(data) // 2}H", _arranged(data, order))


def _arranged(data: bytes, order: str) -> bytes:
    """Between ABCD and `order`; the way back is the same."""
    words = [data[at : at + 2] for at in range(0, len(data), 2)]
    if order in ("CDAB", "DCBA"):
        words.reverse()
    if order in ("BADC", "DCBA"):
        words = [word[::-1] for word in words]
    return b"".join(words)
