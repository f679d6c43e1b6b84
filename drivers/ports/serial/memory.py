"""Two byte ports joined in memory, inside one process: for tests of loops without any device."""

import contextlib
import errno
import os
from collections import deque

from drivers.ports.base import PortError
from protocols.base.machine import Damage

LIMIT = 65536  # characters one end keeps for a reader that does not come


class MemoryPort:
    """One end; made by memory_pair."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.char_ns = 0
        self._inbox: deque[bytes | Damage] = deque()
        self._waiting = 0
        self._event = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._peer: MemoryPort | None = None

    def join(self, peer: "MemoryPort") -> None:
        """Joins both ends."""
        self._peer, peer._peer = peer, self

    def fileno(self) -> int:
        """Readable when read() has something."""
        return self._event

    def read(self) -> list[bytes | Damage]:
        """Everything that waits, in order."""
        with contextlib.suppress(BlockingIOError):
            os.eventfd_read(self._event)
        items = list(self._inbox)
        self._inbox.clear()
        self._waiting = 0
        if self._peer is None:
            if items:
                os.eventfd_write(self._event, 1)  # the end is reported with the next read
                return items
            raise PortError(errno.EIO, f"{self.name}: the other end is closed; make a new pair")
        return items

    def write(self, data: bytes) -> int:
        """How many bytes the other end had room for."""
        if self._peer is None:
            raise PortError(errno.EIO, f"{self.name}: the other end is closed; make a new pair")
        return self._peer._take(data)

    def damage(self, kind: Damage) -> None:
        """The other end receives a damaged character."""
        if self._peer is not None:
            self._peer._put(kind)

    def unsent(self) -> int:
        """Memory has no line."""
        return 0

    def close(self) -> None:
        """The other end is informed; a second call is harmless."""
        if self._event < 0:
            return
        if self._peer is not None:
            peer, self._peer = self._peer, None
            peer._peer = None
            os.eventfd_write(peer._event, 1)
        os.close(self._event)
        self._event = -1

    def _take(self, data: bytes) -> int:
        count = min(len(data), LIMIT - self._waiting)
        if count:
            self._waiting += count
            self._put(bytes(data[:count]))
        return count

    def _put(self, item: bytes | Damage) -> None:
        self._inbox.append(item)
        os.eventfd_write(self._event, 1)


def memory_pair(name: str = "memory") -> tuple[MemoryPort, MemoryPort]:
    """Two joined ports."""
    one, other = MemoryPort(f"{name}/a"), MemoryPort(f"{name}/b")
    one.join(other)
    return one, other
