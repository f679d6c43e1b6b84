"""A PLC in virtual time: the same programs and orders produce the same events.  Scans count from 0; START comes before scan 0."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from gateway.pure.languages.plc.cells import CELLS
from gateway.pure.languages.plc.messages import DRIVES_OFF, Message
from gateway.pure.languages.plc.orders import Order
from gateway.pure.languages.plc.plc import Plc, PlcState, Settings
from gateway.pure.languages.plc.steps import AREA, INPUTS

ANALOG_INPUTS, FULL_SCALE = 1872, 32767
Event = dict[str, object]


@dataclass(slots=True)
class VirtualRun:
    """One run: `run` returns events and end."""

    sources: Mapping[str, str]
    start: str
    orders: Iterable[Order] = ()
    period_ns: int = 10_000_000
    settings: Settings = field(default_factory=Settings)
    events: list[Event] = field(default_factory=list)
    plc: Plc = field(init=False)
    _inputs: bytearray = field(default_factory=lambda: bytearray(AREA))
    _now_ns: int = 0
    _failure: Message | None = None
    _state: str = PlcState.STOP.value
    _drives: bool = True
    _before: bytes = b""

    def __post_init__(self) -> None:
        self.plc = Plc(self.sources, self.settings)

    def run(self, scans: int) -> Event:
        """Runs scans 0 to scans - 1; a period of a PLC that does not run counts as one.  The end."""
        orders = sorted(self.orders, key=lambda order: order.at)
        self._before = self._content()
        self._start(self.start)
        for number in range(scans):
            while orders and orders[0].at <= number:
                self._carry_out(orders.pop(0))
            self._report(number)
            self._scan()
            self._report(number)
        return self._end(scans)

    def _scan(self) -> None:
        """Periods up to the end of a scan."""
        begun = self.plc.scans
        while True:
            self.plc.scan(self._now_ns, bytes(self._inputs))
            self._now_ns += self.period_ns
            if self.plc.scans != begun or self.plc.state is PlcState.STOP:
                return

    def _start(self, name: str) -> None:
        self.start = name or self.start
        if not self.plc.start(self.start):
            self._failure = None

    def _carry_out(self, order: Order) -> None:
        match order.what:
            case "E":
                self._inputs[order.number] = _put(self._inputs[order.number], order)
            case "M":
                self.plc.set_marker(order.number, _put(self.plc.marker(order.number), order))
            case "EA":
                raw = round(order.value / 10.0 * FULL_SCALE) & 0xFFFF
                for at, byte in enumerate(raw.to_bytes(2, "little")):
                    self.plc.set_marker(ANALOG_INPUTS + 2 * (order.number - 1) + at, byte)
            case "START":
                self._start(order.name)
            case "STOP":
                self.plc.stop()
            case "ACK":
                self.plc.acknowledge()
            case "DRIVES":
                self.plc.drives = bool(order.value)
            case _:
                self.plc.power_on(self.plc.retained(self._now_ns), self._now_ns)
                self._start(self.start)

    def _report(self, number: int) -> None:
        """Events since the last report, in the order: messages, state, drives, outputs, markers."""
        for message in self.plc.take_messages():
            self._message(number, message)
        if self.plc.state.value != self._state:
            self._state = self.plc.state.value
            self._add(number, "state", self._state)
        if self.plc.drives != self._drives:
            self._drives = self.plc.drives
            self._add(number, "drives", "ON" if self._drives else "OFF")
        content = self._content()
        if content != self._before:
            for at, (old, new) in enumerate(zip(self._before, content, strict=True)):
                if old != new:
                    self._add(number, f"A{at}" if at < AREA else f"M{at - AREA}", new)
        self._before = content

    def _message(self, number: int, message: Message) -> None:
        if message.reaction == DRIVES_OFF and message.program and self.plc.state is PlcState.STOP:
            self._failure = message
        self._add(
            number,
            "message",
            message.text,
            number=message.number,
            text=message.text,
            program=message.program,
            step=message.step,
            **{"class": message.kind},
        )

    def _add(self, at: int, what: str, value: object, /, **facts: object) -> None:
        self.events.append({"at": at, "what": what, "value": value, **facts})

    def _content(self) -> bytes:
        """Return the present outputs, then the markers before the images."""
        return self.plc.outputs + bytes(self.plc.data.memory[:INPUTS])

    def _end(self, scans: int) -> Event:
        running = self.plc.state is PlcState.RUN
        failure = self._failure if not running else None
        program = self.plc.program
        last = program.routines[program.start].last if program else 1
        return {
            "state": "running" if running else "error" if failure or program is None else "stopped",
            "program": failure.program if failure else program.start if program else self.start,
            "step": failure.step if failure else last if running else 1,
            "scans": scans,
            "time_s": round(self._now_ns / 1e9, 9),
            "variables": self._variables(),
        }

    def _variables(self) -> dict[str, int]:
        """Everything that is not 0."""
        content = self._content()
        found = {f"A{at}" if at < AREA else f"M{at - AREA}": value for at, value in enumerate(content) if value}
        cells = self.plc.data.cells
        return found | {f"{'Z' if cells.is_counter(at) else 'T'}{at}": cells.content(at) for at in range(CELLS) if cells.content(at)}


def _put(byte: int, order: Order) -> int:
    """Return the byte with the bit of an order, or its full value."""
    value = int(order.value)
    return value if order.bit is None else byte & ~(1 << order.bit) | value << order.bit
