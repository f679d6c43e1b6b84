"""Common base of a pty and a serial interface: bytes and damage marks from a non-blocking descriptor, and characters on their way out."""

import errno
import os
import termios
import time

from drivers.ports.base import PortError
from drivers.ports.serial.line_format import Drain, LineFormat, MarkReader
from protocols.base.machine import Damage

READ_SIZE = 4096


PTY_MAJORS = range(136, 144)  # UNIX98 slaves (devices.txt of the kernel)


def is_pty(fd: int) -> bool:
    """The slave end of a pty: it carries characters only, without frame, parity or BREAK."""
    return os.major(os.fstat(fd).st_rdev) in PTY_MAJORS


class DescriptorPort:
    """A derived class opens `_fd` and defines in `_gone` what its loss means."""

    kind = ""  # in messages: "pty", "serial port"
    back = ""  # when it is opened again

    def __init__(self, path: str, line_format: LineFormat, *, marks: bool = True) -> None:
        self.name = path
        self.char_ns = line_format.char_ns
        self._fd = -1
        self._drain = Drain(self.char_ns)
        self._hears_at_once = False  # output has no pace: an answer shows that all of it has arrived
        self._marks = MarkReader() if marks else None  # a pty asks its other end first
        low = (1 << line_format.data_bits) - 1
        self._bits = bytes(byte & low for byte in range(256)) if line_format.data_bits < 8 else None  # bits that a UART would send

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
            if self._only_empty():
                return []
            raise self._gone(OSError(errno.EIO, "hung up"))
        if self._hears_at_once:
            self._drain.answered(time.monotonic_ns())
        return self._named(self._marks.read(data) if self._marks else [data])

    def _only_empty(self) -> bool:
        """Whether an empty read only means that nothing waits: VMIN is 0 (pyserial leaves it so, and stty can set it).  A terminal that was
        hung up no longer shows its settings.
        """
        try:
            return termios.tcgetattr(self._fd)[6][termios.VMIN] in (0, b"\0")  # a number only where the line is not canonical
        except termios.error:
            return False

    def write(self, data: bytes) -> int:
        """Number of bytes accepted."""
        # The moment before, not afterwards: the reader may run at once while this process waits, and the line is never that late.
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
        """Name damages from the counters of the driver."""
        return items

    def _gone(self, error: OSError) -> PortError:
        return PortError(error.errno, f"{self.kind} {self.name}: lost ({error.strerror}); it is opened again when {self.back}")
