"""Modbus clients of a cell: values of other devices into named values, named values into other devices.

Routes, telegrams and blocks reach them by their names.  A value whose device is away is marked old; a value that is written is written
when it changes and again every `every_ms`, and only while it is good.  Loaded only where a cell has a client.
"""

import math
import pathlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial

from drivers.ports.base import BytePort
from drivers.ports.open import tcp_address
from gateway.assembly.routes import routed_values
from gateway.links.modbus.client import Device, Group, Kind, Link, ModbusClient, Result, exception_words, write_bits_pdu, write_words_pdu
from gateway.pure.cell.modbus import Modbus, ModbusDevice, ModbusValue
from gateway.pure.image.records.cell import Quality
from gateway.services.context import RunContext
from gateway.services.modbus_links import LinkReports
from gateway.services.part import Part
from gateway.services.value_directory import Reader, ValueDirectory, as_number
from protocols.base.errors import EncodeError
from protocols.base.machine import Ns, ms
from protocols.modbus.numbers import decode_number, encode_number, words_of
from protocols.modbus.orders import Done, Failed, Refused
from protocols.telegrams.fields import Value

KINDS = {"coil": Kind.COILS, "discrete": Kind.DISCRETE_INPUTS, "input": Kind.INPUT_REGISTERS, "holding": Kind.HOLDING_REGISTERS}


def size_of(value: ModbusValue) -> int:
    """Number of its bits or registers."""
    return 1 if value.type == "bit" else words_of(value.type)


@dataclass(slots=True)
class Block:
    """Values read by one group."""

    device: str
    table: str
    every_ms: int
    first: int
    end: int
    values: list[ModbusValue] = field(default_factory=list)


def blocks_of(values: Sequence[ModbusValue]) -> list[Block]:
    """Values next to each other in one table, with one period, are read together: they are of one moment."""
    blocks: list[Block] = []
    for value in sorted((each for each in values if each.to), key=lambda each: (each.device, each.table, each.every_ms, each.at)):
        last = blocks[-1] if blocks else None
        same = last is not None and (last.device, last.table, last.every_ms) == (value.device, value.table, value.every_ms)
        if last is None or not same or value.at > last.end:
            last = Block(value.device, value.table, value.every_ms, value.at, value.at)
            blocks.append(last)
        last.values.append(value)
        last.end = max(last.end, value.at + size_of(value))
    return blocks


def device_of(settings: ModbusDevice) -> Device:
    """The client's view of a [[modbus.device]]."""
    return Device(
        settings.name,
        settings.unit,
        ms(settings.timeout_ms),
        ms(settings.pause_ms),
        settings.retries,
        settings.busy_retries,
        ms(settings.busy_pause_ms),
        settings.repeat_writes,
        settings.demote_after,
        ms(settings.probe_ms),
        settings.most_words,
        settings.most_bits,
    )


def secured(settings: Modbus, url: str, folder: pathlib.Path) -> Callable[[], BytePort] | None:
    """Opens the connection inside TLS, with the files as they are then; None: the client of this table has none."""
    tls = settings.tls
    if tls is None:
        return None

    def opened() -> BytePort:
        from drivers.ports.net.tls import TlsPort
        from gateway.links.modbus.tls import client_context  # cryptography only if a cell needs it

        return TlsPort(*tcp_address(url), client_context(tls, folder))

    return opened


@dataclass(slots=True)
class Written:
    """A value that goes out."""

    value: ModbusValue
    order: str
    shown: float | None = None  # value the device has accepted last
    next: Ns = 0
    waiting: bool = False


