"""Bit-field layouts of frames: plain tables, compiled once to shifts and masks.

Signals are little endian (DBC "@1"), raw counts without scale; the unit stands in the signal's name or in `unit` for people.
"""

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


class Packer:
    """A layout compiled for the signals `names`, in this order.

    Bits of signals that are not named are sent as 0 and ignored when received.  The first `flags` signals have one bit each; what they can
    be together is worked out once and looked up then: a drive's bits stay the same for thousands of cycles.
    """

    __slots__ = ("_fields", "_flag_bits", "_flag_words", "_length", "_name", "_seen", "_signals", "flags")

    def __init__(self, layout: Layout, names: Sequence[str]) -> None:
        """Raises EncodeError with the list of missing signals when the layout does not have all names."""
        known = {signal.name: signal for signal in layout.signals}
        missing = [name for name in names if name not in known]
        if missing:
            raise EncodeError(f"message {layout.name} ({layout.identifier}) misses the signals: {', '.join(missing)}")
        self._name, self._length = layout.name, layout.length
        self._signals = tuple(known[name] for name in names)
        self.flags = next((n for n, s in enumerate(self._signals) if s.bits != 1 or s.signed or s.low or s.high != 1), len(names))
        self._flag_bits = sum(1 << s.start for s in self._signals[: self.flags])
        self._flag_words: dict[tuple[int, ...], int] = {}
        self._seen: dict[int, tuple[int, ...]] = {}
        wide = self._signals[self.flags :]
        self._fields = tuple((s.start, (1 << s.bits) - 1, 1 << (s.bits - 1) if s.signed else 0, s.low, s.high) for s in wide)

    def pack(self, values: Sequence[int]) -> bytes:
        """Raises EncodeError naming signal, value and range."""
        flags = tuple(values[: self.flags])
        word = self._flag_words.get(flags, -1)
        if word < 0:
            word = self._flag_words[flags] = self._flag_word(flags)
        for value, (start, mask, _sign, low, high) in zip(values[self.flags :], self._fields, strict=True):
            if not low <= value <= high:
                raise EncodeError(self._complaint(values))
            word |= (value & mask) << start
        return word.to_bytes(self._length, "little")

    def unpack(self, data: bytes) -> list[int]:
        """Flags as bool.  Raises DecodeError with the bytes when the length is wrong or a value is outside its range."""
        if len(data) != self._length:
            raise DecodeError(f"{self._name}: {self._length} bytes expected, {len(data)} received: {data.hex(' ')}")
        word = int.from_bytes(data, "little")
        bits = word & self._flag_bits
        flags = self._seen.get(bits)
        if flags is None:
            flags = self._seen[bits] = tuple(bool(word >> s.start & 1) for s in self._signals[: self.flags])
        values = [*flags]
        for start, mask, sign, low, high in self._fields:
            value = (((word >> start) & mask) ^ sign) - sign
            if not low <= value <= high:
                raise DecodeError(f"{self._outside(len(values), value)}: {data.hex(' ')}")
            values.append(value)
        return values

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
