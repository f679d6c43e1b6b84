"""The bit coupling of P20 and P21 as a PLC reaches it over a line: E and A as its own addresses, frames in remote blocks.  AX-339.

With [controller] and P20 = 2, 15, 16 or 19 area E holds at I.START the RC outputs the interface has (followed by the board's inputs),
area A at O.START the RC inputs (and the board's outputs).  With remote = true the same frames go as blocks of at most 48 bytes through
DB 22 (PLC sends) and DB 23 (PLC fetches): one word number x 256 + count, 24 words of data each.
"""

from collections.abc import Callable

from gateway.pure.arbitration.block_keys import AREA_BYTES
from gateway.pure.controllers.rho3.signals.coupling import REMOTE_MOST, Block, BlockJoiner, in_blocks
from gateway.services.shared_image import SharedImage
from protocols.rk512.header import ErrorNumber

RECEIVED_DB, SENT_DB = 22, 23
BLOCK_BYTES = 2 + REMOTE_MOST


class CouplingAreas:
    """Those of one line; None everywhere where the cell has no bit coupling."""

    def __init__(self, image: SharedImage, write_inputs: Callable[[int, bytes], ErrorNumber | None], *, remote: bool) -> None:
        """`write_inputs`: RC input bytes in the name of the line, from a byte on; `remote`: the frames go as blocks, too."""
        self._image, self._write_inputs, self._remote = image, write_inputs, remote
        self._joiner = BlockJoiner()

    @property
    def remote(self) -> bool:
        """The frames go as blocks, too."""
        return self._remote and self._image.coupled is not None

    def inputs(self) -> bytes | None:
        """Area E as the PLC has it."""
        rho = self._image.coupled
        return None if rho is None else _placed(rho.coupling.ranges.i_start, rho.coupling.to_plc(rho.image, bytes(rho.board_in)))

    def outputs(self) -> bytes | None:
        """Area A as the PLC has it."""
        rho = self._image.coupled
        if rho is None:
            return None
        coupling = rho.coupling
        first = coupling.rc_in_first
        values = bytes(self._image.inputs.values[first : first + coupling.rc_in_bytes])
        board = bytes(rho.board_out[: coupling.from_plc_bytes - coupling.rc_in_bytes])
        return _placed(coupling.ranges.o_start, values + board)

    def write(self, address: int, data: bytes) -> ErrorNumber | None:
        """Outputs of the PLC from byte `address` on; all or nothing."""
        rho = self._image.coupled
        if rho is None:
            return ErrorNumber.BLOCK
        coupling = rho.coupling
        first = address - coupling.ranges.o_start
        if first < 0 or first + len(data) > coupling.from_plc_bytes:
            return ErrorNumber.BLOCK
        cut = max(0, coupling.rc_in_bytes - first)
        if data[:cut]:
            refused = self._write_inputs(coupling.rc_in_first + first, data[:cut])
            if refused is not None:
                return refused
        at = first + len(data[:cut]) - coupling.rc_in_bytes
        if data[cut:]:
            rho.board_out[at : at + len(data[cut:])] = data[cut:]
        return None

    def sent_blocks(self) -> bytes:
        """DB 23: send every block of the frame to the PLC, one at a time."""
        rho = self._image.coupled
        if rho is None:
            return b""
        blocks = in_blocks(rho.coupling.to_plc(rho.image, bytes(rho.board_in)))
        return b"".join(bytes((block.number, block.count)) + block.data.ljust(REMOTE_MOST, b"\0") for block in blocks)

    def received(self, data: bytes) -> ErrorNumber | None:
        """DB 22: one block; the frame is accepted with its last one, a gap discards it."""
        rho = self._image.coupled
        if rho is None or len(data) != BLOCK_BYTES:
            return ErrorNumber.BLOCK
        length = rho.coupling.from_plc_bytes
        number, count = data[0], data[1]
        if count != len(in_blocks(bytes(length))) or number >= count:
            return ErrorNumber.BLOCK
        frame = self._joiner.take(Block(number, count, data[2 : 2 + min(REMOTE_MOST, length - REMOTE_MOST * number)]))
        return None if frame is None else self.write(rho.coupling.ranges.o_start, frame)


def _placed(first: int, frame: bytes) -> bytes:
    return (bytes(first) + frame).ljust(AREA_BYTES, b"\0")[:AREA_BYTES]
