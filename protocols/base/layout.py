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

    Bits of signals that are not named are sent as 0 and ignored when received.
    """

    __slots__ = ("_fields", "_length", "_name", "_signals")

    def __init__(self, layout: Layout, names: Sequence[str]) -> None:
        """Raises EncodeError with the list of missing signals when the layout does not have all names."""
        known = {signal.name: signal for signal in layout.signals}
        missing = [name for name in names if name not in known]
        if missing:
            raise EncodeError(f"message {layout.name} ({layout.identifier}) misses the signals: {', '.join(missing)}")
        self._name, self._length = layout.name, layout.length
        self._signals = tuple(known[name] for name in names)
        self._fields = tuple((s.start, (1 << s.bits) - 1, 1 << (s.bits - 1) if s.signed else 0, s.low, s.high) for s in self._signals)

    def pack(self, values: Sequence[int]) -> bytes:
        """Raises EncodeError naming signal, value and range."""
        word = 0
        for value, (start, mask, _sign, low, high) in zip(values, self._fields, strict=True):
            if not low <= value <= high:
                raise EncodeError(self._complaint(values))
            word |= (value & mask) << start
        return word.to_bytes(self._length, "little")

    def unpack(self, data: bytes) -> list[int]:
        """Raises DecodeError with the bytes when the length is wrong or a value is outside its range."""
        if len(data) != self._length:
            raise DecodeError(f"{self._name}: {self._length} bytes expected, {len(data)} received: {data.hex(' ')}")
        word = int.from_bytes(data, "little")
        values: list[int] = []
        for start, mask, sign, low, high in self._fields:
            value = (((word >> start) & mask) ^ sign) - sign
            if not low <= value <= high:
                raise DecodeError(f"{self._outside(len(values), value)}: {data.hex(' ')}")
            values.append(value)
        return values

    def _complaint(self, values: Sequence[int]) -> str:
        return "; ".join(
            self._outside(i, v) for i, (v, s) in enumerate(zip(values, self._signals, strict=True)) if not s.low <= v <= s.high
        )

    def _outside(self, index: int, value: int) -> str:
        signal = self._signals[index]
        unit = f" {signal.unit}" if signal.unit else ""
        return f"{self._name}.{signal.name} = {value} is outside {signal.low}..{signal.high}{unit}"
