"""Inputs of [[measuring]] whose wire ends in the cycle: the core has their level in the cycle that receives it (AX-481).  Pure.

The services bring the same bit by their route or contact one or two cycles later; they judge its byte as before, and the level received by
the cycle itself overrides it as long as the module reports it valid.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from gateway.pure.image.records.cell import InputImage, set_bit
from protocols.base.machine import Ns


class InputLevel(NamedTuple):
    """State of one input reported by a module, and the bus stamp of the frame that brought its last change."""

    level: bool
    stamp_ns: Ns


@dataclass(frozen=True, slots=True)
class Wire:
    """RC input `number`; hear: None while the module is invalid."""

    number: int
    inverted: bool
    hear: Callable[[], InputLevel | None]


class FastWires:
    """Of one cycle."""

    def __init__(self, wires: Sequence[Wire]) -> None:
        self._wires = tuple(wires)
        self._seen: tuple[InputImage, list[InputLevel | None]] | None = None  # what the image below was made of
        self._over = InputImage()

    @property
    def numbers(self) -> frozenset[int]:
        """RC inputs received here."""
        return frozenset(wire.number for wire in self._wires)

    def over(self, image: InputImage) -> InputImage:
        """RC inputs as the services have them, with the levels received here; a copy that is made only when something has changed."""
        heard = [wire.hear() for wire in self._wires]
        if self._seen is None or self._seen[0] is not image or self._seen[1] != heard:
            self._seen, self._over = (image, heard), self._made(image, heard)
        return self._over

    def _made(self, image: InputImage, heard: Sequence[InputLevel | None]) -> InputImage:
        made = InputImage(bytearray(image.values), bytearray(image.quality), list(image.stamps))
        for wire, said in zip(self._wires, heard, strict=True):
            if said is not None:
                set_bit(made.values, wire.number, said.level is not wire.inverted)
                made.stamps[wire.number >> 3] = said.stamp_ns
        return made
