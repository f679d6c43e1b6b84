"""The bit coupling of P20 and P21 as a PLC reaches it over a line: E and A as its own addresses, frames in remote blocks.  AX-339.

With [controller] and P20 = 2, 15, 16 or 19 area E holds at I.START the RC outputs the interface has (and the board's inputs behind them),
area A at O.START the RC inputs (and the board's outputs).  With remote = true the same frames go as blocks of at most 48 bytes through
DB 22 (PLC sends) and DB 23 (PLC fetches): one word number x 256 + count, 24 words of data each.
"""

from typing import TYPE_CHECKING

from gateway.pure.arbitration.block_keys import AREA_BYTES
from gateway.pure.controllers.rho3.signals.coupling import REMOTE_MOST, Block, BlockJoiner, Coupling, in_blocks
from protocols.rk512.header import ErrorNumber

if TYPE_CHECKING:
    from gateway.pure.controllers.rho3.signals.control import RhoControl
    from gateway.services.sources.rk512 import Rk512Source

RECEIVED_DB, SENT_DB = 22, 23
BLOCK_BYTES = 2 + REMOTE_MOST


class CouplingAreas:
    """Those of one line; None everywhere where the cell has no bit coupling."""

    def __init__(self, door: "Rk512Source") -> None:
        self._door = door
        self._joiner = BlockJoiner()

    def _there(self) -> "tuple[RhoControl, Coupling] | None":
        rho = self._door.services.signals.rho3
        return None if rho is None or rho.setup.coupling is None else (rho, rho.setup.coupling)

    @property
    def remote(self) -> bool:
        """The frames go as blocks, too."""
        controller = self._door.services.cell.controller
        return controller is not None and controller.remote and self._there() is not None

    def inputs(self) -> bytes | None:
        """Area E as the PLC has it."""
        there = self._there()
        if there is None:
            return None
        rho, coupling = there
        return _placed(coupling.ranges.i_start, coupling.to_plc(rho.image, bytes(rho.board_in)))

    def outputs(self) -> bytes | None:
        """Area A as the PLC has it."""
        there = self._there()
        if there is None:
            return None
        rho, coupling = there
        first = coupling.rc_in_first
        values = bytes(self._door.services.inputs.values[first : first + coupling.rc_in_bytes])
        board = bytes(rho.board_out[: coupling.from_plc_bytes - coupling.rc_in_bytes])
        return _placed(coupling.ranges.o_start, values + board)

    def write(self, address: int, data: bytes) -> ErrorNumber | None:
        """Outputs of the PLC from byte `address` on; all or nothing."""
        there = self._there()
        if there is None:
            return ErrorNumber.BLOCK
        rho, coupling = there
        first = address - coupling.ranges.o_start
        if first < 0 or first + len(data) > coupling.from_plc_bytes:
            return ErrorNumber.BLOCK
        cut = max(0, coupling.rc_in_bytes - first)
        if data[:cut]:
            refused = self._door.write_inputs(coupling.rc_in_first + first, data[:cut])
            if refused is not None:
                return refused
        at = first + len(data[:cut]) - coupling.rc_in_bytes
        if data[cut:]:
            rho.board_out[at : at + len(data[cut:])] = data[cut:]
        return None

    def sent_blocks(self) -> bytes:
        """DB 23: every block of the frame to the PLC, one behind the other."""
        there = self._there()
        if there is None:
            return b""
        rho, coupling = there
        blocks = in_blocks(coupling.to_plc(rho.image, bytes(rho.board_in)))
        return b"".join(bytes((block.number, block.count)) + block.data.ljust(REMOTE_MOST, b"\0") for block in blocks)

    def received(self, data: bytes) -> ErrorNumber | None:
        """DB 22: one block; the frame is taken with its last one, a hole forgets it."""
        there = self._there()
        if there is None or len(data) != BLOCK_BYTES:
            return ErrorNumber.BLOCK
        length = there[1].from_plc_bytes
        number, count = data[0], data[1]
        if count != len(in_blocks(bytes(length))) or number >= count:
            return ErrorNumber.BLOCK
        frame = self._joiner.take(Block(number, count, data[2 : 2 + min(REMOTE_MOST, length - REMOTE_MOST * number)]))
        return None if frame is None else self.write(there[1].ranges.o_start, frame)


def _placed(first: int, frame: bytes) -> bytes:
    return (bytes(first) + frame).ljust(AREA_BYTES, b"\0")[:AREA_BYTES]
