"""A CANopen bus without a cycle: commissioning tools use it through the same link as the services use the ring."""

import select
import threading

from drivers.ports.base import CanPort
from protocols.base.machine import Frame


class DirectLink:
    """One CAN port as a link (drivers.ports.can.cycle_bus.CycleLink); the nodes that the master releases are kept for the SYNC producer."""

    def __init__(self, port: CanPort) -> None:
        self.port = port
        self.released: dict[int, int] = {}  # node -> mode
        self.cyclic: list[Frame] = []  # TPDOs, for other readers; the master ignores them
        self._lock = threading.Lock()

    def send(self, identifier: int, data: bytes) -> bool:
        """False: the port did not accept it."""
        with self._lock:
            return self.port.send([Frame(identifier, data)]) == 1

    def burst(self, frames: list[Frame]) -> None:
        """SYNC, RPDOs and the heartbeat of a tool that plays the cycle for a moment."""
        with self._lock:
            self.port.send(frames)

    def receive(self) -> list[Frame]:
        """Acyclic frames; cyclic data is kept separately."""
        if not select.select([self.port], (), (), 0)[0]:
            return []
        with self._lock:
            frames = self.port.receive()
        aside: list[Frame] = []
        for frame in frames:
            cyclic = 0x180 <= frame.identifier < 0x580
            (self.cyclic if cyclic else aside).append(frame)
        del self.cyclic[:-4096]
        return aside

    def left_out(self, identifier: int) -> int:
        """Nothing is dropped on a port of its own."""
        return 0

    def release(self, node: int, mode: int) -> None:
        """This node is configured."""
        self.released[node] = mode

    def hold(self, node: int) -> None:
        """No longer released."""
        self.released.pop(node, None)