class ClientLink:
    """One [[modbus]] with role client.  `routed`: values of registers used in routes, `registers`: their state by key."""

    def __init__(
        self, run: RunContext, values: ValueDirectory, settings: Modbus, routed: Sequence[ModbusValue], registers: dict[str, float | None]
    ) -> None:
        self._directory, self.settings, self._registers = values, settings, registers
        url = str(run.plan.modbus[settings.name])
        self._values = (*settings.value, *routed)
        registers |= dict.fromkeys((value.name for value in routed), None)
        self._orders = {device.name: device.order for device in settings.device}
        link = Link(url, settings.framing, settings.format, ms(settings.patience_ms))
        folder = pathlib.Path(run.cell.file).resolve().parent
        self._reports = LinkReports(run.journal, f"Modbus client {settings.name}", link)
        devices, open_port = [device_of(device) for device in settings.device], secured(settings, url, folder)
        self.client = ModbusClient(link, devices, self._reports.device, open_port, self._reports.read)
        self._written = [Written(value, self._orders[value.device]) for value in self._values if value.from_]

    def start(self) -> None:
        """Begins; inside the loop."""
        for n, block in enumerate(blocks_of(self._values)):
            group = Group(f"{n}", block.device, KINDS[block.table], block.first, block.end - block.first, ms(block.every_ms))
            self.client.poll(group, partial(self._read, block, n))
        self.client.start()

    def step(self, now: Ns) -> None:
        """Values that changed, or are due again, are written."""
        self._reports.step(self.client, now)
        for written in self._written:
            value = self._given(written.value.from_)
            if not written.waiting and value is not None and (value != written.shown or now >= written.next):
                self._write(written, value, now)

    def _given(self, name: str) -> float | None:
        """The value to write; None: it is not valid.  The route decides the value during a loss."""
        if name in self._registers:
            return self._registers[name]
        sample = self._directory.named.sample(name)
        value = sample.value
        return float(value) if sample.quality is Quality.GOOD and isinstance(value, int | float) else None

    def status(self) -> dict[str, object]:
        """For tools."""
        return self._reports.status(self.client)

    def _read(self, block: Block, n: int, values: tuple[int, ...] | None, now: Ns) -> None:
        source = f"modbus.{self.settings.name}.{n}"
        if values is None:
            self._directory.named.source_gone(source)
            for value in block.values:
                if value.to in self._registers:
                    self._registers[value.to] = None
            return
        for value in block.values:
            part = values[value.at - block.first : value.at - block.first + size_of(value)]
            number = float(part[0]) if value.type == "bit" else decode_number(part, value.type, self._orders[value.device])
            if value.to in self._registers:
                self._registers[value.to] = number if math.isfinite(number) else None
            elif math.isfinite(number):
                self._directory.named.put(value.to, number * value.scale, now, source)
        self._directory.changed()

    def _write(self, written: Written, value: float, now: Ns) -> None:
        settings = written.value
        written.next = now + ms(settings.every_ms)
        try:
            pdu = pdu_of(settings, value, written.order)
        except EncodeError:
            return  # it does not fit: the device keeps its value, the limits of the route or telegram refuse it

        def take_result(result: Result) -> None:
            written.waiting = False
            written.shown = value if isinstance(result, Done) else None
            if not isinstance(result, Failed):  # a device that is away is reported as such
                words = exception_words(result.code) if isinstance(result, Refused) else ""
                self._reports.written(settings.device, f"{settings.from_} to {settings.table} {settings.at}", words)

        written.waiting = True
        self.client.order(settings.device, pdu, take_result)


def pdu_of(value: ModbusValue, number: float, order: str) -> bytes:
    """The write request.  EncodeError: the number does not fit its type."""
    if value.type == "bit":
        return write_bits_pdu(value.at, [bool(number)])
    return write_words_pdu(value.at, encode_number(number / value.scale, value.type, order))


class RegisterValues:
    """Provider of registers that routes name; a read one is valid while it was read."""

    def __init__(self, registers: dict[str, float | None]) -> None:
        self._registers = registers

    def names(self) -> Iterable[str]:
        """Keys of places, for routes only."""
        return ()

    def read(self, name: str, reader: Reader | None) -> Value:
        value = self._registers[name]
        if value is None:
            raise KeyError(name)
        return value

    def valid(self, name: str) -> bool:
        return self._registers[name] is not None

    def write(self, name: str, value: Value, now: Ns, by: str) -> None:
        if name not in self._registers:
            raise KeyError(name)
        self._registers[name] = as_number(value)


class ModbusClients(Part):
    """All clients of a cell; nothing at all without one."""

    def __init__(self, run: RunContext, values: ValueDirectory) -> None:
        self.registers: dict[str, float | None] = {}  # those at the ends of routes, by `register_key`; None: not read, or lost
        routed = routed_values(run.cell)
        self.links = [
            ClientLink(run, values, each, routed.get(each.name, ()), self.registers) for each in run.cell.modbus if each.role == "client"
        ]
        values.register(RegisterValues(self.registers))

    async def start(self) -> None:
        """Inside the loop."""
        for link in self.links:
            link.start()

    def step(self, now: Ns) -> None:
        """At each tick."""
        for link in self.links:
            link.step(now)

    async def close(self) -> None:
        """Release the ports."""
        for link in self.links:
            link.client.close()

    def status(self) -> dict[str, object]:
        """For `links`."""
        return {"modbus_clients": {link.settings.name: link.status() for link in self.links}} if self.links else {}
