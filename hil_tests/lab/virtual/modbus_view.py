"""A view over plain lists: the simplest thing a Modbus server can be answered from, for tests and benches."""

from collections.abc import Sequence

from protocols.modbus.view import ExceptionCode, Kind


class MemoryView:
    """Four tables of the same size from address `first` on; every call is counted, `fails` answers all of them with one code."""

    def __init__(self, size: int = 200, first: int = 0) -> None:
        self._first = first
        self.bits: dict[Kind, list[bool]] = {kind: [False] * size for kind in (Kind.COILS, Kind.DISCRETE_INPUTS)}
        self.words: dict[Kind, list[int]] = {kind: [0] * size for kind in (Kind.HOLDING_REGISTERS, Kind.INPUT_REGISTERS)}
        self.calls = 0
        self.fails: ExceptionCode | None = None

    def read_bits(self, kind: Kind, address: int, count: int) -> Sequence[bool] | ExceptionCode:
        table = self.bits[kind]
        return self._refusal(len(table), address, count) or table[address - self._first : address - self._first + count]

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        table = self.words[kind]
        return self._refusal(len(table), address, count) or table[address - self._first : address - self._first + count]

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        table, start = self.bits[Kind.COILS], address - self._first
        why = self._refusal(len(table), address, len(values))
        if why is None:
            table[start : start + len(values)] = values
        return why

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        table, start = self.words[Kind.HOLDING_REGISTERS], address - self._first
        why = self._refusal(len(table), address, len(values))
        if why is None:
            table[start : start + len(values)] = values
        return why

    def _refusal(self, size: int, address: int, count: int) -> ExceptionCode | None:
        self.calls += 1
        if self.fails is not None:
            return self.fails
        inside = self._first <= address and address + count <= self._first + size
        return None if inside else ExceptionCode.ILLEGAL_DATA_ADDRESS
