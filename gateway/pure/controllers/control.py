"""A control of [controller] as the services see it, whatever its kind."""

from collections.abc import Mapping
from typing import Protocol

from gateway.pure.image.records.cell import CellState, InputImage
from protocols.base.machine import Ns


class Control(Protocol):
    """What the services know of a control; the three kinds of [controller] have it."""

    @property
    def outputs(self) -> bytes:
        """RC outputs, the cycle's and its own."""

    def step(self, inputs: InputImage, cycle: bytes, state: CellState, now: Ns, *, heard: bool = False) -> list[str]:
        """Once per cycle of the services; what a person should read."""

    def flag_bytes(self) -> bytes:
        """Flags or markers."""

    def write_flags(self, first: int, data: bytes) -> bool:
        """From byte `first` on; False: not there, or not the PLC's."""

    def retained(self) -> bytes:
        """Flags or markers worth keeping over power-off."""

    def restore(self, flags: bytes, counters: Mapping[int, int]) -> None:
        """What was kept, before the first step; b"": nothing was."""

    def timer(self, number: int) -> int | None:
        """Rest in ms; None: none of that number."""

    def counter(self, number: int) -> int | None:
        """None: none of that number."""

    def names(self) -> list[str]:
        """Return the values other than signals and flags."""

    def value(self, name: str) -> float:
        """KeyError: no such name; ValueError: it has no value."""

    def put(self, name: str, value: float) -> None:
        """KeyError: not written; ValueError: the value does not fit."""

    def status(self) -> dict[str, object]:
        """For tools and pages."""
