"""Finds the registers that contain a value read on the device's display.  Every type, every order, every register."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from protocols.base.errors import EncodeError
from protocols.modbus.numbers import ORDERS, decode_number, encode_number, words_of

WHOLE = ("INT16", "UINT16", "INT32", "UINT32", "INT64", "UINT64")
FACTORS = (1, 10, 100, 1000)  # a value with decimals is often stored as an integer
REFERENCE = {"holding": 40001, "input": 30001}


@dataclass(frozen=True, slots=True)
class Place:
    """A value found."""

    table: str  # holding | input
    address: int  # protocol address, base 0
    type: str
    order: str
    factor: int  # register = value x factor
    value: float  # content of the registers, divided by the factor

    @property
    def reference(self) -> str:
        """As manuals count: 40001 is holding register 0; six digits beyond 9999."""
        first = REFERENCE[self.table]
        return str(first + self.address) if self.address < 9999 else str(first // 10000 * 100000 + 1 + self.address)


def find(value: float, table: str, registers: Mapping[int, int]) -> list[Place]:
    """All places of `value` in these registers (address -> word), the likeliest first: few words, no factor, our order."""
    found = [*_whole(value, table, registers), *_real(value, table, registers)]
    return sorted(found, key=lambda place: (words_of(place.type), place.factor, ORDERS.index(place.order), place.address))


def _whole(value: float, table: str, registers: Mapping[int, int]) -> Iterator[Place]:
    for factor in FACTORS:
        scaled = value * factor
        if not math.isclose(scaled, round(scaled), rel_tol=1e-12, abs_tol=1e-9):
            continue
        for type_ in WHOLE:
            for order in _orders(type_, round(scaled)):
                try:
                    words = encode_number(round(scaled), type_, order)
                except EncodeError:
                    break
                yield from (Place(table, at, type_, order, factor, value) for at in registers if _matches(words, at, registers))


def _real(value: float, table: str, registers: Mapping[int, int]) -> Iterator[Place]:
    """A display shows fewer digits than a REAL has: half of the last one that was typed is let through."""
    tolerance = max(abs(value) * 1e-6, 0.5 * 10 ** -_decimals(value)) if value else 0.0
    for type_ in ("REAL", "LREAL"):
        for at in registers:
            words = [registers.get(at + n) for n in range(words_of(type_))]
            known = [word for word in words if word is not None]
            if len(known) != len(words) or not any(known):
                continue
            for order in ORDERS:
                held = decode_number(known, type_, order)
                if value and math.isfinite(held) and abs(held - value) <= tolerance and abs(held) >= abs(value) / 2:
                    yield Place(table, at, type_, order, 1, held)


def _decimals(value: float) -> int:
    return len(f"{value:.9g}".partition(".")[2]) if "e" not in f"{value:.9g}" else 9


def _orders(type_: str, value: int) -> tuple[str, ...]:
    """A single register has two orders of its bytes; a second 16-bit type would only repeat the first where the value is small."""
    if words_of(type_) == 1:
        return ("ABCD", "BADC") if (type_ == "INT16") is (value < 0) else ()
    signed = type_.startswith("INT")
    return ORDERS if signed is (value < 0) else ()


def _matches(words: tuple[int, ...], at: int, registers: Mapping[int, int]) -> bool:
    return all(registers.get(at + n) == word for n, word in enumerate(words))
