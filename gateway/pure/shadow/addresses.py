"""Comparison of a block of bytes: declared bits and numbers by their names, the others word by word (AX-493)."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from gateway.pure.arbitration.data_blocks import DataBlock, Slot
from protocols.base.errors import ProtocolError

LIFE = "cell.life"  # counts independently on either side: only that it counts is compared
FLOAT_SHARE = 0.01  # of the factor: so near to one another floats are the same number


@dataclass(frozen=True, slots=True)
class Place:
    """One bit, one number, or the rest of a word."""

    label: str  # D 0.8, DW 2
    name: str  # move.busy; "" where it is not declared
    at: int  # first byte in its block
    mask: bytes  # which bits of which bytes
    number: Callable[[bytes], float] | None = None  # None: bits, equal or not
    within: float = 0.0  # numbers so near to one another are equal, in the unit of the number
    counts: bool = False

    def part(self, data: bytes) -> bytes:
        """Return its bits of a complete block."""
        part = data[self.at : self.at + len(self.mask)]
        if self.whole:
            return part
        return bytes([octet & mask for octet, mask in zip(part, self.mask, strict=False)])

    @property
    def whole(self) -> bool:
        """All bits of its bytes."""
        return self.mask.count(0xFF) == len(self.mask)

    def value(self, data: bytes) -> float:
        """Return the value as a number: bits by their weight, NaN where the bytes are not of that type."""
        part = self.part(data)
        if self.number is not None:
            return self.number(part)
        if len(part) < len(self.mask):
            return math.nan
        worth, mask = int.from_bytes(part, "big"), int.from_bytes(self.mask, "big")
        return float(worth // (mask & -mask)) if mask.bit_count() == 1 else float(worth)


def places_of(block: DataBlock) -> list[Place]:
    """Every bit of a block in exactly one place, the declared ones by their names."""
    left = bytearray(b"\xff" * (2 * block.words))
    found = [_slot_place(block, slot) for slot in block.slots]
    for place in found:
        for n, mask in enumerate(place.mask):
            left[place.at + n] &= ~mask
    return sorted(found + rest_of(bytes(left)), key=lambda place: (place.at, [-octet for octet in place.mask]))


def rest_of(left: bytes) -> list[Place]:
    """Words of which some bits are left."""
    rows = []
    for at in range(0, len(left) - 1, 2):
        mask = left[at : at + 2]
        if any(mask):
            rows.append(Place(f"DW {at // 2}" + ("" if mask == b"\xff\xff" else ", other bits"), "", at, mask))
    return rows


def _slot_place(block: DataBlock, slot: Slot) -> Place:
    if slot.type is None:
        return Place(f"D {slot.word}.{slot.bit}", slot.name, 2 * slot.word, (1 << slot.bit).to_bytes(2, "big"))
    reader = _reader(block, slot)
    whole = slot.type.name not in ("KG", "REAL")
    within = slot.factor * (1.0 if whole else FLOAT_SHARE)
    at = 2 * slot.word + (slot.half == "R")
    label = f"D{slot.half or ('W' if slot.size == 2 else 'D')} {slot.word}"
    size = 1 if slot.half else slot.size
    if slot.type.name in ("KH", "KM") and slot.factor == 1.0:
        within = 0.0  # codes have no tolerance
    return Place(label, slot.name, at, b"\xff" * size, reader, within, slot.name == LIFE)


def _reader(block: DataBlock, slot: Slot) -> Callable[[bytes], float]:
    at = 2 * slot.word + (slot.half == "R")

    def number(part: bytes) -> float:
        probe = DataBlock(block.number, block.words, block.from_plc)
        probe.data[at : at + len(part)] = part
        try:
            return probe.get(slot)
        except ProtocolError:
            return math.nan

    return number
