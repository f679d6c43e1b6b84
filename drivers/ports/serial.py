"""A real serial interface through pyserial: exclusive, never blocking, damage in line order with the bytes.

pyserial opens and sets the frame; it switches the parity check off, so PARMRK and INPCK are set through termios afterwards.  PARMRK says
only "damaged" or BREAK; where the driver counts (TIOCGICOUNT) its counters tell parity, framing and overrun apart.
"""

import contextlib
import errno
import fcntl
import os
import struct
import termios
import time

import serial

from drivers.ports.base import PortError
from drivers.ports.linewire import Drain, LineFormat, MarkReader
from protocols.base.machine import Damage

READ_SIZE = 4096
TIOCGICOUNT = 0x545D  # struct serial_icounter_struct: cts dsr rng dcd rx tx frame overrun parity brk buf_overrun, 9 reserved
TIOCSERGETLSR = 0x5459
TRANSMITTER_EMPTY = 1
HINTS = {
    errno.ENOENT: "is not there; plug the adapter in or correct the path (ls /dev/serial/by-id)",
    errno.EACCES: "may not be opened; add this user to the group of the device (ls -l), usually dialout",
    errno.EBUSY: "is used by another program; end that one first",
    errno.EAGAIN: "is used by another program; end that one first",
}


class SerialPort:
    """One UART or USB adapter."""

    def __init__(self, path: str, line_format: LineFormat) -> None:
        self.name = path
        self.char_ns = line_format.char_ns
        self._drain = Drain(self.char_ns)
        self._marks = MarkReader()
        if not line_format.baud:
            raise ValueError(f"{path}: a real serial interface needs a baud rate; {line_format} has none")
        try:
            self._serial = serial.Serial(
                path,
                line_format.baud,
                bytesize=line_format.data_bits,
                parity=line_format.parity,
                stopbits=line_format.stop_bits,
                timeout=0,
                write_timeout=0,
                exclusive=True,
            )
        except (serial.SerialException, OSError, ValueError) as error:  # ValueError: a speed the driver refuses
            number = getattr(error, "errno", None) or 0
            raise PortError(number, f"serial port {path}: {HINTS.get(number, f'cannot be opened ({error})')}") from error
        self._fd: int = self._serial.fileno()
        try:
            self._claim()
        except (OSError, termios.error) as error:
            self._serial.close()
            raise PortError(errno.EIO, f"serial port {path}: refuses parity check or exclusive use ({error})") from error
        self._counts = self._error_counts()

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
        items = self._marks.read(data)
        if self._counts is not None:
            items = self._name_damage(items, self._counts)
        return items

    def write(self, data: bytes) -> int:
        """How many bytes were taken."""
        try:
            count = os.write(self._fd, data)
        except BlockingIOError:
            return 0
        except OSError as error:
            raise self._gone(error) from error
        self._drain.took(count, time.monotonic_ns())
        return count

    def unsent(self) -> int:
        """Never less than the kernel says (TIOCOUTQ, transmitter), never less than baud rate and count allow (an adapter's own buffer)."""
        try:
            queued = int(struct.unpack("i", fcntl.ioctl(self._fd, termios.TIOCOUTQ, b"\0" * 4))[0])
        except OSError as error:
            raise self._gone(error) from error
        return max(queued or self._transmitting(), self._drain.left(time.monotonic_ns()))

    def close(self) -> None:
        """Forgets what has not left (a close that waits for a dead partner would block for half a minute); twice does no harm."""
        if self._fd >= 0:
            self._fd = -1
            with contextlib.suppress(OSError, termios.error, serial.SerialException):  # the adapter may be gone already
                self._serial.reset_output_buffer()
            self._serial.close()

    def _claim(self) -> None:
        fcntl.ioctl(self._fd, termios.TIOCEXCL)
        settings = termios.tcgetattr(self._fd)
        check = termios.INPCK if self._serial.parity != serial.PARITY_NONE else 0
        settings[0] = settings[0] & ~(termios.IGNPAR | termios.IGNBRK | termios.BRKINT) | termios.PARMRK | check
        termios.tcsetattr(self._fd, termios.TCSANOW, settings)
        termios.tcflush(self._fd, termios.TCIOFLUSH)

    def _transmitting(self) -> int:
        """1 while the last character is in the shift register, as far as the driver tells."""
        try:
            status = struct.unpack("i", fcntl.ioctl(self._fd, TIOCSERGETLSR, b"\0" * 4))[0]
        except OSError:
            return 0
        return 0 if status & TRANSMITTER_EMPTY else 1

    def _error_counts(self) -> dict[Damage, int] | None:
        try:
            counts = struct.unpack("20i", fcntl.ioctl(self._fd, TIOCGICOUNT, b"\0" * 80))
        except OSError:
            return None
        return {Damage.FRAMING: counts[6], Damage.OVERRUN: counts[7] + counts[10], Damage.PARITY: counts[8], Damage.BREAK: counts[9]}

    def _name_damage(self, items: list[bytes | Damage], before: dict[Damage, int]) -> list[bytes | Damage]:
        now = self._error_counts()
        if now is None or now == before:
            return items
        self._counts = now
        new = {kind: count - before[kind] for kind, count in now.items()}
        if new[Damage.FRAMING] > 0 and new[Damage.PARITY] <= 0:
            items = [Damage.FRAMING if item is Damage.PARITY else item for item in items]
        if new[Damage.BREAK] <= 0:  # a damaged character 00 reads as BREAK in PARMRK form
            items = [(Damage.PARITY if new[Damage.PARITY] > 0 else Damage.FRAMING) if item is Damage.BREAK else item for item in items]
        if new[Damage.OVERRUN] > 0:
            items = [Damage.OVERRUN, *items]  # somewhere in this read characters are missing; the kernel does not say where
        return items

    def _gone(self, error: OSError) -> PortError:
        return PortError(error.errno, f"serial port {self.name}: is gone ({error.strerror}); it is opened again when the adapter is back")
