"""Bit-field layouts of frames: plain tables, compiled once to shifts and masks.

Signals are little endian (DBC "@1"), raw counts without scale; the unit is in the signal's name or in `unit` for people.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

from protocols.base.errors import DecodeError, EncodeError


@dataclass(frozen=True, slots=True)
class Signal:
    """`bits` bits from bit `start` (bit 0 = lowest bit of byte 0)."""

    name: str
    start: int
    bits: int
    signed: bool
    low: int  # smallest legal raw value
    high: int
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Layout:
    """One message: CAN identifier, length in bytes, its signals."""

    name: str
    identifier: int
    length: int
    signals: tuple[Signal, ...]


NATURAL = {(8, False): "B", (8, True): "b", (16, False): "H", (16, True): "h", (32, False): "I", (32, True): "i"}


def _plain(length: int, flag_bits: int, wide: Sequence[Signal]) -> struct.Struct | None:
    """The complete message as byte 0 with the flags followed by numbers, in the order of `wide`; None: it is not so simple."""
    code, at = "<B", 1
    for signal in wide:
        kind = NATURAL.get((signal.bits, signal.signed))
        low = -(1 << signal.bits - 1) if signal.signed else 0
        if kind is None or signal.start % 8 or signal.start // 8 < at or (signal.low, signal.high) != (low, low + (1 << signal.bits) - 1):
            return None
        code += f"{signal.start // 8 - at}x{kind}"
        at = (signal.start + signal.bits) // 8
    return struct.Struct(f"{code}{length - at}x") if flag_bits < 256 and at <= length else None


class Packer:
    """A layout compiled for the signals `names`, in this order.

    Bits of signals that are not named are sent as 0 and ignored when received.  The first `flags` signals have one bit each; each
    combination is computed once and then looked up: a drive's bits stay the same for thousands of cycles.  Flags in byte 0 before integers
    of their full range, as SERVODYN-GC's are, are read and written together by `plain`; a caller in each axis and cycle may do it itself
    (`words`: all flags together, `seen`: the reverse) and leave only the rest to `pack` and `unpack`.
    """

    __slots__ = ("_fields", "_length", "_name", "_signals", "flag_bits", "flag_places", "flags", "plain", "seen", "words")

    def __init__(self, layout: Layout, names: Sequence[str]) -> None:
        """Raises EncodeError with the list of missing signals when the layout does not have all names."""
        known = {signal.name: signal for signal in layout.signals}
        missing = [name for name in names if name not in known]
        if missing:
            raise EncodeError(f"message {layout.name} ({layout.identifier}) misses the signals: {', '.join(missing)}")
        self._name, self._length = layout.name, layout.length
        self._signals = tuple(known[name] for name in names)
        self.flags = next((n for n, s in enumerate(self._signals) if s.bits != 1 or s.signed or s.low or s.high != 1), len(names))
        self.flag_places = tuple(s.start for s in self._signals[: self.flags])
        self.flag_bits = sum(1 << start for start in self.flag_places)
        self.words: dict[tuple[int, ...], int] = {}
        self.seen: dict[int, tuple[int, ...]] = {}
        wide = self._signals[self.flags :]
        self._fields = tuple((s.start, (1 << s.bits) - 1, 1 << (s.bits - 1) if s.signed else 0, s.low, s.high) for s in wide)
        self.plain = _plain(self._length, self.flag_bits, wide)

    def pack(self, values: Sequence[int]) -> bytes:
        """Raises EncodeError naming signal, value and range."""
        flags = tuple(values[: self.flags])
        word = self.words.get(flags, -1)
        if word < 0:
            word = self.words[flags] = self._flag_word(flags)
        if self.plain is not None:
            try:
                return self.plain.pack(word, *values[self.flags :])
            except struct.error as error:
                raise EncodeError(self._complaint(values)) from error
        for value, (start, mask, _sign, low, high) in zip(values[self.flags :], self._fields, strict=True):
            if not low <= value <= high:
                raise EncodeError(self._complaint(values))
            word |= (value & mask) << start
        return word.to_bytes(self._length, "little")

    def unpack(self, data: bytes) -> tuple[int, ...]:
        """Flags as bool.  Raises DecodeError with the bytes when the length is wrong or a value is outside its range."""
        if len(data) != self._length:
            raise DecodeError(f"{self._name}: {self._length} bytes expected, {len(data)} received: {data.hex(' ')}")
        if self.plain is not None:
            numbers: tuple[int, ...] = self.plain.unpack(data)
            bits = numbers[0] & self.flag_bits
            flags = self.seen.get(bits)
            return (self._see(bits) if flags is None else flags) + numbers[1:]
        word = int.from_bytes(data, "little")
        bits = word & self.flag_bits
        values = [*(self.seen.get(bits) or self._see(bits))]
        for start, mask, sign, low, high in self._fields:
            value = (((word >> start) & mask) ^ sign) - sign
            if not low <= value <= high:
                raise DecodeError(f"{self._outside(len(values), value)}: {data.hex(' ')}")
            values.append(value)
        return tuple(values)

    def _see(self, bits: int) -> tuple[int, ...]:
        """Flags as bool, kept for the next time."""
        flags = self.seen[bits] = tuple(bool(bits >> s.start & 1) for s in self._signals[: self.flags])
        return flags

    def _flag_word(self, flags: tuple[int, ...]) -> int:
        if not all(value in (0, 1) for value in flags):
            raise EncodeError(self._complaint(flags))
        return sum((value == 1) << signal.start for value, signal in zip(flags, self._signals[: self.flags], strict=True))

    def _complaint(self, values: Sequence[int]) -> str:
        return "; ".join(
            self._outside(i, v) for i, (v, s) in enumerate(zip(values, self._signals, strict=False)) if not s.low <= v <= s.high
        )

    def _outside(self, index: int, value: int) -> str:
        signal = self._signals[index]
        unit = f" {signal.unit}" if signal.unit else ""
        return f"{self._name}.{signal.name} = {value} is outside {signal.low}..{signal.high}{unit}"
