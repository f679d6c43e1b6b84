"""Opens a tool's partner: sim:NAME, line:RUN-LINE, pty:/path, /dev/tty..., COM5, tcp://host:port, rfc2217://host:port.

On Linux it uses the ports of the product, which mark damaged characters; elsewhere pyserial, which does not.  Modules that exist on Linux
only are imported when such a port is opened, never before (AX-200).
"""

import os
import select
import sys
import time

from drivers.ports.base import BytePort, PortError, runtime_dir
from drivers.ports.serial.line_format import LineFormat, parse_format
from gateway.links.serial.tool_wire import RealWire, ToolPort, Wire
from protocols.base.machine import Damage

PYSERIAL = ("COM", "com", "socket://", "loop://")
NETWORK = ("tcp:", "rfc2217:")  # descriptors without an interface of this computer


def open_wire(url: str, line_format: str = "9600 8E1") -> Wire:
    """The line at an address.  PortError: cannot be opened; ValueError: address or format not readable."""
    if url.startswith("sim:"):
        from gateway.conformance.serial.partners import simulated

        return simulated(url[4:], parse_format(line_format))
    return RealWire(open_port(url, line_format))


def open_port(url: str, line_format: str = "9600 8E1", marks: bool | None = None) -> ToolPort:
    """A real port; `sim:` is none.  marks: for a pty whose other end does not announce them."""
    wanted = parse_format(line_format)
    if url.startswith("line:"):
        url = _of_a_run(url)
    if sys.platform == "linux" and not url.startswith(PYSERIAL):
        from drivers.ports.open import open_bytes

        return SelectPort(open_bytes(url, line_format, marks), url)
    if url.startswith("tcp://"):
        url = "socket://" + url.removeprefix("tcp://")
    return PyserialPort(url, wanted)


def _of_a_run(url: str) -> str:
    """`line:demo-plc1`: the PLC's end of the simulated cable of a run that is up; `line:demo-plc1-b` the other."""
    if sys.platform != "linux":
        raise PortError(0, f"port {url}: runs, and so their simulated cables, are on Linux only; sim:NAME works here")
    name = url.removeprefix("line:")
    return f"pty:{runtime_dir() / (name if name.endswith(('-a', '-b')) else f'{name}-a')}"


class SelectPort:
    """A port of the product on Linux."""

    def __init__(self, port: BytePort, url: str) -> None:
        self.name, self.char_ns, self._port, self._url = port.name, port.char_ns, port, url

    def read(self) -> list[bytes | Damage]:
        return self._port.read()

    def write(self, data: bytes) -> int:
        return self._port.write(data)

    def unsent(self) -> int:
        return self._port.unsent()

    def wait(self, seconds: float) -> None:
        select.select([self._port.fileno()], [], [], seconds)

    def spoil(self) -> bool:
        return self._at_the_cable("parity") if self._url.startswith("pty:") else self._wrong_parity()

    def send_break(self) -> bool:
        if self._url.startswith("pty:"):
            return self._at_the_cable("break")
        if self._url.startswith(NETWORK):
            return self._port_of_a_server()
        import termios

        from drivers.ports.serial.descriptor import is_pty

        if is_pty(self._port.fileno()):
            return False  # the kernel accepts the call and does nothing
        termios.tcsendbreak(self._port.fileno(), 0)
        return True

    def close(self) -> None:
        self._port.close()

    def _at_the_cable(self, kind: str) -> bool:
        """A simulated cable can be ordered to damage a character; other ptys cannot."""
        from gateway.simulation.line.control import LineControl

        name, _, side = os.path.basename(self._url.removeprefix("pty:")).rpartition("-")
        if side not in ("a", "b"):
            return False
        try:
            with LineControl(name) as cable:
                if kind == "break":
                    cable.send_break(side.upper())
                else:
                    cable.damage(side.upper(), kind)
                    self._port.write(b"U")
        except PortError:
            return False
        return True

    def _port_of_a_server(self) -> bool:
        """RFC 2217 has a BREAK, a bare TCP connection none."""
        from drivers.ports.serial.rfc2217 import Rfc2217Port

        if not isinstance(self._port, Rfc2217Port):
            return False
        self._port.send_break()
        return True

    def _wrong_parity(self) -> bool:
        """One character with the other parity: the frame is changed for its time (a UART; a TCP server has none)."""
        if self._url.startswith(NETWORK):
            return False
        import termios

        fd = self._port.fileno()
        termios.tcdrain(fd)
        good = termios.tcgetattr(fd)
        if not good[2] & termios.PARENB:
            return False
        wrong = list(good)
        wrong[2] = good[2] ^ termios.PARODD
        termios.tcsetattr(fd, termios.TCSADRAIN, wrong)
        self._port.write(b"U")
        termios.tcdrain(fd)
        time.sleep(2 * self.char_ns / 1e9)  # the adapter's own buffer
        termios.tcsetattr(fd, termios.TCSADRAIN, good)
        return True


class PyserialPort:
    """Any address pyserial knows, on any system; damaged characters are not distinguished from good ones."""

    def __init__(self, url: str, line_format: LineFormat) -> None:
        import serial

        self.name, self.char_ns, self._url = url, line_format.char_ns, url
        try:
            self._serial = serial.serial_for_url(
                url,
                line_format.baud or 9600,
                bytesize=line_format.data_bits,
                parity=line_format.parity,
                stopbits=line_format.stop_bits,
                timeout=0,
                write_timeout=None if url.startswith("rfc2217://") else 5,  # pyserial knows none there
            )
        except (OSError, ValueError) as error:  # SerialException is an OSError
            raise PortError(getattr(error, "errno", None) or 0, f"serial port {url}: cannot be opened ({error})") from error
        self._waited = b""

    def read(self) -> list[bytes | Damage]:
        data, self._waited = self._waited, b""
        try:
            while more := self._serial.read(self._serial.in_waiting or 1):
                data += more
        except OSError as error:
            raise PortError(getattr(error, "errno", None) or 0, f"serial port {self.name}: lost ({error})") from error
        return [data] if data else []

    def write(self, data: bytes) -> int:
        try:
            return int(self._serial.write(data) or 0)
        except OSError as error:
            raise PortError(getattr(error, "errno", None) or 0, f"serial port {self.name}: lost ({error})") from error

    def unsent(self) -> int:
        """0 if the address has no serial line; otherwise unknown, and the count by character time applies."""
        return 0 if "://" in self._url else 1

    def wait(self, seconds: float) -> None:
        self._serial.timeout = seconds
        try:
            self._waited += self._serial.read(1)
        except OSError as error:
            raise PortError(getattr(error, "errno", None) or 0, f"serial port {self.name}: lost ({error})") from error
        self._serial.timeout = 0

    def spoil(self) -> bool:
        if "://" in self._url or self._serial.parity not in ("E", "O"):
            return False
        good = self._serial.parity
        self._serial.flush()
        self._serial.parity = "O" if good == "E" else "E"
        self._serial.write(b"U")
        self._serial.flush()
        time.sleep(2 * self.char_ns / 1e9)  # the adapter's own buffer
        self._serial.parity = good
        return True

    def send_break(self) -> bool:
        if self._url.startswith(("socket://", "loop://")):
            return False
        self._serial.send_break(0.25)
        return True

    def close(self) -> None:
        self._serial.close()
