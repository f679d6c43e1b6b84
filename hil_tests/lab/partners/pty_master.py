"""The master end of a bare pty as a port: joins two machines without a line process between them (no pace, no damage)."""

import os

from drivers.ports.base import PortError
from drivers.ports.serial.line_format import escape
from drivers.ports.serial.pty import READ_SIZE, offer_marks, set_raw
from protocols.base.machine import Damage


class PtyMaster:
    """Owns a pty pair; the partner opens `path` as a PtyPort, which reads PARMRK form."""

    def __init__(self) -> None:
        self._fd, self._slave = os.openpty()  # the slave is held open, so that a partner's leaving does not end the pair
        set_raw(self._slave)
        offer_marks(self._slave)
        os.set_blocking(self._fd, False)
        self.path = os.ttyname(self._slave)
        self.name = f"master of {self.path}"
        self.char_ns = 0
        self._rest = b""  # second half of a torn FF FF

    def fileno(self) -> int:
        """Readable when the slave wrote."""
        return self._fd

    def read(self) -> list[bytes | Damage]:
        """What the slave wrote; it is plain, a slave sends no marks."""
        try:
            return [os.read(self._fd, READ_SIZE)]
        except BlockingIOError:
            return []
        except OSError as error:
            raise PortError(error.errno, f"{self.name}: lost ({error.strerror})") from error

    def write(self, data: bytes) -> int:
        """How many characters were taken."""
        wire = self._rest + escape(data)
        try:
            count = os.write(self._fd, wire)
        except BlockingIOError:
            return 0
        except OSError as error:
            raise PortError(error.errno, f"{self.name}: lost ({error.strerror})") from error
        if count == len(wire):
            self._rest = b""
            return len(data)
        taken = count - len(self._rest)
        marks = escape(data)[: max(taken, 0)].count(b"\xff")
        self._rest = b"\xff" if marks % 2 else b""
        return max(taken, 0) - marks // 2

    def unsent(self) -> int:
        """A bare pty has no line."""
        return 0

    def close(self) -> None:
        """Hangs the slave up; twice does no harm."""
        if self._fd >= 0:
            os.close(self._slave)
            os.close(self._fd)
            self._fd = -1
