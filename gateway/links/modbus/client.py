"""Modbus clients inside asyncio: one connection or line, its devices, their polling.

    client = ModbusClient(Link("tcp://10.0.0.7:502"), [Device("coupler", unit=1)])
    client.start()                                          # inside a running loop; never waits
    client.poll(Group("inputs", "coupler", Kind.DISCRETE_INPUTS, 0, 16, ms(50)), on_values)
    client.order("coupler", write_words_pdu(100, [1, 2]), on_result)    # from synchronous code, as the services' tick
    words = await client.read("coupler", Kind.HOLDING_REGISTERS, 0, 10)

A lost port is reopened automatically (gateway.links.serial.runner); a device that does not answer costs the others one request per
`Device.probe_every`.  All decisions are made in protocols.modbus.master.
"""

import asyncio
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from drivers.ports.base import BytePort
from drivers.ports.open import open_bytes
from gateway.links.serial.runner import LineRunner
from protocols.base.machine import Ns, ms
from protocols.modbus.master import Master, Seen
from protocols.modbus.orders import (
    Device,
    DeviceBack,
    DeviceLost,
    Done,
    Event,
    Failed,
    Failure,
    Group,
    Polled,
    PollFailed,
    Refused,
    read_pdu,
    values_of,
)
from protocols.modbus.timing import OVER_TCP, timing
from protocols.modbus.view import ExceptionCode, Kind
from protocols.modbus.wires import RtuWire, TcpWire, Wire

__all__ = ["Device", "Group", "Kind", "Link", "ModbusClient", "ModbusRefused", "ModbusSilent"]

Result = Done | Refused | Failed
OnResult = Callable[[Result], None]
OnValues = Callable[[tuple[int, ...] | None, Ns], None]  # the values and the moment of the answer; None: could not be read
OnRefused = Callable[[Group, str], None]  # a group a device refuses and how; "": it is read (again)
UNANSWERED = 3  # rounds in a row one group has no answer while its device answers others


@dataclass(frozen=True, slots=True)
class Link:
    """How the devices are reached: "tcp://host:502" with framing tcp or rtu, or a serial port or "pty:PATH" with framing rtu."""

    url: str
    framing: str = "tcp"  # tcp | rtu
    format: str = "9600 8E1"
    patience: Ns = ms(50)  # RTU: silence inside a frame that adapters and pipes make (AX-344)

    def wire(self) -> Wire:
        """The machine of its framing."""
        if self.framing == "tcp":
            return TcpWire()
        if self.url.startswith("tcp://"):
            return RtuWire(OVER_TCP)
        return RtuWire(timing(int(self.format.split()[0]), patience=self.patience))


class ModbusRefused(Exception):
    """The device answered an exception; `code` is its number (ExceptionCode where it is a known one)."""

    def __init__(self, device: str, code: int) -> None:
        super().__init__(f"{device}: {exception_words(code)}")
        self.code = code


class ModbusSilent(Exception):
    """The device did not answer; `why` is the kind of failure."""

    def __init__(self, device: str, why: Failure) -> None:
        super().__init__(f"{device}: {why.name.lower()}")
        self.why = why


