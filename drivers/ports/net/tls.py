"""A TCP connection inside TLS: the client's side of Modbus/TCP Security.  The given context decides which certificates are trusted."""

import errno
import ssl

from drivers.ports.base import PortError
from drivers.ports.net.tcp import READ_SIZE, TcpPort
from drivers.ports.serial.line_format import LineFormat
from protocols.base.machine import Damage

HANDSHAKE_S = 2.0  # two round trips and a signature on each side
NO_PACE = LineFormat(0)


class TlsPort(TcpPort):
    """Opening waits for partner and handshake (a line runner opens in a thread of its own)."""

    def __init__(self, host: str, port: int, context: ssl.SSLContext) -> None:
        super().__init__(host, port, NO_PACE)
        self.name = f"tls://{host}:{port}"
        plain = self._socket
        plain.settimeout(HANDSHAKE_S)
        try:
            self._tls = context.wrap_socket(plain, server_hostname=host)
        except OSError as error:  # ssl.SSLError and CertificateError too
            plain.close()
            raise PortError(
                error.errno or errno.EPROTO, f"{self.name}: no TLS ({error}); both sides need certificates the other side's ca has signed"
            ) from error
        self._tls.setblocking(False)
        self._socket = self._tls

    def read(self) -> list[bytes | Damage]:
        """All received bytes: data already decrypted by TLS would not make the descriptor readable again."""
        chunks: list[bytes | Damage] = []
        while True:
            try:
                data = self._tls.recv(READ_SIZE)
            except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
                return chunks
            except OSError as error:
                raise self._gone(error) from error
            if data:
                chunks.append(data)
            elif chunks:
                return chunks  # the end is reported by the next read
            else:
                raise self._gone(OSError(errno.ECONNRESET, "closed by the partner"))

    def write(self, data: bytes) -> int:
        """Number of bytes accepted."""
        try:
            return self._tls.send(data)
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
            return 0
        except OSError as error:
            raise self._gone(error) from error
