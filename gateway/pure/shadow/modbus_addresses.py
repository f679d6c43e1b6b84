"""What is compared in the answer to a read of coils or registers: bits by their names, wide numbers as numbers (AX-512)."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from gateway.pure.shadow.addresses import Place
from protocols.base.errors import DecodeError
from protocols.modbus.numbers import decode_number, words_of

TABLES = {1: "coil", 2: "discrete input", 3: "holding register", 4: "input register"}
BITS = (1, 2)
READS = tuple(TABLES)
READ_BYTES = 5  # of the request: function, address, quantity


@dataclass(frozen=True, slots=True)
class Number:
    """One value in registers next to one another."""

    name: str
    type: str
    within: float = 0.0
    order: str = "ABCD"
    counts: bool = False
    judged: bool = True


def read_name(unit: int, pdu: bytes) -> str:
    """ "unit 1, input registers 1000..1057"."""
    first, count = _span(pdu)
    last = f"..{first + count - 1}" if count > 1 else ""
    return f"unit {unit}, {TABLES[pdu[0]]}{'s' if count > 1 else ''} {first}{last}"


def read_places(pdu: bytes, bit_name: Callable[[int, int], str], numbers: Mapping[int, Number]) -> list[Place]:
    """Return the places in the data after the byte count.  `bit_name`: of a bit by function and address; `numbers`: by the address of the
    first register.
    """
    first, count = _span(pdu)
    table = TABLES[pdu[0]]
    if pdu[0] in BITS:
        return [Place(f"{table} {first + n}", bit_name(pdu[0], first + n), n >> 3, bytes((1 << (n & 7),))) for n in range(count)]
    places, n = [], 0
    while n < count:
        number = numbers.get(first + n)
        size = words_of(number.type) if number is not None else 1
        if number is None or n + size > count:
            places.append(Place(f"{table} {first + n}", "", 2 * n, b"\xff\xff"))
            n += 1
            continue
        if number.judged:
            reader = _reader(number)
            places.append(Place(f"{table} {first + n}", number.name, 2 * n, b"\xff\xff" * size, reader, number.within, number.counts))
        n += size
    return places


def _span(pdu: bytes) -> tuple[int, int]:
    return int.from_bytes(pdu[1:3], "big"), int.from_bytes(pdu[3:5], "big")


def _reader(number: Number) -> Callable[[bytes], float]:
    def read(part: bytes) -> float:
        try:
            return decode_number(_words(part), number.type, number.order)
        except DecodeError:
            return math.nan

    return read


def _words(part: bytes) -> Sequence[int]:
    return [int.from_bytes(part[at : at + 2], "big") for at in range(0, len(part), 2)]
