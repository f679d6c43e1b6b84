"""Opens a byte port by its address: the one place that knows which addresses there are."""

from drivers.ports.base import BytePort
from drivers.ports.serial.line_format import parse_format

KINDS = '"/dev/ttyUSB0", "pty:/path", "tcp://host:port", "rfc2217://host:port"'


def open_bytes(url: str, format: str = "9600 8E1", marks: bool | None = None) -> BytePort:
    """Opens the port (marks: of a pty).  Raises PortError when it cannot be opened, ValueError when address or format are not readable."""
    line_format = parse_format(format)
    if url.startswith("pty:"):
        from drivers.ports.serial.pty import PtyPort

        return PtyPort(url[4:], line_format, marks=marks)
    if url.startswith("tcp://"):
        from drivers.ports.net.tcp import TcpPort

        host, port = tcp_address(url)
        return TcpPort(host, port, line_format)
    if url.startswith("rfc2217://"):
        from drivers.ports.serial.rfc2217 import Rfc2217Port

        return Rfc2217Port(url, line_format)
    if url.startswith("/"):
        from drivers.ports.serial.device import SerialPort

        return SerialPort(url, line_format)
    raise ValueError(f'port "{url}": expected {KINDS}')


def tcp_address(url: str) -> tuple[str, int]:
    """ "tcp://host:port" or "tcp://[::1]:port"; ValueError names the address."""
    host, colon, port = url.removeprefix("tcp://").rpartition(":")
    if not colon or not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise ValueError(f'port "{url}": tcp://host:port with a port number 1..65535 expected')
    return host.strip("[]"), int(port)
