"""Interface of a Reis control for the robot programs that run in it.  Pure."""

from typing import Protocol

from gateway.pure.image.records.cell import CellState
from protocols.base.machine import Ns


class ReisSide(Protocol):
    """The control as its programs see it."""

    @property
    def cell(self) -> CellState:
        """As the cycle published it last."""

    @property
    def automatic(self) -> bool:
        """RC input 23."""

    def marker(self, byte: int, bit: int) -> bool:
        """M byte.bit."""

    def flag_bytes(self) -> bytes:
        """M0..M2047."""

    def robot_writes(self, first: int, data: bytes) -> str:
        """Markers and outputs as the robot program writes them; why it may not, or ""."""

    def robot_sets(self, byte: int, mask: int, bits: int) -> str:
        """The same for single bits of a byte."""

    def message(self, number: int, words: str, now: Ns) -> None:
        """An error of the robot program."""

    def acknowledged(self) -> None:
        """It is acknowledged."""
