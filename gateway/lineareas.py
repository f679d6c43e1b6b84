"""What RK512 serves beside data blocks: extended blocks, inputs, outputs, flags, timers and counters, as [line.rk512] types allows.

E is what a PLC reads as its inputs, the RC outputs; A what it writes as its outputs, the RC inputs; M holds the coordination flags that are
set.  A [[db]] with that kind stands in the place of it; X, T and Z exist only so (AX-250).
"""

import time
from typing import TYPE_CHECKING

from gateway.pure.line_blocks import AREA_BYTES, block_key
from gateway.pure.records import RC_BYTES
from protocols.rk512.header import ErrorNumber, Kind

if TYPE_CHECKING:
    from gateway.linedoor import LineDoor


class LineAreas:
    """The areas of one line."""

    def __init__(self, door: "LineDoor") -> None:
        self._door = door

    def read_area(self, kind: Kind, block: int, address: int, amount: int) -> bytes | ErrorNumber:
        """FETCH; what the types leave out is refused whole."""
        refused = self._door.refused(chr(kind))
        if refused is not None:
            return refused
        data = self.content(chr(kind), block)
        first, last = address * kind.unit, (address + amount) * kind.unit
        return ErrorNumber.BLOCK if data is None or last > len(data) else data[first:last]

    def write_area(self, kind: Kind, block: int, address: int, data: bytes) -> ErrorNumber | None:
        """SEND; dialects have it for extended blocks only, unless they list more."""
        refused = self._door.refused(chr(kind))
        if refused is not None:
            return refused
        if kind is Kind.OUTPUTS and self._declared("A", 0) is None:
            return self._door.write_inputs(address, data)
        if address * kind.unit % 2 or len(data) % 2:
            return ErrorNumber.LENGTH  # a declared block is whole words
        return self._door.write_block(block_key(chr(kind), block), address * kind.unit // 2, data, time.monotonic_ns())

    def content(self, kind: str, number: int) -> bytes | None:
        """The whole area or block as it stands; None where there is none."""
        declared = self._declared(kind, number)
        if kind == "M":
            return self._with_flags(declared or bytes(AREA_BYTES))
        if declared is not None or kind not in "EA":
            return declared
        services = self._door.services
        return bytes(services.inputs.values) if kind == "A" else services.rc_out.read() or bytes(RC_BYTES)

    def _declared(self, kind: str, number: int) -> bytes | None:
        key, data = block_key(kind, number), self._door.data
        return data.fill(key) if data is not None and key in data.blocks else None

    def _with_flags(self, data: bytes) -> bytes:
        shown = bytearray(data)
        for flag in self._door.flags.set:
            if flag.cpu <= 1 and flag.byte < len(shown):
                shown[flag.byte] |= 1 << flag.bit
        return bytes(shown)
