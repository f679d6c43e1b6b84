"""Listen-only bus: nothing is ever sent on it, and nothing received on it counts as the answer of a drive (AX-436)."""

from collections.abc import Sequence

from drivers.drives.family import Heard, SetRecord
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, Ns


class ListeningFamily:
    """Listen only: nothing is known about the axes, so the core sees drives that do not answer."""

    def __init__(self) -> None:
        self.aside: list[Frame] = []

    @property
    def expected(self) -> int:
        """Sends no request."""
        return 0

    @property
    def unconfigured(self) -> int:
        """Starts no node."""
        return 0

    def burst(self, values: Sequence[SetRecord]) -> list[Frame]:
        """Nothing."""
        return []

    def hear(self, frame: Frame) -> Heard | None:
        """No frame is known: its layout is not confirmed."""
        raise DecodeError(f"identifier {frame.identifier}: this bus is only listened to")

    def release(self, node: int, mode: int) -> None:
        """Starts no node."""

    def hold(self, node: int) -> None:
        """Starts no node."""

    def began(self, now: Ns) -> None:
        """Nothing depends on it here."""
