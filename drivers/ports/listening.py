"""Ports that only listen: an attempt to send is a programming error, and nothing is sent."""

from collections.abc import Sequence

from drivers.ports.base import BytePort, CanPort
from protocols.base.machine import Damage, Frame, FrameFault, Ns


class Silence(RuntimeError):
    """An attempt to send where only listening is allowed."""


class ListeningCan:
    """A CanPort around another; it never sends."""

    def __init__(self, port: CanPort) -> None:
        self.name, self._port = port.name, port

    def fileno(self) -> int:
        return self._port.fileno()

    def send(self, frames: Sequence[Frame]) -> int:
        """Raises Silence."""
        raise Silence(f"{self.name}: {len(frames)} frames were to be sent on a port that only listens")

    def receive(self) -> list[Frame]:
        return self._port.receive()

    def receive_next(self) -> list[Frame]:
        """As the port under it."""
        return self._port.receive_next()

    def take_faults(self) -> list[tuple[FrameFault, Ns]]:
        return self._port.take_faults()

    def close(self) -> None:
        self._port.close()


class ListeningBytes:
    """A BytePort around another; it never writes."""

    def __init__(self, port: BytePort) -> None:
        self.name, self.char_ns, self._port = port.name, port.char_ns, port

    def fileno(self) -> int:
        return self._port.fileno()

    def read(self) -> list[bytes | Damage]:
        return self._port.read()

    def write(self, data: bytes) -> int:
        """Raises Silence."""
        raise Silence(f"{self.name}: {len(data)} characters were to be written to a port that only listens")

    def unsent(self) -> int:
        return 0

    def close(self) -> None:
        self._port.close()