class ModbusClient:
    """One link.  All methods belong to the thread of its loop."""

    def __init__(
        self,
        link: Link,
        devices: Sequence[Device],
        on_device: Callable[[str, bool], None] | None = None,
        open_port: Callable[[], BytePort] | None = None,
        on_refused: OnRefused | None = None,
    ) -> None:
        """`on_device(name, alive)` is called each time a device is lost or back, `on_refused` when a device begins or ends to refuse a
        group; `open_port` replaces the port of the link's url.
        """
        self.link = link
        self._open_port = open_port or (lambda: open_bytes(link.url, link.format))
        self._master = Master(link.wire(), devices)
        self._on_device, self._on_refused = on_device, on_refused
        self._groups: dict[str, Group] = {}
        self._unanswered: dict[str, int] = {}
        self._refused: dict[str, str] = {}  # how groups are refused, by their names
        self._results: dict[int, OnResult] = {}
        self._listeners: dict[str, OnValues] = {}
        self._runner: LineRunner[Event] | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    @property
    def devices(self) -> Mapping[str, Seen]:
        """State of each device; live, read only."""
        return self._master.seen

    @property
    def connected(self) -> bool:
        return self._runner is not None and self._runner.state.connected

    @property
    def why(self) -> str:
        """Why there is no connection; "" while connected."""
        return self._runner.state.why if self._runner is not None else "not started"

    def refusals(self) -> list[tuple[Group, str]]:
        """Groups that devices refuse now, and how."""
        return [(self._groups[name], words) for name, words in self._refused.items()]

    def start(self) -> None:
        """Begins to open the port; inside a running loop."""
        self._loop = asyncio.get_running_loop()
        self._runner = LineRunner[Event](self._opened, self._master, self._on_event)

    def close(self) -> None:
        """Ends everything; waiting callers get LOST."""
        if self._runner is not None:
            self._runner.close()
            self._runner = None

    def poll(self, group: Group, on_values: OnValues) -> None:
        """Reads the group from now on, also before `start`; its name must be its own."""
        if group.name in self._listeners:
            raise ValueError(f"group {group.name}: the name is used twice")
        self._listeners[group.name], self._groups[group.name] = on_values, group
        self._master.poll(group, time.monotonic_ns())
        self._kick()

    def order(self, device: str, pdu: bytes, on_result: OnResult | None = None) -> None:
        """One request; `on_result` is called once, never from inside this call.  KeyError: no such device."""
        number = self._master.order(device, pdu, time.monotonic_ns())
        if on_result is not None:
            self._results[number] = on_result
        if self._runner is None:  # otherwise nothing would report it
            self._results.pop(number, None)
            raise RuntimeError("the client is not started")
        self._kick()

    async def ask(self, device: str, pdu: bytes) -> bytes:
        """The answer PDU.  Raises ModbusRefused, ModbusSilent."""
        waiting: asyncio.Future[Result] = asyncio.get_running_loop().create_future()
        self.order(device, pdu, lambda result: None if waiting.done() else waiting.set_result(result))
        result = await waiting
        if isinstance(result, Done):
            return result.pdu
        raise ModbusRefused(device, result.code) if isinstance(result, Refused) else ModbusSilent(device, result.why)

    async def read(self, device: str, kind: Kind, address: int, count: int) -> tuple[int, ...]:
        """Up to 125 registers or 2000 bits; bits are 0 and 1."""
        values = values_of(await self.ask(device, read_pdu(kind, address, count)), count)
        if values is None:
            raise ModbusSilent(device, Failure.SPOILED)
        return values

    async def write_words(self, device: str, address: int, values: Sequence[int]) -> None:
        """FC 6 for one register, FC 16 for more (up to 123)."""
        await self.ask(device, write_words_pdu(address, values))

    async def write_bits(self, device: str, address: int, values: Sequence[bool]) -> None:
        """FC 5 for one coil, FC 15 for more (up to 1968)."""
        await self.ask(device, write_bits_pdu(address, values))

    def _opened(self) -> BytePort:
        """In the opener's thread: the machine is informed of the port before the loop pumps it."""
        port = self._open_port()
        assert self._loop is not None
        self._loop.call_soon_threadsafe(lambda: self._master.opened(time.monotonic_ns()))
        return port

    def _kick(self) -> None:
        if self._runner is not None:
            self._runner.kick()

    def _on_event(self, event: Event, now: Ns) -> None:
        match event:
            case Polled(group, values):
                self._note(group, "")
                self._listeners[group](values, now)
            case PollFailed(group, why):
                self._note(group, self._refusal(group, why))
                self._listeners[group](None, now)
            case DeviceLost(device) | DeviceBack(device):
                if self._on_device is not None:
                    self._on_device(device, isinstance(event, DeviceBack))
            case _:
                listener = self._results.pop(event.order, None)
                if listener is not None:
                    listener(event)

    def _refusal(self, group: str, why: Failure | int) -> str:
        """How the device refuses this group; as before where it or its link is merely away, which is reported as such."""
        if isinstance(why, int):
            return exception_words(why)
        if why is Failure.SPOILED:
            return "the answer does not fit the request"
        if why is Failure.TIMEOUT:
            self._unanswered[group] = self._unanswered.get(group, 0) + 1
        if self._unanswered.get(group, 0) >= UNANSWERED and self._master.seen[self._groups[group].device].alive:
            return "no answer, though the device answers other requests"
        return self._refused.get(group, "")

    def _note(self, group: str, words: str) -> None:
        if not words:
            self._unanswered.pop(group, None)
        before = self._refused.pop(group, "")
        if words:
            self._refused[group] = words
        if words != before and self._on_refused is not None:
            self._on_refused(self._groups[group], words)


def exception_words(code: int) -> str:
    """An exception as a page or the journal shows it."""
    known = code in ExceptionCode.__members__.values()
    return f"exception {code:02X}h{' ' + ExceptionCode(code).name.lower().replace('_', ' ') if known else ''}"


def write_words_pdu(address: int, values: Sequence[int]) -> bytes:
    """FC 6 or FC 16; values 0..65535.  OverflowError for others."""
    head = address.to_bytes(2, "big")
    data = b"".join(value.to_bytes(2, "big") for value in values)
    if len(values) == 1:
        return b"\x06" + head + data
    return b"\x10" + head + len(values).to_bytes(2, "big") + bytes((len(data),)) + data


def write_bits_pdu(address: int, values: Sequence[bool]) -> bytes:
    """FC 5 or FC 15."""
    head = address.to_bytes(2, "big")
    if len(values) == 1:
        return b"\x05" + head + (b"\xff\x00" if values[0] else b"\x00\x00")
    data = bytearray((len(values) + 7) // 8)
    for n, value in enumerate(values):
        data[n >> 3] |= bool(value) << (n & 7)
    return b"\x0f" + head + len(values).to_bytes(2, "big") + bytes((len(data),)) + bytes(data)
