"""The PIC image: 1024 inputs, outputs and flags as bytes.  Source: rho3 0.2, 3.8 (L9292-9311).

Bit N of a kind is byte N div 8, bit N mod 8.  RC inputs are the PIC's outputs (O), RC outputs are the PIC's inputs (I).
"""

from dataclasses import dataclass, field

from gateway.pure.image.records.cell import RC_BYTES, InputImage, Quality, get_bit, set_bit


@dataclass(slots=True)
class PicImage:
    """Signals between PLC and control: `inputs` PLC -> RC, `outputs` RC -> PLC, `flags` of the PIC alone."""

    inputs: bytearray = field(default_factory=lambda: bytearray(RC_BYTES))
    outputs: bytearray = field(default_factory=lambda: bytearray(RC_BYTES))
    flags: bytearray = field(default_factory=lambda: bytearray(RC_BYTES))
    good: bytearray = field(default_factory=lambda: bytearray(b"\1" * RC_BYTES))  # input bytes that come from a living command source
    _quality: bytearray = field(default_factory=bytearray)  # of each byte when `good` was made
    _bad: tuple[int, ...] = ()

    def take(self, sources: InputImage) -> None:
        """The inputs as the command sources have them: an invalid byte is 0, a stale one stays and has no edges."""
        if sources.quality != self._quality:
            self._quality[:] = sources.quality
            self.good[:] = (quality == Quality.GOOD for quality in sources.quality)
            self._bad = tuple(byte for byte, quality in enumerate(sources.quality) if quality == Quality.BAD)
        self.inputs[:] = sources.values
        for byte in self._bad:
            self.inputs[byte] = 0

    def trusted(self, number: int) -> bool:
        """Whether RC input N comes from a living command source."""
        return bool(self.good[number >> 3])

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
    """Rising edges of one RC input; its level at the first look or when its command source comes back is not an edge (AX-510)."""

    def __init__(self, number: int) -> None:
        self._number, self._before = number, True

    def rises(self, image: PicImage) -> bool:
        """True once when the input has become 1."""
        value = image.input(self._number)
        good = image.trusted(self._number)
        rising, self._before = good and value and not self._before, value or not good
        return rising
