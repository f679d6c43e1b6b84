"""The PIC image: 1024 inputs, outputs and flags as bytes.  Source: rho3 0.2, 3.8 (L9292-9311).

Bit N of a kind is byte N div 8, bit N mod 8.  RC inputs are the PIC's outputs (O), RC outputs are the PIC's inputs (I).
"""

from dataclasses import dataclass, field

from gateway.pure.records import RC_BYTES, get_bit, set_bit


@dataclass(slots=True)
class PicImage:
    """What PLC and control tell each other: `inputs` PLC -> RC, `outputs` RC -> PLC, `flags` of the PIC alone."""

    inputs: bytearray = field(default_factory=lambda: bytearray(RC_BYTES))
    outputs: bytearray = field(default_factory=lambda: bytearray(RC_BYTES))
    flags: bytearray = field(default_factory=lambda: bytearray(RC_BYTES))

    def input(self, number: int) -> bool:
        """RC input N."""
        return get_bit(self.inputs, number)

    def output(self, number: int) -> bool:
        """RC output N."""
        return get_bit(self.outputs, number)

    def put(self, number: int, value: bool) -> None:
        """RC output N becomes `value`."""
        set_bit(self.outputs, number, value)

    def clear(self) -> None:
        """All RC inputs and outputs 0; the flags stay."""
        self.inputs[:] = bytes(len(self.inputs))
        self.outputs[:] = bytes(len(self.outputs))


class Edge:
    """Rising edges of one bit; what stands at the first look is no edge (AX-510)."""

    def __init__(self) -> None:
        self._before = True

    def rises(self, value: bool) -> bool:
        """True once when `value` has become True."""
        rising, self._before = value and not self._before, value
        return rising
