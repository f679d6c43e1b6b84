"""A pseudo terminal: raw 8N1.  If its other end is the line process, marks in PARMRK form are decoded here (AX-060).

A pty knows neither parity nor pace; the line process adds both and offers marks by a signature in the terminal's settings (AX-651).  A port
that reads them requests them by a lock, so any other program at the same pty gets characters as they are, FF too (AX-1400). `unsent` is
computed from count and character time.
"""

import errno
import fcntl
import os
import struct
import termios

from drivers.ports.base import PortError
from drivers.ports.serial.descriptor import READ_SIZE, DescriptorPort
from drivers.ports.serial.line_format import LineFormat

__all__ = ["READ_SIZE", "PtyPort", "marks_asked", "offer_marks", "set_raw"]

# Control characters that a raw terminal ignores, and the values written by the line process; no program sets them so by chance.
SIGNATURE = {termios.VEOL: b"A", termios.VEOL2: b"X", termios.VREPRINT: b"M", termios.VWERASE: b"K"}

ABSENT = "is its line process running, and the adapter inserted?"
HINTS = {errno.EACCES: "it belongs to another user (ls -l)", errno.EISDIR: "name the pty itself"}
MARKS_AT = 0x41584D4B  # byte of the pty that a port locks while it requests marks; the kernel releases the lock with its last user


def set_raw(fd: int) -> None:
    """8N1 without any treatment of characters, in either direction."""
    settings = termios.tcgetattr(fd)
    settings[0:4] = [0, 0, termios.CS8 | termios.CREAD | termios.CLOCAL, 0]
    settings[6][termios.VMIN], settings[6][termios.VTIME] = 1, 0
    termios.tcsetattr(fd, termios.TCSANOW, settings)


def offer_marks(fd: int) -> None:
    """A port that opens this pty may request marks: then FF is doubled and damaged characters are marked."""
    settings = termios.tcgetattr(fd)
    for place, sign in SIGNATURE.items():
        settings[6][place] = sign
    termios.tcsetattr(fd, termios.TCSANOW, settings)


def _has_marks(fd: int) -> bool:
    control = termios.tcgetattr(fd)[6]
    return all(control[place] == sign for place, sign in SIGNATURE.items())


LOCK = "hhqqi4x"  # type, whence, start, length, pid: fcntl(2), struct flock


def _lock(kind: int) -> bytes:
    return struct.pack(LOCK, kind, os.SEEK_SET, MARKS_AT, 1, 0)


def _ask_for_marks(fd: int) -> None:
    fcntl.fcntl(fd, fcntl.F_OFD_SETLK, _lock(fcntl.F_WRLCK))


def marks_asked(fd: int) -> bool:
    """A port that decodes marks has this pty open (through another descriptor than `fd`).  A lock on all of it is a foreign program's."""
    kind, _, start, length, _ = struct.unpack(LOCK, fcntl.fcntl(fd, fcntl.F_OFD_GETLK, _lock(fcntl.F_WRLCK)))
    return kind != fcntl.F_UNLCK and (start, length) == (MARKS_AT, 1)


class PtyPort(DescriptorPort):
    """The slave end of a pty, locked against a second user.

    marks: its other end marks damage and doubles FF; None: a signature in its settings decides.
    """

    kind, back = "pty", "its line process offers it"

    def __init__(self, path: str, line_format: LineFormat, *, marks: bool | None = None) -> None:
        super().__init__(path, line_format, marks=marks is not False)
        try:
            self._fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError as error:
            raise PortError(error.errno, f"pty {path}: {error.strerror}; {HINTS.get(error.errno or 0, ABSENT)}") from error
        try:
            fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if not _has_marks(self._fd):
                self._marks, self._hears_at_once = self._marks if marks else None, True
            if self._marks is not None:
                _ask_for_marks(self._fd)
            set_raw(self._fd)
            self._forget_old()
        except (OSError, termios.error) as error:
            os.close(self._fd)
            number = error.args[0] if error.args else 0
            why = (
                "is used by another program; close that one first"
                if number == errno.EAGAIN
                else f"cannot be set up ({error}); is it a pty?"
            )
            raise PortError(number, f"pty {path}: {why}") from error

    def close(self) -> None:
        """Twice does no harm."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def _forget_old(self) -> None:
        """Discard bytes that came before anybody listened, as on a UART that was not open."""
        for _ in range(64):  # the kernel keeps 64 KiB for one that does not read
            termios.tcflush(self._fd, termios.TCIFLUSH)
            try:
                if not os.read(self._fd, READ_SIZE):
                    return
            except BlockingIOError:
                return
