"""What a pty and a serial interface share: bytes and damage marks from a descriptor that never blocks, and characters on their way out."""

import errno
import os
import time

from drivers.ports.base import PortError
from drivers.ports.linewire import Drain, LineFormat, MarkReader
from protocols.base.machine import Damage

READ_SIZE = 4096


class DescriptorPort:
    """Whoever derives opens `_fd` and says in `_gone` what it means when it is no more."""

    kind = ""  # in messages: "pty", "serial port"
    back = ""  # when it is opened again

    def __init__(self, path: str, line_format: LineFormat, *, marks: bool = True) -> None:
        self.name = path
        self.char_ns = line_format.char_ns
        self._fd = -1
        self._drain = Drain(self.char_ns)
        self._marks = MarkReader() if marks else None
        low = (1 << line_format.data_bits) - 1
        self._bits = bytes(byte & low for byte in range(256)) if line_format.data_bits < 8 else None  # what a UART would send

    def fileno(self) -> int:
        """Readable when read() has something."""
        return self._fd

    def read(self) -> list[bytes | Damage]:
        """Good runs and damages in line order; [] when nothing waits."""
        try:
            data = os.read(self._fd, READ_SIZE)
        except BlockingIOError:
            return []
        except OSError as error:
            raise self._gone(error) from error
        if not data:
            raise self._gone(OSError(errno.EIO, "hung up"))
        return self._named(self._marks.read(data) if self._marks else [data])

    def write(self, data: bytes) -> int:
        """How many bytes were taken."""
        # The moment before, not afterwards: who is read may run at once and leave us standing, and the line is never that late.
        before = time.monotonic_ns() if self.char_ns else 0
        try:
            count = os.write(self._fd, data if self._bits is None else data.translate(self._bits))
        except BlockingIOError:
            return 0
        except OSError as error:
            raise self._gone(error) from error
        if self.char_ns:
            self._drain.took(count, before)
        return count

    def unsent(self) -> int:
        """Characters still on their way, by count and character time."""
        return self._drain.left(time.monotonic_ns()) if self.char_ns else 0

    def _named(self, items: list[bytes | Damage]) -> list[bytes | Damage]:
        """Damages by what the driver knows beside the marks."""
        return items

    def _gone(self, error: OSError) -> PortError:
        return PortError(error.errno, f"{self.kind} {self.name}: is gone ({error.strerror}); it is opened again when {self.back}")
