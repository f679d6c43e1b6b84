"""A pseudo terminal whose other end is the line process (or a test): raw 8N1, marks in PARMRK form decoded here (AX-060).

A pty knows neither parity nor pace; the line process makes both.  `unsent` is computed from count and character time.
"""

import errno
import fcntl
import os
import termios
import time

from drivers.ports.base import PortError
from drivers.ports.linewire import Drain, LineFormat, MarkReader
from protocols.base.machine import Damage

READ_SIZE = 4096


def set_raw(fd: int) -> None:
    """8N1 without any treatment of characters, in either direction."""
    settings = termios.tcgetattr(fd)
    settings[0:4] = [0, 0, termios.CS8 | termios.CREAD | termios.CLOCAL, 0]
    settings[6][termios.VMIN], settings[6][termios.VTIME] = 1, 0
    termios.tcsetattr(fd, termios.TCSANOW, settings)


class PtyPort:
    """The slave end of a pty, locked against a second user."""

    def __init__(self, path: str, line_format: LineFormat, *, marks: bool = True) -> None:
        self.name = path
        self.char_ns = line_format.char_ns
        self._drain = Drain(self.char_ns)
        self._marks = MarkReader() if marks else None
        try:
            self._fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError as error:
            raise PortError(error.errno, f"pty {path}: {error.strerror}; is its line process running, and the adapter inserted?") from error
        try:
            fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            set_raw(self._fd)
            self._forget_old()
        except (OSError, termios.error) as error:
            os.close(self._fd)
            number = error.args[0] if error.args else 0
            why = (
                "is used by another program; end that one first" if number == errno.EAGAIN else f"cannot be set up ({error}); is it a pty?"
            )
            raise PortError(number, f"pty {path}: {why}") from error

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
        return self._marks.read(data) if self._marks else [data]

    def write(self, data: bytes) -> int:
        """How many bytes were taken."""
        before = time.monotonic_ns()  # not afterwards: who is read may run at once and leave us standing, and the line is never that late
        try:
            count = os.write(self._fd, data)
        except BlockingIOError:
            return 0
        except OSError as error:
            raise self._gone(error) from error
        if self.char_ns:
            self._drain.took(count, before)
        return count

    def unsent(self) -> int:
        """Characters the line process still has on its way, by count and character time."""
        return self._drain.left(time.monotonic_ns()) if self.char_ns else 0

    def close(self) -> None:
        """Twice does no harm."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def _forget_old(self) -> None:
        """What came before anybody listened is not for us, as on a UART nobody had opened."""
        for _ in range(64):  # the kernel keeps 64 KiB for one that does not read
            termios.tcflush(self._fd, termios.TCIFLUSH)
            try:
                if not os.read(self._fd, READ_SIZE):
                    return
            except BlockingIOError:
                return

    def _gone(self, error: OSError) -> PortError:
        return PortError(error.errno, f"pty {self.name}: is gone ({error.strerror}); it is opened again when its line process offers it")
