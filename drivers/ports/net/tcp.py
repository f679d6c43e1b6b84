"""A serial line on a TCP serial device server (raw mode), or a partner that uses its serial protocol over TCP."""

import errno
import fcntl
import socket
import struct
import termios
import time

from drivers.ports.base import PortError
from drivers.ports.serial.line_format import Drain, LineFormat
from protocols.base.machine import Damage

READ_SIZE = 4096
CONNECT_S = 1.0
SILENT_PEER_MS = 2000  # a peer that acknowledges nothing for that long is gone; with reconnecting at once the 2 s of coming back hold


class TcpPort:
    """One client connection.  Opening waits for the partner up to a second (a line runner opens in a thread of its own)."""

    def __init__(self, host: str, port: int, line_format: LineFormat) -> None:
        self.name = f"tcp://{host}:{port}"
        self.char_ns = line_format.char_ns
        self._drain = Drain(self.char_ns)
        try:
            self._socket = socket.create_connection((host, port), timeout=CONNECT_S)
        except OSError as error:
            raise PortError(
                error.errno or errno.ETIMEDOUT, f"{self.name}: no connection ({error}); check address, device server and network"
            ) from error
        self._socket.setblocking(False)
        for level, option, value in (
            (socket.IPPROTO_TCP, socket.TCP_NODELAY, 1),
            (socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1),
            (socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, 1),
            (socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, 1),
            (socket.IPPROTO_TCP, socket.TCP_KEEPCNT, 2),
            (socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, SILENT_PEER_MS),
        ):
            self._socket.setsockopt(level, option, value)

    def fileno(self) -> int:
        """Readable when read() has something."""
        return self._socket.fileno()

    def read(self) -> list[bytes | Damage]:
        """Received bytes; TCP reports no damage."""
        try:
            data = self._socket.recv(READ_SIZE)
        except BlockingIOError:
            return []
        except OSError as error:
            raise self._gone(error) from error
        if not data:
            raise self._gone(OSError(errno.ECONNRESET, "closed by the partner"))
        self._drain.answered(time.monotonic_ns())  # a partner that has no serial line answers before the count is over
        return [data]

    def write(self, data: bytes) -> int:
        """Number of bytes accepted."""
        before = time.monotonic_ns()
        try:
            count = self._socket.send(data)
        except BlockingIOError:
            return 0
        except OSError as error:
            raise self._gone(error) from error
        if self.char_ns:
            self._drain.took(count, before)
        return count

    def unsent(self) -> int:
        """At least the bytes that the kernel still holds or the partner has not acknowledged; with a baud rate also those on the serial
        line.
        """
        try:
            queued = int(struct.unpack("i", fcntl.ioctl(self._socket.fileno(), termios.TIOCOUTQ, b"\0" * 4))[0])
        except OSError as error:
            raise self._gone(error) from error
        return max(queued, self._drain.left(time.monotonic_ns()) if self.char_ns else 0)

    def close(self) -> None:
        """Twice does no harm."""
        self._socket.close()

    def _gone(self, error: OSError) -> PortError:
        return PortError(error.errno, f"{self.name}: connection was lost ({error.strerror}); it is made again when the partner is back")
