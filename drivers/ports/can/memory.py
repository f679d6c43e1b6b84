"""Two CAN ports joined in memory, for tests and tools inside one process."""

import contextlib
import os
import time
from collections import deque
from collections.abc import Callable, Sequence

from drivers.ports.base import PortError
from drivers.ports.can.wire import CanCounters, check_frame
from protocols.base.machine import Frame, FrameFault, Ns


class MemoryCanPort:
    """One end.  Frames from the other end wait here, at most `limit`; then its send() accepts fewer, as on a full bus."""

    def __init__(self, name: str, clock: Callable[[], Ns], limit: int) -> None:
        self.name = name
        self.counters = CanCounters()
        self.other: MemoryCanPort | None = None
        self._clock, self._limit = clock, limit
        self._waiting: deque[Frame] = deque()
        self._faults: list[tuple[FrameFault, Ns]] = []
        self._readable = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)

    def fileno(self) -> int:
        return self._readable

    def send(self, frames: Sequence[Frame]) -> int:
        """Number of frames accepted; PortError when the other end is closed."""
        for frame in frames:
            check_frame(frame)
        if self.other is None:
            raise PortError(f"{self.name}: the other end is closed")
        taken = self.other.deliver(frames)
        self.counters.sent += taken
        self.counters.refused += len(frames) - taken
        return taken

    def deliver(self, frames: Sequence[Frame]) -> int:
        """The other end's send: how many fit."""
        fitting = frames[: max(0, self._limit - len(self._waiting))]
        stamp = self._clock()
        self._waiting.extend(Frame(frame.identifier, frame.data, stamp) for frame in fitting)
        if fitting:
            os.eventfd_write(self._readable, 1)
        return len(fitting)

    def fault(self, kind: FrameFault) -> None:
        """For tests: queue an error frame first at this end."""
        self._faults.append((kind, self._clock()))
        self.counters.faults += 1
        os.eventfd_write(self._readable, 1)

    def receive(self) -> list[Frame]:
        """Everything that waits; PortError when nothing waits and the other end is closed."""
        frames = list(self._waiting)
        self._waiting.clear()
        with contextlib.suppress(BlockingIOError):
            os.eventfd_read(self._readable)
        if not frames and self.other is None:
            raise PortError(f"{self.name}: the other end is closed")
        self.counters.received += len(frames)
        return frames

    def receive_next(self) -> list[Frame]:
        """Everything: to leave some of it would be no cheaper here."""
        return self.receive()

    def take_faults(self) -> list[tuple[FrameFault, Ns]]:
        """Error frames since the last call, with their stamps."""
        faults, self._faults = self._faults, []
        return faults

    def close(self) -> None:
        if self.other is not None:
            os.eventfd_write(self.other.fileno(), 1)
            self.other.other = None
            self.other = None
        if self._readable >= 0:
            os.close(self._readable)
            self._readable = -1


def memory_pair(clock: Callable[[], Ns] = time.monotonic_ns, limit: int = 16_384) -> tuple[MemoryCanPort, MemoryCanPort]:
    """Two joined ends; frames are stamped by `clock` when sent."""
    a, b = MemoryCanPort("memory:a", clock, limit), MemoryCanPort("memory:b", clock, limit)
    a.other, b.other = b, a
    return a, b
