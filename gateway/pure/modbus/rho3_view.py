"""The rho3 view of a Modbus unit (AX-012): coil N = RC input bit N, discrete input N = RC output bit N, holding 0-63 RC inputs,
input registers 0-63 RC outputs, holding 1000.. command block, input 1000.. status block.  Protocol addresses, base 0.  Beside it:
exception status (FC 7) = RC outputs 64..71, files (FC 20, 21) = the data blocks, file N is DB N, queue at 2000 (FC 24) = numbers of the
active errors, first one first (AX-342); registers of the cell file (AX-347); holding 3000.. flags or markers where the cell has a
control, word r = bytes 2r (high), 2r+1 (AX-339).

Word r = bytes 2r (high), 2r+1 (low), the same as RK512 data words (AX-010).
"""

import struct
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Protocol

from gateway.pure.arbitration.command_block import COMMAND_WORDS, STATUS_WORDS
from gateway.pure.image.records.cell import RC_BYTES, InputImage, get_bit, set_bit
from gateway.pure.modbus.registers import Registers
from protocols.modbus.view import ExceptionCode, Kind

BLOCK_AT = 1000
RC_WORDS = RC_BYTES // 2
WORDS = tuple(struct.Struct(f">{count}H") for count in range(RC_WORDS + 1))
STATUS_BYTE = 8  # RC outputs 64..71: ready, ready2, drives on, emergency stop latched (AX-002)
ERRORS_AT, MOST_ERRORS = 2000, 31
FLAGS_AT = 3000
MISSING = ExceptionCode.ILLEGAL_DATA_ADDRESS


class Flags(Protocol):
    """Flags or markers of the control a cell has."""

    def flag_bytes(self) -> bytes:
        """From M 0 on."""

    def write_flags(self, first: int, data: bytes) -> bool:
        """From byte `first` on; False: not there, or not the PLC's."""


@dataclass(frozen=True, slots=True)
class BlockFiles:
    """Data blocks as file records: read(number) returns the present block (None: there is none); `written`: those that this command source
    writes, by write(number, word, bytes)."""

    read: Callable[[int], bytes | None] = lambda number: None
    written: Collection[int] = ()
    write: Callable[[int, int, bytes], None] = lambda number, word, data: None


NO_BLOCKS = BlockFiles()


class RhoView:
    """One command source's view; what others own can be read here and not be written."""

    def __init__(
        self,
        inputs: InputImage,
        owned: Collection[int],
        written: Callable[[Collection[int]], None],
        command: Callable[[int, Sequence[int]], None] | None,
        registers: Registers | None = None,
        errors: Callable[[], Sequence[int]] = tuple,
        blocks: BlockFiles = NO_BLOCKS,
    ) -> None:
        """`owned`: RC input bytes this command source may write; `written` is passed which it wrote; `command` receives command words
        (first, values); `errors`: numbers of the errors that are set; `blocks`: data blocks as file records.
        """
        self.outputs: bytes = bytes(RC_BYTES)  # RC outputs; replaced completely at every tick
        self.status: Sequence[int] = [0] * STATUS_WORDS
        self.command_words: Sequence[int] = [0] * COMMAND_WORDS
        self.flags: Flags | None = None  # of the control, where there is one
        self._inputs, self._owned, self._written, self._command = inputs, frozenset(owned), written, command
        self._registers, self._block, self._errors = registers, blocks.read, errors
        self._files, self._write_block = frozenset(blocks.written), blocks.write

    def read_bits(self, kind: Kind, address: int, count: int) -> Sequence[bool] | ExceptionCode:
        """Coils: RC inputs; discrete inputs: RC outputs."""
        if address + count > 8 * RC_BYTES:
            return MISSING
        image = self._inputs.values if kind is Kind.COILS else self.outputs
        return [get_bit(image, n) for n in range(address, address + count)]

    def read_words(self, kind: Kind, address: int, count: int) -> Sequence[int] | ExceptionCode:
        """Holding: RC inputs and command block; input: RC outputs and status block."""
        if self._registers is not None and address in self._registers:
            return self._registers.read(address, count)
        holding = kind is Kind.HOLDING_REGISTERS
        if holding and address >= FLAGS_AT and self.flags is not None:
            flags, first = self.flags.flag_bytes(), address - FLAGS_AT
            if 2 * (first + count) > len(flags):
                return MISSING
            return [flags[2 * r] << 8 | flags[2 * r + 1] for r in range(first, first + count)]
        if address >= BLOCK_AT and self._command is not None:
            block = self.command_words if holding else self.status
            first = address - BLOCK_AT
            return block[first : first + count] if first + count <= len(block) else MISSING
        if address + count > RC_WORDS:
            return MISSING
        image = self._inputs.values if holding else self.outputs
        return WORDS[count].unpack_from(image, 2 * address)

    def write_bits(self, address: int, values: Sequence[bool]) -> ExceptionCode | None:
        """RC inputs, only in bytes this command source owns; all or nothing."""
        touched = {n >> 3 for n in range(address, address + len(values))}
        if address + len(values) > 8 * RC_BYTES or not touched <= self._owned:
            return MISSING
        for n, value in enumerate(values):
            set_bit(self._inputs.values, address + n, bool(value))
        self._written(touched)
        return None

    def write_words(self, address: int, values: Sequence[int]) -> ExceptionCode | None:
        """RC inputs this command source owns, the command block, or flags."""
        if address >= FLAGS_AT and self.flags is not None:
            data = b"".join(value.to_bytes(2, "big") for value in values)
            return None if self.flags.write_flags(2 * (address - FLAGS_AT), data) else MISSING
        if address >= BLOCK_AT and self._command is not None:
            if address - BLOCK_AT + len(values) > COMMAND_WORDS:
                return MISSING
            self._command(address - BLOCK_AT, values)
            return None
        touched = {byte for r in range(address, address + len(values)) for byte in (2 * r, 2 * r + 1)}
        if address + len(values) > RC_WORDS or not touched <= self._owned:
            return MISSING
        for r, value in enumerate(values, address):
            self._inputs.values[2 * r : 2 * r + 2] = value.to_bytes(2, "big")
        self._written(touched)
        return None

    # ---- outside the tables
    def exception_status(self) -> int:
        """RC outputs 64..71."""
        return self.outputs[STATUS_BYTE]

    def read_record(self, file: int, record: int, count: int) -> Sequence[int] | ExceptionCode:
        """Words of data block `file`, high byte first."""
        data = self._block(file)
        if data is None or 2 * (record + count) > len(data):
            return MISSING
        return [data[2 * r] << 8 | data[2 * r + 1] for r in range(record, record + count)]

    def refuses_record(self, file: int, record: int, count: int) -> ExceptionCode | None:
        """A block has one writer: this command source where the cell names it, else the partner on its line or axisgate (AX-479)."""
        found = self.read_record(file, record, count) if file in self._files else MISSING
        return found if isinstance(found, ExceptionCode) else None

    def write_record(self, file: int, record: int, values: Sequence[int]) -> ExceptionCode | None:
        """Write words of a block."""
        self._write_block(file, record, b"".join(value.to_bytes(2, "big") for value in values))
        return None

    def read_queue(self, address: int) -> Sequence[int] | ExceptionCode:
        """Return the standing errors; reading removes none."""
        return [number & 0xFFFF for number in self._errors()][:MOST_ERRORS] if address == ERRORS_AT else MISSING
