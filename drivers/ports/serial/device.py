"""Serial interface through pyserial: exclusive, non-blocking, damage in line order with the bytes.

pyserial opens and sets the frame; it switches the parity check off, so PARMRK and INPCK are set through termios afterwards.  PARMRK reports
only "damaged" or BREAK; if the driver counts (TIOCGICOUNT), its counters distinguish parity, framing and overrun.  A pty under its own name
(/dev/pts/5: a simulator, socat) is accepted as well: it has no frame, the format only sets the pace.
"""

import contextlib
import errno
import fcntl
import os
import struct
import termios
from collections.abc import Mapping, Sequence
from typing import Any

import serial

from drivers.ports.base import PortError
from drivers.ports.serial.descriptor import PTY_MAJORS, DescriptorPort, is_pty
from drivers.ports.serial.line_format import LineFormat
from protocols.base.machine import Damage

TIOCGICOUNT = 0x545D  # struct serial_icounter_struct: cts dsr rng dcd rx tx frame overrun parity brk buf_overrun, 9 reserved
TIOCSERGETLSR = 0x5459
TRANSMITTER_EMPTY = 1
NO_UART = ("ttyACM", "tnt", "ttyGS")  # USB devices with their own serial side, virtual null modems: the baud rate has no effect there
HINTS = {
    errno.ENOENT: "is not there; plug the adapter in or correct the path (ls /dev/serial/by-id)",
    errno.EACCES: "may not be opened; add this user to the group of the device (ls -l), usually dialout",
    errno.EBUSY: "is used by another program; close that one first",
    errno.EAGAIN: "is used by another program; close that one first",
    errno.EISDIR: "is a folder; name a serial port (ls /dev/serial/by-id)",
    errno.ENOTTY: "is not a serial port (ls /dev/serial/by-id)",
}


SPEEDS = {getattr(termios, name): int(name[1:]) for name in dir(termios) if name[0] == "B" and name[1:].isdecimal()}
SIZES = {termios.CS5: 5, termios.CS6: 6, termios.CS7: 7, termios.CS8: 8}


def frame_of(settings: Sequence[Any], asked_baud: int) -> str:
    """Result of tcgetattr as a line format; termios cannot express unusual speeds, so the requested one is assumed."""
    flags = settings[2]
    baud = SPEEDS.get(settings[5], settings[5]) if asked_baud in SPEEDS.values() else asked_baud
    parity = "N" if not flags & termios.PARENB else "O" if flags & termios.PARODD else "E"
    return f"{baud} {SIZES[flags & termios.CSIZE]}{parity}{2 if flags & termios.CSTOPB else 1}"


def named_damage(items: list[bytes | Damage], before: Mapping[Damage, int], now: Mapping[Damage, int]) -> list[bytes | Damage]:
    """Classify the marked characters of one read from the driver's counters; PARMRK itself reports PARITY for all, BREAK for a 00."""
    if now == before:
        return items
    new = {kind: now[kind] - before[kind] for kind in now}
    marked = Damage.FRAMING if new[Damage.FRAMING] > 0 and new[Damage.PARITY] <= 0 else Damage.PARITY
    names = {Damage.PARITY: marked, Damage.BREAK: Damage.BREAK if new[Damage.BREAK] > 0 else marked}
    named = [names.get(item, item) if isinstance(item, Damage) else item for item in items]
    return [Damage.OVERRUN, *named] if new[Damage.OVERRUN] > 0 else named  # the kernel does not report where characters are missing


def _names_a_pty(path: str) -> bool:
    try:
        return os.major(os.stat(path).st_rdev) in PTY_MAJORS
    except OSError:  # opening it reports the fault
        return False


def _kept(path: str, frame: str, line_format: LineFormat) -> PortError:
    return PortError(errno.EINVAL, f"serial port {path}: the driver keeps {frame} where {line_format} was asked; take another interface")


def _refused(path: str, line_format: LineFormat, error: Exception) -> PortError:
    """Fault text of an interface that accepted no setting; it is read once more for the frame it keeps."""
    try:
        fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    except OSError as gone:
        return PortError(gone.errno or 0, f"serial port {path}: cannot be opened ({gone})")
    try:
        frame = frame_of(termios.tcgetattr(fd), line_format.baud)
    except termios.error:
        frame = str(line_format)
    finally:
        os.close(fd)
    if frame != str(line_format):
        return _kept(path, frame, line_format)
    return PortError(errno.EIO, f"serial port {path}: refuses {line_format} ({error})")


