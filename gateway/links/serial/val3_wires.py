"""The four kinds of wire a sio channel can use.  Nothing here blocks, except making a serial wire (open it in a thread)."""

import socket
import termios
from typing import NamedTuple, Protocol

from drivers.ports.base import BytePort
from drivers.ports.open import open_bytes
from gateway.pure.controllers.val3.sio.channel import ANY, Channel
from protocols.base.machine import Damage

DATAGRAM = 65536
AT_ONCE = 64  # datagrams read before others have their turn


class Heard(NamedTuple):
    what: bytes | Damage | None  # None: the partner sends nothing more
    sender: str = ""  # UDP: address of the sender


class Wire(Protocol):
    """One open connection."""

    channel: Channel

    def fileno(self) -> int: ...
    def read(self, room: int) -> list[Heard]: ...  # [] when nothing waits; OSError when gone
    def write(self, data: bytes) -> int: ...  # number of bytes accepted; OSError when lost
    def configure(self, channel: Channel) -> None: ...  # parameters have changed
    def unsent(self) -> int: ...  # accepted, and not out yet
    def close(self) -> None: ...


class SocketWire:
    """Common base of TCP and UDP."""

    def __init__(self, channel: Channel, sock: socket.socket) -> None:
        self.channel, self._socket = channel, sock
        sock.setblocking(False)

    def fileno(self) -> int:
        """For the loop."""
        return self._socket.fileno()

    def unsent(self) -> int:
        """Not used for a socket."""
        return 0

    def configure(self, channel: Channel) -> None:
        """Remembers the parameters."""
        self.channel = channel

    def close(self) -> None:
        """Twice does no harm."""
        self._socket.close()


class TcpWire(SocketWire):
    """One TCP connection, made by either side."""

    def __init__(self, channel: Channel, sock: socket.socket) -> None:
        super().__init__(channel, sock)
        self.configure(channel)

    def configure(self, channel: Channel) -> None:
        """nagle false: TCP_NODELAY (sioCtrl, "nagle")."""
        self.channel = channel
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 0 if channel.nagle else 1)

    def read(self, room: int) -> list[Heard]:
        """Not more than there is room for: the rest waits at the sender."""
        try:
            data = self._socket.recv(room)
        except BlockingIOError:
            return []
        return [Heard(data or None)]

    def write(self, data: bytes) -> int:
        """Write what the kernel accepts."""
        try:
            return self._socket.send(data)
        except BlockingIOError:
            return 0


class UdpWire(SocketWire):
    """One bound socket for both directions."""

    def __init__(self, channel: Channel) -> None:
        sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        super().__init__(channel, sock)
        self._mine = ""
        try:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if channel.broadcasts:
                sock.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
                self._mine = own_address(channel)
            only_broadcasts = channel.broadcasts and channel.bind == ANY  # a socket bound to that address receives nothing else
            sock.bind((channel.address if only_broadcasts else channel.bind, channel.port))
        except OSError:
            sock.close()
            raise

    def read(self, room: int) -> list[Heard]:
        """Complete datagrams; the echo of our own broadcast is skipped (AX-186)."""
        heard: list[Heard] = []
        for _ in range(AT_ONCE):
            try:
                data, (host, port) = self._socket.recvfrom(DATAGRAM)
            except BlockingIOError:
                break
            if (host, port) != (self._mine, self.channel.port):
                heard.append(Heard(data, host))
        return heard

    def write(self, data: bytes) -> int:
        """One datagram, complete or not at all."""
        try:
            return self._socket.sendto(data, (self.channel.address, self.channel.port))
        except BlockingIOError:
            return 0


def own_address(channel: Channel) -> str:
    """The address of this computer towards that network; OSError if there is no route."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        probe.connect((channel.address, channel.port))
        return str(probe.getsockname()[0])


class SerialWire:
    """A serial line through drivers.ports; PortError and ValueError as open_bytes raises them."""

    def __init__(self, channel: Channel) -> None:
        self.channel = channel
        self._port: BytePort = open_bytes(channel.device, channel.frame)
        if channel.flow_control == "hardware":
            try:
                set_hardware_flow(self._port.fileno())
            except termios.error as error:
                self._port.close()
                raise ValueError(f"{channel.device}: no hardware flow control there ({error})") from error

    def fileno(self) -> int:
        """For the loop."""
        return self._port.fileno()

    def read(self, room: int) -> list[Heard]:
        """Bytes and damages in line order; a UART does not wait for room."""
        return [Heard(item) for item in self._port.read()]

    def write(self, data: bytes) -> int:
        """Write what the port accepts."""
        return self._port.write(data)

    def configure(self, channel: Channel) -> None:
        """A frame is set by reopening."""
        self.channel = channel

    def unsent(self) -> int:
        """Characters still on their way out."""
        return self._port.unsent()

    def close(self) -> None:
        """Twice does no harm."""
        self._port.close()


def set_hardware_flow(fd: int) -> None:
    """RTS/CTS on, for a port that is open already.  Raises termios.error."""
    settings = termios.tcgetattr(fd)
    settings[2] |= termios.CRTSCTS
    termios.tcsetattr(fd, termios.TCSANOW, settings)


def listening_socket(channel: Channel) -> socket.socket:
    """OSError when the port cannot be had."""
    sock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        sock.bind((channel.bind, channel.port))
        sock.listen(channel.clients + 8)  # more than it serves: who is too many gets an answer
        sock.setblocking(False)
    except OSError:
        sock.close()
        raise
    return sock
