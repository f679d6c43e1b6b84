"""Modbus views of the other controls: the 40 bytes and markers of a Reis, the points of a VAL 3 controller (AX-408).

Both are views of the same image as RhoView: the PLC writes RC inputs in bytes that the command source owns, and reads the RC outputs that
all command sources share.  Word r = bytes 2r (high), 2r+1 (low) (AX-010).  Protocol addresses, base 0.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from gateway.pure.controllers.reis.binary import BYTES, FIRST_BYTE
from gateway.pure.controllers.reis.markers import SIZE
from gateway.pure.controllers.val3.io.control import Val3Control
from gateway.pure.controllers.val3.io.system import Point
from gateway.pure.image.records.cell import RC_BYTES, InputImage, get_bit, set_bit
from gateway.pure.modbus.registers import Registers
from gateway.pure.modbus.rho3_view import FLAGS_AT, MISSING, Flags
from protocols.base.errors import EncodeError
from protocols.modbus.numbers import decode_number, encode_number
from protocols.modbus.view import ExceptionCode, Kind

MARKER_BITS_AT = 10_000  # coil and discrete input of M0.0
STATES_AT = 1000  # input register with the ioStatus of the first point
FAILED = ExceptionCode.SERVER_DEVICE_FAILURE


@dataclass(slots=True)
class Image:
    """What a command source has of the image: RC inputs it may write where it owns them, RC outputs."""

    inputs: InputImage
    owned: Collection[int]
    written: Callable[[Collection[int]], None]
    outputs: bytes = bytes(RC_BYTES)  # replaced completely at every tick


class ReisView:
    """Coils and holding registers: binary inputs E0.0..E39.7; discrete inputs and input registers: outputs A0.0..A39.7; from register 3000
    and from bit 10000 on markers M0..M2047, in both."""

    def __init__(self, image: Image, first_byte: int = FIRST_BYTE, registers: Registers | None = None) -> None:
        self.image = image
        self.flags: Flags | None = None  # markers, once the control is there
        self._first, self._registers = first_byte, registers

    def read_bits(self, kind: Kind, address: int, count: int) -> Sequence[bool] | ExceptionCode:
        """Inputs and outputs as the circuit diagram numbers them, bit 8 x byte + bit; markers the same from 10000 on."""
        if address >= MARKER_BITS_AT:
            data, first = self._markers(), address - MARKER_BITS_AT
        else:
            data, first = self._bytes(holding=kind is Kind.COILS), address
        return MISSING if first + count > 8 * len(data) else [get_bit(data, n) for n in range(first, first + count)]

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        """20 words, and the markers'."""
        if self._registers is not None and address in self._registers:
            return self._registers.read(address, count)
        if address >= FLAGS_AT:
            data, first = self._markers(), address - FLAGS_AT
        else:
            data, first = self._bytes(holding=kind is Kind.HOLDING_REGISTERS), address
        if 2 * (first + count) > len(data):
            return MISSING
        return [data[2 * r] << 8 | data[2 * r + 1] for r in range(first, first + count)]

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        """Inputs in bytes this command source owns, or markers of the PLC; all or nothing."""
        if address >= MARKER_BITS_AT:
            first, markers = address - MARKER_BITS_AT, bytearray(self._markers())
            if first + len(values) > 8 * len(markers):
                return MISSING
            for n, value in enumerate(values, first):
                set_bit(markers, n, bool(value))
            return self._write_markers(first >> 3, bytes(markers[first >> 3 : (first + len(values) + 7) >> 3]))
        touched = {self._first + (n >> 3) for n in range(address, address + len(values))}
        if address + len(values) > 8 * BYTES or not touched <= set(self.image.owned):
            return MISSING
        for n, value in enumerate(values, address + 8 * self._first):
            set_bit(self.image.inputs.values, n, bool(value))
        self.image.written(touched)
        return None

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        """The same in words."""
        data = b"".join(value.to_bytes(2, "big") for value in values)
        if address >= FLAGS_AT:
            return self._write_markers(2 * (address - FLAGS_AT), data)
        first = self._first + 2 * address
        touched = set(range(first, first + len(data)))
        if 2 * address + len(data) > BYTES or not touched <= set(self.image.owned):
            return MISSING
        self.image.inputs.values[first : first + len(data)] = data
        self.image.written(touched)
        return None

    def _bytes(self, *, holding: bool) -> bytes:
        data = self.image.inputs.values if holding else self.image.outputs
        return bytes(data[self._first : self._first + BYTES])

    def _markers(self) -> bytes:
        return self.flags.flag_bytes()[:SIZE] if self.flags is not None else b""

    def _write_markers(self, first: int, data: bytes) -> ExceptionCode | None:
        return None if self.flags is not None and self.flags.write_flags(first, data) else MISSING


