"""A capture of Modbus TCP while it grows: a FIFO or a file tcpdump writes, read at each tick.  Nothing can be written to it."""

import contextlib
import os
import stat

from gateway.pure.shadow.packets import Capture, Packet
from protocols.base.errors import DecodeError
from protocols.base.machine import Ns

AGAIN_NS: Ns = 250_000_000
CHUNK = 1 << 16
AT_ONCE = 16  # chunks of one tick


class CaptureTap:
    """`turn` returns the packets that came; `offset` converts their stamps to our clock."""

    def __init__(self, path: str) -> None:
        self.path, self.why = path, "not opened yet"
        self.offset: Ns = 0
        self._fd, self._again = -1, 0
        self._fifo = self._known = False
        self._capture = Capture()

    @property
    def connected(self) -> bool:
        """The capture exists, and a program writes it."""
        return self._fd >= 0 and not self.why

    def turn(self, now: Ns) -> list[Packet]:
        """New packets since the last call."""
        if self._fd < 0 and not self._open(now):
            return []
        found: list[Packet] = []
        try:
            for _ in range(AT_ONCE):
                data = self._read()
                found += self._capture.feed(data)
                if len(data) < CHUNK:
                    break
        except DecodeError as error:
            self._lose(f"{self.path}: {error}")
            return []
        if found:
            nearest = min(now - packet.stamp for packet in found)  # the quickest on their way show how far the clocks are apart
            self.offset = min(self.offset, nearest) if self._known else nearest
            self._known = True
        return found

    def close(self) -> None:
        self._lose("closed")

    def _open(self, now: Ns) -> bool:
        if now < self._again:
            return False
        self._again = now + AGAIN_NS
        try:
            self._fd = os.open(self.path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError as error:
            self.why = f"{self.path}: {error.strerror}; next: mkfifo {self.path}, then tcpdump --immediate-mode -U -w {self.path}"
            return False
        self._fifo, self._capture = stat.S_ISFIFO(os.fstat(self._fd).st_mode), Capture()
        if not self._fifo:  # a file: its content is older than this run
            with contextlib.suppress(DecodeError):
                while len(data := os.read(self._fd, CHUNK)) > 0:
                    list(self._capture.feed(data))
        self.why = f"{self.path}: no program writes to it" if self._fifo else ""
        return True

    def _read(self) -> bytes:
        try:
            data = os.read(self._fd, CHUNK)
        except BlockingIOError:  # a writer is connected and has nothing new
            self.why = ""
            return b""
        if self._fifo:
            self.why = "" if data else f"{self.path}: no program writes to it"
            if not data:
                self._capture = Capture()  # the next writer begins with its own header
        return data

    def _lose(self, why: str) -> None:
        if self._fd >= 0:
            os.close(self._fd)
        self._fd, self.why = -1, why
