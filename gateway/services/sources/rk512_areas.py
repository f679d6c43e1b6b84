"""Areas of RK512 besides data blocks: extended blocks, inputs, outputs, flags, timers and counters, as [line.rk512] types allows.

E holds the inputs of a PLC, the RC outputs; A its outputs, the RC inputs, both at the PLC's own addresses if the cell has a bit coupling; M
holds the flags or markers of the control and the coordination flags that are set; T and Z the control's timers (rest in ms) and counters.
A [[db]] of that kind replaces it; X exists only so (AX-250, AX-339).
"""

from collections.abc import Callable
from typing import Protocol

from gateway.pure.arbitration.block_keys import AREA_BYTES, block_key
from gateway.pure.arbitration.data_blocks import DataBlocks
from gateway.pure.image.records.cell import RC_BYTES
from gateway.services.shared_image import SharedImage
from gateway.services.sources.bit_coupling import CouplingAreas
from protocols.base.machine import Ns
from protocols.rk512.flags import Flags
from protocols.rk512.header import ErrorNumber, Kind


class BlockStore(Protocol):
    """The line as its areas see it."""

    flags: Flags
    data: DataBlocks | None

    def refused(self, kind: str) -> ErrorNumber | None:
        """Why any job to this type is refused."""

    def write_block(self, key: int, word: int, data: bytes, now: Ns) -> ErrorNumber | None:
        """Words into a declared block."""

    def write_inputs(self, first: int, data: bytes) -> ErrorNumber | None:
        """RC input bytes from `first` on."""


class LineAreas:
    """The areas of one line."""

    def __init__(self, line: BlockStore, image: SharedImage, clock: Callable[[], Ns], *, remote: bool) -> None:
        """`remote`: a bit coupling also goes as blocks."""
        self._line, self._image, self._clock = line, image, clock
        self.coupling = CouplingAreas(image, line.write_inputs, remote=remote)

    def read_area(self, kind: Kind, block: int, address: int, amount: int) -> bytes | ErrorNumber:
        """FETCH; types that are not allowed are refused completely."""
        refused = self._line.refused(chr(kind))
        if refused is not None:
            return refused
        data = self.content(chr(kind), block)
        first, last = address * kind.unit, (address + amount) * kind.unit
        return ErrorNumber.BLOCK if data is None or last > len(data) else data[first:last]

    def write_area(self, kind: Kind, block: int, address: int, data: bytes) -> ErrorNumber | None:
        """SEND; dialects have it for extended blocks only, unless they list more."""
        refused = self._line.refused(chr(kind))
        if refused is not None:
            return refused
        if kind is Kind.OUTPUTS and self._declared("A", 0) is None:
            return self._line.write_inputs(address, data) if self.coupling.outputs() is None else self.coupling.write(address, data)
        if kind is Kind.FLAGS and self._declared("M", 0) is None:
            control = self._image.control
            return None if control is not None and control.write_flags(address, data) else ErrorNumber.BLOCK
        if address * kind.unit % 2 or len(data) % 2:
            return ErrorNumber.LENGTH  # a declared block has full words
        return self._line.write_block(block_key(chr(kind), block), address * kind.unit // 2, data, self._clock())

    def content(self, kind: str, number: int) -> bytes | None:
        """Present content of the complete area or block; None without one."""
        declared = self._declared(kind, number)
        control = self._image.control
        if kind == "M":
            flags = control.flag_bytes() if control is not None else b""
            return self._with_flags(declared or flags.ljust(AREA_BYTES, b"\0"))
        if declared is not None or kind not in "EATZ":
            return declared
        if kind in "TZ":
            return None if control is None else _words(control.timer if kind == "T" else control.counter)
        if kind == "A":
            return self.coupling.outputs() or bytes(self._image.inputs.values)
        return self.coupling.inputs() or self._image.outputs.read() or bytes(RC_BYTES)

    def _declared(self, kind: str, number: int) -> bytes | None:
        key, data = block_key(kind, number), self._line.data
        return data.fill(key) if data is not None and key in data.blocks else None

    def _with_flags(self, data: bytes) -> bytes:
        shown = bytearray(data)
        for flag in self._line.flags.set:
            if flag.cpu <= 1 and flag.byte < len(shown):
                shown[flag.byte] |= 1 << flag.bit
        return bytes(shown)


def _words(read: Callable[[int], int | None]) -> bytes | None:
    """Timers or counters 0.. as words; None where there is none."""
    found: list[bytes] = []
    while (value := read(len(found))) is not None:
        found.append(min(value, 0xFFFF).to_bytes(2, "big"))
    return b"".join(found) or None
