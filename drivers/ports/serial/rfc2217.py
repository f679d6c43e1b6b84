"""Serial interface on an RFC 2217 server (Telnet COM port control), through pyserial: the frame is set at the server.

pyserial reads the connection in a thread of its own and has no file descriptor to wait on, so a second thread passes received bytes through
a socket pair.  RFC 2217 reports line errors as a state, not at their place among the characters: the block check finds a block damaged in
this way.
"""

import contextlib
import errno
import socket
import threading
import time

import serial
from serial import rfc2217

from drivers.ports.base import PortError
from drivers.ports.serial.line_format import Drain, LineFormat
from protocols.base.machine import Damage

READ_SIZE = 4096
WAIT_S = 0.05  # longest wait of the reading thread; available bytes are passed on at once


class Rfc2217Port:
    """One client connection; opening waits for the server's answer to the frame (a line runner opens in a thread of its own)."""

    def __init__(self, url: str, line_format: LineFormat) -> None:
        self.name = url
        self.char_ns = line_format.char_ns
        self._drain = Drain(self.char_ns)
        try:
            self._serial = rfc2217.Serial(
                url,
                line_format.baud,
                bytesize=line_format.data_bits,
                parity=line_format.parity,
                stopbits=line_format.stop_bits,
                timeout=WAIT_S,
            )
        except (serial.SerialException, OSError, ValueError) as error:
            number = getattr(error, "errno", None) or errno.ETIMEDOUT
            raise PortError(number, f"{url}: no connection ({error}); check address, server and that it speaks RFC 2217") from error
        self._mine, self._readers = socket.socketpair()
        self._mine.setblocking(False)
        self._closed = False
        self._thread = threading.Thread(target=self._carry, name=url, daemon=True)
        self._thread.start()

    def fileno(self) -> int:
        """Readable when read() has something."""
        return self._mine.fileno()

    def read(self) -> list[bytes | Damage]:
        """Received bytes."""
        try:
            data = self._mine.recv(READ_SIZE)
        except BlockingIOError:
            return []
        except OSError as error:
            raise self._gone(error) from error
        if not data:
            raise self._gone(OSError(errno.ECONNRESET, "closed by the server"))
        self._drain.answered(time.monotonic_ns())  # the server may be a program without a line
        return [data]

    def write(self, data: bytes) -> int:
        """All of it is accepted: a block is at most a few hundred bytes."""
        before = time.monotonic_ns()
        try:
            self._serial.write(data)
        except (serial.SerialException, OSError) as error:
            raise self._gone(OSError(errno.ECONNRESET, str(error))) from error
        if self.char_ns:
            self._drain.took(len(data), before)
        return len(data)

    def unsent(self) -> int:
        """As baud rate and count allow: the server does not report it."""
        return self._drain.left(time.monotonic_ns()) if self.char_ns else 0

    def send_break(self, seconds: float = 0.25) -> None:
        """By the server's own interface."""
        try:
            self._serial.send_break(seconds)
        except (serial.SerialException, OSError) as error:
            raise self._gone(OSError(errno.ECONNRESET, str(error))) from error

    def close(self) -> None:
        """Twice does no harm."""
        if not self._closed:
            self._closed = True
            with contextlib.suppress(serial.SerialException, OSError):
                self._serial.close()
            self._thread.join(timeout=1.0)
            self._mine.close()

    def _carry(self) -> None:
        """In a thread of its own: pass received bytes through the socket pair; its end is the end of the connection."""
        with contextlib.suppress(serial.SerialException, OSError, TypeError, AttributeError), self._readers:
            while not self._closed:
                data = self._serial.read(1)
                if data:
                    self._readers.sendall(data + self._serial.read(self._serial.in_waiting))

    def _gone(self, error: OSError) -> PortError:
        return PortError(error.errno, f"{self.name}: connection was lost ({error.strerror}); it is made again when the server is back")