class Val3View:
    """The points of the cell in their order, each kind counted separately.

    Coil n is digital input n, discrete input n digital output n, holding 2n analog input n and input register 2n analog output n as REAL in
    its unit; input register 1000+k the ioStatus of point k of all.
    """

    def __init__(self, image: Image, points: Sequence[Point], order: str = "ABCD", registers: Registers | None = None) -> None:
        self.image = image
        self.control: Val3Control | None = None
        self._order, self._registers, self._all = order, registers, tuple(points)
        self.digital_in = [point for point in points if not point.output and not point.steps]
        self.digital_out = [point for point in points if point.output and not point.steps]
        self.analog_in = [point for point in points if not point.output and point.steps]
        self.analog_out = [point for point in points if point.output and point.steps]

    def read_bits(self, kind: Kind, address: int, count: int) -> Sequence[bool] | ExceptionCode:
        """What the program sees: locked and simulated points too; 04 where the board is in fault."""
        points = self.digital_in if kind is Kind.COILS else self.digital_out
        if address + count > len(points):
            return MISSING
        values = self._values(points[address : address + count], "dio")
        return FAILED if values is None else [bool(value) for value in values]

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        """Analog values, two words each; states."""
        if self._registers is not None and address in self._registers:
            return self._registers.read(address, count)
        if kind is Kind.INPUT_REGISTERS and address >= STATES_AT:
            first = address - STATES_AT
            if first + count > len(self._all) or self.control is None:
                return MISSING
            states = [self.control.system.status(point.name) for point in self._all[first : first + count]]
            return [int(state) & 0xFFFF for state in states]
        points = self.analog_in if kind is Kind.HOLDING_REGISTERS else self.analog_out
        if address + count > 2 * len(points):
            return MISSING
        first, last = address // 2, (address + count + 1) // 2
        values = self._values(points[first:last], "aio")
        if values is None:
            return FAILED
        words = [word for value in values for word in encode_number(value, "REAL", self._order)]
        return words[address - 2 * first : address - 2 * first + count]

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        """Digital inputs in bytes this command source owns; all or nothing."""
        points = self.digital_in[address : address + len(values)]
        touched = {point.bit >> 3 for point in points}
        if len(points) < len(values) or not touched <= set(self.image.owned):
            return MISSING
        for point, value in zip(points, values, strict=True):
            set_bit(self.image.inputs.values, point.bit, bool(value))
        self.image.written(touched)
        return None

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        """Write analog inputs, complete values only: half a REAL is refused; one out of its range is 03 and nothing is written."""
        points = self.analog_in[address // 2 : (address + len(values)) // 2]
        touched = {byte for point in points for byte in (point.byte, point.byte + 1)}
        if address % 2 or len(values) != 2 * len(points) or not touched <= set(self.image.owned):
            return MISSING
        numbers = [decode_number(values[2 * n : 2 * n + 2], "REAL", self._order) for n in range(len(points))]
        if any(not point.low <= number <= point.high for point, number in zip(points, numbers, strict=True)):
            return ExceptionCode.ILLEGAL_DATA_VALUE
        for point, number in zip(points, numbers, strict=True):
            self.image.inputs.values[point.byte : point.byte + 2] = round(number * point.steps).to_bytes(2, "little", signed=True)
        self.image.written(touched)
        return None

    def _values(self, points: Sequence[Point], kind: str) -> list[float] | None:
        control = self.control
        if control is None:
            return None
        try:
            return [control.value(f"{kind}.{point.name}") for point in points]
        except (ValueError, EncodeError):
            return None  # a run-time error of the language: the value is invalid
