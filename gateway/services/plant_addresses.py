"""Signals and addresses of the plant as values: K01_A_MN_RCI, RC 7.3, E 8.4, MW 10, T 5, DB10.DW2.  A provider of the value directory."""

from collections.abc import Iterable

from gateway.assembly.data_block_signals import signals_of
from gateway.pure.cell.cell import Cell
from gateway.pure.image.addresses import (
    Address,
    AddressFault,
    DataBit,
    DataWord,
    Direction,
    Kind,
    Operand,
    Part,
    RcBit,
    parse_operand,
)
from gateway.pure.image.records.cell import Quality, get_bit
from gateway.services.operands import Operands
from gateway.services.shared_image import SharedImage
from gateway.services.value_directory import Reader, ValueDirectory, as_number
from protocols.base.machine import Ns
from protocols.telegrams.fields import Value


class PlantAddresses:
    """Reads every address of the running cell; writes flags, words of blocks the PLC does not write, RC inputs without an owner."""

    def __init__(self, cell: Cell, image: SharedImage, values: ValueDirectory) -> None:
        self._image, self._values, self.operands = image, values, Operands(cell, image, values)
        self.signals = signals_of(cell)
        self.symbols = self.signals.symbols()

    def names(self) -> Iterable[str]:
        """Addresses are too many for a list."""
        return ()

    def valid(self, name: str) -> bool:
        """An input is valid while its byte is good; everything else always is."""
        place = self._place(name)
        if not isinstance(place, RcBit) or place.direction is not Direction.INPUT:
            return True
        return self._image.inputs.quality[place.number >> 3] == Quality.GOOD

    def read(self, name: str, reader: Reader | None) -> Value:
        match self._place(name):
            case RcBit() as place:
                return self.bit(place)
            case Operand() as place:
                found = self.operands.number(place)
                if found is None:
                    raise KeyError(name)
                return found - (1 << 32) if place.bytes == 4 and found >> 31 else found  # a double word is a DH
            case DataBit() as place:
                return self._values.serving(place.db)[1][2 * place.word + (place.bit < 8)] >> place.bit % 8 & 1
            case DataWord() as place:
                return _number(place, self._values.serving(place.db)[1])
        raise KeyError(name)

    def write(self, name: str, value: Value, now: Ns, by: str) -> None:
        place = self._place(name)
        if not isinstance(place, Operand | RcBit | DataBit | DataWord):
            raise KeyError(name)
        number = as_number(value)
        if number != int(number):
            raise ValueError(f"{name} = {value!r}: a whole number is expected")
        if isinstance(place, Operand):
            if place.kind is not Kind.FLAG:
                raise KeyError(f"{name}: inputs are their command source's, outputs and timers the control's; flags can be written")
            self.operands.write(place, int(number))  # excess bits are cut off, as a PLC's load and transfer does
        elif isinstance(place, RcBit):
            self._write_input(name, place, bool(number), now)
        else:
            self._write_block(name, place, int(number))

    def bit(self, place: RcBit) -> int:
        """RC inputs as they are forced, RC outputs as they are published."""
        if place.direction is Direction.INPUT:
            return int(self._image.input_bit(place.number))
        outputs = self._image.outputs.read()
        return int(outputs is not None and get_bit(outputs, place.number))

    def _place(self, name: str) -> Address | Operand:
        symbol = self.symbols.get(name.upper())
        if symbol is not None:
            return symbol
        try:
            return parse_operand(name)
        except AddressFault as fault:
            raise KeyError(name) from fault

    def _write_input(self, name: str, place: RcBit, value: bool, now: Ns) -> None:
        octet = place.number >> 3
        if place.direction is Direction.OUTPUT or octet in self._image.owners:
            raise KeyError(f"{name}: RC outputs are the control's, and this RC input has a command source that writes it")
        self._image.put_bit(place.number, value)
        self._image.judge((octet,), Quality.GOOD, now)
        self._image.pass_on()

    def _write_block(self, name: str, place: DataBit | DataWord, number: int) -> None:
        block = self._values.data_block(place.db)
        if block is None or block.from_plc:
            raise KeyError(f"{name}: no declared block, or the PLC writes it")
        first, size = 2 * place.word, 4 if isinstance(place, DataWord) and place.part is Part.DOUBLE else 2
        old = bytes(block.data[first : first + size])
        raw = word_bytes(place, int.from_bytes(old[:2], "big"), number)
        if raw is None or len(old) < size:
            raise ValueError(f"{name} = {number}: a DW takes -32768..65535, a DD -2147483648..4294967295, DL and DR 0..255, a bit 0 or 1")
        block.data[first : first + size] = raw


def _number(place: DataWord, data: bytes) -> int:
    raw = data[2 * place.word : 2 * place.word + (4 if place.part is Part.DOUBLE else 2)]
    if len(raw) < 2:
        raise KeyError(str(place))
    match place.part:
        case Part.LEFT:
            return raw[0]
        case Part.RIGHT:
            return raw[1]
    return int.from_bytes(raw, "big", signed=True)


def word_bytes(place: DataWord | DataBit, word: int, number: int) -> bytes | None:
    """The bytes from the place's word on, with `word` as present value; None if the number does not fit."""
    if isinstance(place, DataBit):
        new = word | 1 << place.bit if number else word & ~(1 << place.bit)
        return new.to_bytes(2, "big") if number in (0, 1) else None
    match place.part:
        case Part.WORD:
            return (number & 0xFFFF).to_bytes(2, "big") if -0x8000 <= number <= 0xFFFF else None
        case Part.DOUBLE:
            return (number & 0xFFFFFFFF).to_bytes(4, "big") if -0x8000_0000 <= number <= 0xFFFF_FFFF else None
        case Part.LEFT:
            return bytes((number, word & 0xFF)) if 0 <= number <= 255 else None
        case Part.RIGHT:
            return bytes((word >> 8, number)) if 0 <= number <= 255 else None