def _is_no_tty(error: Exception) -> bool:
    """pyserial keeps the reason of the kernel in the error before its own."""
    cause = error.__context__
    return isinstance(cause, termios.error) and cause.args[:1] == (errno.ENOTTY,)


class SerialPort(DescriptorPort):
    """One UART or USB adapter."""

    kind, back = "serial port", "the adapter is back"

    def __init__(self, path: str, line_format: LineFormat) -> None:
        super().__init__(path, line_format)
        if not line_format.baud:
            raise ValueError(f"{path}: a real serial interface needs a baud rate; {line_format} has none")
        try:
            frame = LineFormat(line_format.baud, 8, "N", 1) if _names_a_pty(path) else line_format
            self._serial = serial.Serial(
                path,
                line_format.baud,
                bytesize=frame.data_bits,
                parity=frame.parity,
                stopbits=frame.stop_bits,
                timeout=0,
                write_timeout=0,
                exclusive=True,
            )
        except (serial.SerialException, OSError, ValueError) as error:  # ValueError: a speed the driver refuses
            number = getattr(error, "errno", None) or (errno.ENOTTY if _is_no_tty(error) else 0)
            raise PortError(number, f"serial port {path}: {HINTS.get(number, f'cannot be opened ({error})')}") from error
        except termios.error as error:  # the driver knew all requested settings but the frame, and rejects that
            raise _refused(path, line_format, error) from error
        self._fd = self._serial.fileno()
        try:
            self._claim(line_format)
        except PortError:
            self._serial.close()
            raise
        except (OSError, termios.error) as error:
            self._serial.close()
            raise PortError(errno.EIO, f"serial port {path}: refuses parity check or exclusive use ({error})") from error
        self._counts = self._error_counts()

    def _named(self, items: list[bytes | Damage]) -> list[bytes | Damage]:
        if self._counts is not None:
            before, self._counts = self._counts, self._error_counts()
            return named_damage(items, before, self._counts or before)
        return items

    def unsent(self) -> int:
        """At least the bytes that the kernel reports (TIOCOUTQ, transmitter), and those that baud rate and count require (an adapter's own
        buffer).
        """
        try:
            queued = int(struct.unpack("i", fcntl.ioctl(self._fd, termios.TIOCOUTQ, b"\0" * 4))[0])
        except OSError as error:
            raise self._gone(error) from error
        return max(queued or self._transmitting(), super().unsent())

    def close(self) -> None:
        """Discard unsent bytes (a close that waits for a dead partner would block for half a minute); a second call is harmless."""
        if self._fd >= 0:
            at_once, self._fd = is_pty(self._fd), -1
            if at_once:  # nothing to wait for, and the flush would discard what the far end has not read yet
                self._serial.close()
                return
            with contextlib.suppress(OSError, termios.error, serial.SerialException):  # the adapter may be gone already
                self._serial.reset_output_buffer()
            self._serial.close()

    def _claim(self, line_format: LineFormat) -> None:
        """Claim exclusive use and damage marks; PortError if the driver did not accept the frame (the kernel keeps the old one)."""
        fcntl.ioctl(self._fd, termios.TIOCEXCL)
        settings = termios.tcgetattr(self._fd)
        kept = frame_of(settings, line_format.baud)
        self._hears_at_once = is_pty(self._fd) or os.path.basename(os.path.realpath(self.name)).startswith(NO_UART)
        if kept != str(line_format) and not is_pty(self._fd):
            raise _kept(self.name, kept, line_format)
        check = termios.INPCK if self._serial.parity != serial.PARITY_NONE else 0
        settings[0] = settings[0] & ~(termios.IGNPAR | termios.IGNBRK | termios.BRKINT) | termios.PARMRK | check
        settings[6][termios.VMIN], settings[6][termios.VTIME] = 1, 0  # nothing waits: EAGAIN; pyserial's VMIN 0 reads like a hang-up
        termios.tcsetattr(self._fd, termios.TCSANOW, settings)
        # what an earlier program wrote on a pty is with its far end, which has not read it yet
        termios.tcflush(self._fd, termios.TCIFLUSH if is_pty(self._fd) else termios.TCIOFLUSH)

    def _transmitting(self) -> int:
        """1 while the last character is in the shift register, as far as the driver reports it."""
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
