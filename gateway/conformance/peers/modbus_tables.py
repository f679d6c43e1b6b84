"""Modbus: tables of registers and coils with one fault each (used by peers.modbus_rows)."""

from collections.abc import Sequence

from gateway.conformance.peers.modbus_devices import SIZE, Tables
from protocols.modbus.view import ExceptionCode, Kind


class Lost(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return ExceptionCode.ILLEGAL_DATA_ADDRESS if address + len(values) > SIZE else None


class LostCoils(Tables):
    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return ExceptionCode.ILLEGAL_DATA_ADDRESS if address + len(values) > SIZE else None


class Swapped(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, [(value & 0xFF) << 8 | value >> 8 for value in values])


class Reversed(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, list(values)[::-1])


class ReversedCoils(Tables):
    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return super().write_bits(address, list(values)[::-1])


class FirstOnly(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, list(values)[:1])


class FillBits(Tables):
    """Several coils at once: the bits that fill the last byte are written as well."""

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        filled = [*values, *[False] * (-len(values) % 8)] if len(values) > 1 else values
        return super().write_bits(address, filled)


class FirstCoils(Tables):
    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return super().write_bits(address, list(values)[:8])


class CoilsToo(Tables):
    """Registers written together change the coils of their numbers as well."""

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        if len(values) > 1:
            self.write_bits(address, [bool(value & 1) for value in values])
        return super().write_words(address, values)


class RegistersToo(Tables):
    """A coil that is written clears the register of its number."""

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        self.words[Kind.HOLDING_REGISTERS][address : address + len(values)] = [0] * len(values[: SIZE - address])
        return super().write_bits(address, values)


class NextToo(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, [*values, values[-1]])


class NextCoil(Tables):
    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return super().write_bits(address, [*values, values[-1]])


class Shifted(Tables):
    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        return (
            super().read_words(kind, address + 1, count)
            if kind is Kind.HOLDING_REGISTERS and count > 1 and address + count < SIZE
            else super().read_words(kind, address, count)
        )


class Cut(Tables):
    """Register numbers of five bits."""

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        return (
            super().read_words(kind, address & 0x1F, count)
            if count < 33 and kind is Kind.HOLDING_REGISTERS
            else super().read_words(kind, address, count)
        )

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address & 0x1F, values)


class OneRegisterTable(Tables):
    """Input registers are the holding registers."""

    def __init__(self) -> None:
        super().__init__()
        self.words[Kind.INPUT_REGISTERS] = self.words[Kind.HOLDING_REGISTERS]


class WholeBytes(Tables):
    """Several coils are read from the beginning of a byte."""

    def read_bits(self, kind: Kind, address: int, count: int) -> Sequence[bool] | ExceptionCode:
        return super().read_bits(kind, address & ~7 if kind is Kind.COILS and count > 1 else address, count)


class AlignedCoils(Tables):
    """Several coils are written from the beginning of a byte."""

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return super().write_bits(address & ~7 if len(values) > 1 else address, values)


class SignedBytes(Tables):
    """A value of one byte is extended by its top bit."""

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, [value | 0xFF00 if value & 0x80 and value < 0x100 else value for value in values])


class OneBitTable(Tables):
    def __init__(self) -> None:
        super().__init__()
        self.flags[Kind.DISCRETE_INPUTS] = self.flags[Kind.COILS]


class Sticky(Tables):
    """A coil once set stays set."""

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        old = self.flags[Kind.COILS][address : address + len(values)]
        return super().write_bits(address, [value or before for value, before in zip(values, [*old, *[False] * len(values)], strict=False)])


class SevenBits(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, [value & 0x7FFF for value in values])


class ReadsBeyond(Tables):
    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        found = super().read_words(kind, address, count)
        return ExceptionCode.SERVER_DEVICE_FAILURE if isinstance(found, ExceptionCode) else found


class EveryTenth(Tables):
    _count = 0

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        self._count += 1
        return None if self._count % 25 == 0 else super().write_words(address, values)


class Nowhere(Tables):
    """Writes to registers and coils that are not there are acknowledged."""

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, values) if address < SIZE else None

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return super().write_bits(address, values) if address < SIZE else None


class LowByte(Tables):
    """The high byte of an address to be written does not count."""

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address & 0xFF, values)

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return super().write_bits(address & 0xFF, values)


class ReadsLowByte(LowByte):
    """The high byte of an address does not count at all."""

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        return super().read_words(kind, address & 0xFF, count)


class AsFarAsThereIs(Tables):
    """A range beyond the end is written up to the end, and refused."""

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        super().write_words(address, list(values)[: max(0, SIZE - address)])
        return super().write_words(address, values)


class AsFarAsCoilsGo(Tables):
    """The same for coils."""

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        super().write_bits(address, list(values)[: max(0, SIZE - address)])
        return super().write_bits(address, values)


class Most(Tables):
    """Ninety registers at most in one request; the rest is lost."""

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        refused = super().write_words(address, values) if address + len(values) > SIZE else None
        return refused or super().write_words(address, list(values)[:90])


class ReadOnly(Tables):
    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return ExceptionCode.ILLEGAL_DATA_ADDRESS

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        return ExceptionCode.ILLEGAL_DATA_ADDRESS


class EvenCounts(Tables):
    """Of three registers and more an even number is written."""

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        return super().write_words(address, values[: len(values) // 2 * 2] if len(values) > 2 else values)


class WithoutCarry(Tables):
    """300 registers; a read that crosses 256 continues at 0."""

    def __init__(self) -> None:
        super().__init__()
        self.words = {kind: [(values[0] + 5 * at) & 0xFFFF for at in range(300)] for kind, values in self.words.items()}

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        if address + count > 300:
            return ExceptionCode.ILLEGAL_DATA_ADDRESS
        return [self.words[kind][address & 0xFF00 | (address + at) & 0xFF] for at in range(count)]
