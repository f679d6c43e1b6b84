"""Two receive-only ports on one line inside asyncio: characters of both directions in the order of the line, decoded to sentences.

A lost port is tried again every quarter of a second; nothing is ever written.
"""

import asyncio
from collections.abc import Callable

from drivers.ports.base import BytePort, PortError
from drivers.ports.listening import ListeningBytes
from drivers.ports.open import open_bytes
from gateway.links.serial.line_monitor import Monitor
from gateway.links.serial.tool_wire import ToolPort
from gateway.pure.lines.decoder import LineReport
from protocols.base.machine import Damage, Ns

AGAIN_NS: Ns = 250_000_000


class _Listened:
    """A listening port for the monitor; it may be missing."""

    def __init__(self, url: str, line_format: str) -> None:
        self.name, self.char_ns, self.why = url, 0, "not opened yet"
        self._format, self._again = line_format, 0
        self.port: BytePort | None = None

    def open(self, now: Ns, watch: Callable[[int], None]) -> None:
        """Try to open, not too often."""
        if self.port is not None or now < self._again:
            return
        self._again = now + AGAIN_NS
        try:
            self.port = ListeningBytes(open_bytes(self.name, self._format))
        except PortError as error:
            self.why = str(error.args[-1])
            return
        self.why = ""
        watch(self.port.fileno())

    def read(self) -> list[bytes | Damage]:
        """Nothing while it is away."""
        return self.port.read() if self.port is not None else []

    def write(self, data: bytes) -> int:
        """Raises Silence, or does nothing at all while the port not available."""
        return self.port.write(data) if self.port is not None else 0

    def unsent(self) -> int:
        return 0

    def wait(self, seconds: float) -> None:
        """The loop waits, not the port."""

    def spoil(self) -> bool:
        return False

    def send_break(self) -> bool:
        return False

    def close(self) -> None:
        if self.port is not None:
            self.port.close()
            self.port = None


class TapPair:
    """`on_report` receives every sentence; call `turn` at every tick."""

    def __init__(
        self,
        ports: tuple[str, str],
        line_format: str,
        clock: Callable[[], Ns],
        on_report: Callable[[LineReport], None],
        *,
        block_check: bool = True,
    ) -> None:
        self._loop, self._clock = asyncio.get_running_loop(), clock
        self._sides = [_Listened(url, line_format) for url in ports]
        sides: list[tuple[str, ToolPort]] = [("A", self._sides[0]), ("B", self._sides[1])]
        self._monitor = Monitor(sides, clock, on_report, block_check)
        self.turn()

    @property
    def connected(self) -> bool:
        """Both ports are there."""
        return all(side.port is not None for side in self._sides)

    @property
    def why(self) -> str:
        """The missing ports."""
        return "; ".join(side.why for side in self._sides if side.why)

    @property
    def characters(self) -> int:
        return self._monitor.characters

    def turn(self) -> None:
        """Open missing ports, read what waits."""
        now = self._clock()
        for side in self._sides:
            side.open(now, self._watch)
        self._take()

    def close(self) -> None:
        for side in self._sides:
            self._lose(side, "closed")

    def _watch(self, fd: int) -> None:
        self._loop.add_reader(fd, self._take)

    def _take(self) -> None:
        try:
            self._monitor.take()
        except PortError as error:
            for side in self._sides:
                self._lose(side, str(error.args[-1]))

    def _lose(self, side: _Listened, why: str) -> None:
        if side.port is not None:
            self._loop.remove_reader(side.port.fileno())
            side.close()
            side.why = why
