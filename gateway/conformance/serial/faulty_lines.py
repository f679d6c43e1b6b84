"""Lines with one fault each, around a good one: faults that `diagnose` must distinguish.  Also available as sim:NAME."""

from collections import deque
from collections.abc import Callable

from drivers.ports.serial.line_format import LineFormat
from gateway.links.serial.tool_wire import Heard, VirtualWire
from protocols.base.machine import Damage, Ns, ms


class Around:
    """A wire that changes the characters; the rest is the wire below."""

    simulated = True

    def __init__(self, wire: VirtualWire) -> None:
        self.wire, self.name, self.char_ns = wire, wire.name, wire.char_ns
        self.late_ns: Ns = 0
        self._own: deque[Heard] = deque()  # characters in addition to the partner's

    def now(self) -> Ns:
        return self.wire.now()

    def held(self, since: Ns, until: Ns) -> Ns:
        return self.wire.held(since, until)

    def drained(self) -> Ns:
        return self.wire.drained()

    def write(self, data: bytes) -> None:
        self.wire.write(data)

    def spoil(self) -> bool:
        return self.wire.spoil()

    def send_break(self) -> bool:
        return self.wire.send_break()

    def hear(self, until: Ns) -> Heard | None:
        until_own = min(until, self._own[0].stamp) if self._own else until
        heard = self.wire.hear(until_own)
        if heard is not None:
            return self.changed(heard)
        return self._own.popleft() if self._own and self._own[0].stamp <= self.now() else None if until_own == until else self.hear(until)

    def changed(self, heard: Heard) -> Heard:
        return heard

    def close(self) -> None:
        self.wire.close()

    def comes_back(self, data: bytes, what: Callable[[int, int], int | Damage | None]) -> None:
        """Own characters that are echoed; `what(place, byte)`: the echo, None: no echo."""
        start = max(self.now(), self.wire.drained() - len(data) * self.char_ns)
        for at, byte in enumerate(data):
            heard = what(at, byte)
            if heard is not None:
                self._own.append(Heard(start + (at + 1) * self.char_ns, heard))


class Echo(Around):
    """A 2-wire adapter that receives itself."""

    def write(self, data: bytes) -> None:
        super().write(data)
        self.comes_back(data, lambda at, byte: byte)


class CrossTalk(Around):
    """An open receiving pair that picks up part of the other pair's signal."""

    def write(self, data: bytes) -> None:
        self.wire.write(b"")
        self.comes_back(data, lambda at, byte: (byte, None, Damage.FRAMING, byte ^ 0x81, None)[at % 5] if len(data) > 1 else None)


class Inverted(Around):
    """A and B exchanged: idle reads as BREAK, nothing else is readable."""

    def __init__(self, wire: VirtualWire) -> None:
        super().__init__(wire)
        self._own.append(Heard(ms(1), Damage.BREAK))

    def write(self, data: bytes) -> None:
        """The partner reads none of it."""

    def changed(self, heard: Heard) -> Heard:
        return Heard(heard.stamp, Damage.FRAMING)


class Latency(Around):
    """A USB adapter that passes on its bytes every 16 ms."""

    def hear(self, until: Ns) -> Heard | None:
        heard = super().hear(until)
        if heard is None:
            return None
        at = -(-heard.stamp // ms(16)) * ms(16)
        self._keep(at)
        return Heard(at, heard.what)

    def _keep(self, until: Ns) -> None:
        """Time passes in the adapter; later characters follow it."""
        late = []
        while (heard := self.wire.hear(until)) is not None:
            late.append(Heard(until, heard.what))
        self._own.extendleft(reversed(late))


class WrongFormat(Around):
    """Opened at another format than the partner's: another speed reads as framing errors, the other parity as parity errors."""

    def __init__(self, wire: VirtualWire, theirs: LineFormat, ours: LineFormat) -> None:
        super().__init__(wire)
        self._damage = None if theirs == ours else Damage.FRAMING if theirs.baud != ours.baud else Damage.PARITY

    def write(self, data: bytes) -> None:
        if self._damage is None:
            super().write(data)
            return
        for _ in data:
            self.wire.spoil()

    def changed(self, heard: Heard) -> Heard:
        return heard if self._damage is None else Heard(heard.stamp, self._damage)


FAULTY: dict[str, Callable[[VirtualWire, LineFormat], Around]] = {
    "echo": lambda wire, ours: Echo(wire),
    "cross-talk": lambda wire, ours: CrossTalk(wire),
    "inverted": lambda wire, ours: Inverted(wire),
    "latency-16ms": lambda wire, ours: Latency(wire),
    "speed-4800": lambda wire, ours: WrongFormat(wire, LineFormat(4800), ours),
    "parity-odd": lambda wire, ours: WrongFormat(wire, LineFormat(9600, parity="O"), ours),
}
