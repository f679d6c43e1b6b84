"""The command source of a Modbus server: RC signals by their bit numbers, the own command block (AX-012), registers of the cell file.

Over TCP, over TLS, RTU in a TCP stream, RTU on a serial port: the command source is the same, only what carries the bytes differs.
"""

import asyncio
import ipaddress
import pathlib
import struct
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gateway.links.modbus.rtu_server import ModbusLine
from gateway.links.modbus.tcp_server import Limits, ModbusServer
from gateway.pure.cell.controller import Controller
from gateway.pure.cell.modbus import Modbus, ModbusRole
from gateway.pure.image.records.cell import InputImage, Quality
from gateway.pure.modbus.registers import Placed, Registers, RegistersView, place
from gateway.pure.modbus.rho3_view import RhoView
from gateway.pure.recording.messages import Source
from gateway.services.recording_tap import ServicesTap
from gateway.services.sources.base import BaseSource, Tell
from protocols.base.machine import Ns, ms
from protocols.modbus.rights import Rights, Span
from protocols.modbus.station import Identity
from protocols.modbus.view import View

if TYPE_CHECKING:
    from gateway.assembly.modbus_views import ReisView, Val3View
    from gateway.pure.arbitration.data_blocks import DataBlock, DataBlocks
    from gateway.services.loop import Services
    from gateway.services.modbus_clients import ModbusClients

REFUSAL_EVERY, MOST_REFUSED = ms(60_000), 256  # of one address in the journal; addresses kept
WRITES = (5, 6, 15, 16, 21, 22, 23)
Bind = tuple[str, int] | str  # host and port, or the url of a serial port


@dataclass(frozen=True, slots=True)
class CellSide:
    """What the rest of the services gives a command source."""

    inputs: InputImage
    owned: Collection[int]
    flush: Callable[[], None]
    value: Callable[[str], float]
    block: Callable[[int], bytes | None]
    files: "Callable[[int], DataBlock | None]"  # data blocks this command source writes, once all command sources are made
    written_files: Collection[int]  # and their numbers (AX-479)
    errors: Callable[[], Sequence[int]]
    recorded: ServicesTap
    axes: Sequence[str]
    controller: Controller | None
    folder: pathlib.Path  # beside which certificates are looked for


def side_of(services: "Services", door: "ModbusSource", owned: Collection[int]) -> CellSide:
    """The services as a command source sees them."""

    def block(number: int) -> bytes | None:
        return next((bytes(data.fill(number)) for data in _data(services) if number in data.blocks), None)

    return CellSide(
        services.inputs,
        owned,
        services.flush,
        lambda name: services.variables.value_of(name, door),
        block,
        lambda number: next((data.blocks[number] for data in _data(services) if number in data.blocks), None),
        tuple(block.number for block in services.cell.db if block.writer == door.name),
        lambda: [code for code, _ in services.values.errors],
        services.recorded,
        [axis.name for axis in services.cell.axis],
        services.cell.controller,
        pathlib.Path(services.cell.file).resolve().parent,
    )


def _data(services: "Services") -> "list[DataBlocks]":
    """Of all lines."""
    return [data for door in services.doors if (data := getattr(door, "data", None)) is not None]


def modbus_clients(services: "Services") -> "ModbusClients | None":
    """The clients of a cell that has some."""
    if not any(modbus.role == "client" for modbus in services.cell.modbus):
        return None
    from gateway.services.modbus_clients import ModbusClients

    return ModbusClients(services)


def placed(settings: Modbus, axes: Sequence[str]) -> list[Placed]:
    """[[modbus.registers]] one value after another."""
    return [each for table in settings.registers for each in place(table.at, table.from_, table.type, axes)]


class ModbusSource(BaseSource):
    """One Modbus server."""

    view: RhoView
    server: ModbusServer | ModbusLine
    pictures: "tuple[ReisView | Val3View, ...]" = ()  # units that show another control's
    writers: "WriterRights | None" = None  # [[modbus.writers]]
    _writer = ""  # host:port of the client that wrote last
    _mine: "Callable[[], list[DataBlock]]" = list  # data blocks this server's clients write

    def listen(self, settings: Modbus, bind: Bind, side: CellSide) -> None:
        """Make views and server; not started yet."""
        inputs, flush = side.inputs, side.flush

        def written(octets: Collection[int]) -> None:
            now = time.monotonic_ns()
            pairs = bytes(each for octet in octets for each in (octet, inputs.values[octet]))
            side.recorded.put(now, Source.WRITTEN, self.number, pairs)
            for octet in octets:
                inputs.quality[octet], inputs.stamps[octet] = Quality.GOOD, now
            flush()  # routes and the cycle have it now, not with the next tick

        def command(first: int, values: Sequence[int]) -> None:
            now = time.monotonic_ns()
            side.recorded.put(now, Source.COMMAND, self.number, struct.pack(f"<{len(values) + 1}H", first, *values))
            self.write_words(first, values, now)
            self.view.status = self.block.status_words(self.status)  # the answer to the next read is fresh without waiting for a tick
            flush()

        extras = placed(settings, side.axes)
        registers = Registers(extras, side.value, settings.float) if extras else None
        taken = command if settings.command_block else None
        self._mine = lambda: [block for number in side.written_files if (block := side.files(number)) is not None]

        def file_written(number: int, word: int, data: bytes) -> None:
            block = side.files(number)
            if block is not None:
                block.data[2 * word : 2 * word + len(data)] = data
                block.fresh = True
            flush()

        self.view = RhoView(inputs, side.owned, written, taken, registers, side.block, side.errors, side.written_files, file_written)
        self.view.command_words = self.block.words
        bare = RegistersView(Registers(extras, side.value, settings.float))
        shown: dict[str, View] = {"rho3": self.view, "registers": bare}
        asked = {settings.view, *(unit.view for unit in settings.units)}
        if asked & {"reis", "val3"} and side.controller is not None:  # the cell's checks have seen to its kind
            from gateway.assembly.modbus_views import picture

            shown[side.controller.kind] = made = picture(side.controller, inputs, side.owned, written, registers, settings.float)
            self.pictures = (made,)
        views = {unit.unit: shown[unit.view] for unit in settings.units}
        views[settings.unit] = shown[settings.view]
        self.server = self._line(settings, bind, views) if isinstance(bind, str) else self._tcp(settings, bind, views, side.folder)

    def restart(self) -> None:
        """What was written before is old."""
        super().restart()
        for block in self._mine():
            block.fresh = False

    def show(self, outputs: bytes | None) -> None:
        """What the next requests read; None: RC outputs have not been published yet."""
        self.view.status = self.block.status_words(self.status)
        if outputs is not None:
            self.view.outputs = outputs
            for picture in self.pictures:
                picture.image.outputs = outputs

    def _line(self, settings: Modbus, url: str, views: dict[int, View]) -> ModbusLine:
        from drivers.ports.open import open_bytes
        from protocols.modbus.timing import timing

        silences = timing(int(settings.format.split()[0]), patience=ms(settings.patience_ms))
        return ModbusLine(
            lambda: open_bytes(url, settings.format),
            silences,
            views.get,
            unit=settings.unit,
            name=settings.name,
            on_request=self._answered,
            identity=identity(settings),
        )

    def _tcp(self, settings: Modbus, bind: tuple[str, int], views: dict[int, View], folder: pathlib.Path) -> ModbusServer:
        limits = Limits(
            clients=settings.limits.clients,
            per_address=settings.limits.per_address,
            receive_limit_ns=ms(settings.limits.receive_ms),
            stall_limit_ns=ms(settings.limits.stall_ms),
            idle_limit_ns=ms(settings.limits.idle_ms) or None,
        )
        server = ModbusServer(
            views.get,
            *bind,
            unit=settings.unit,
            allow=settings.allow or None,
            limits=limits,
            on_request=self._answered,
            rtu=settings.framing == "rtu",
            identity=identity(settings),
        )
        if settings.tls is not None:
            from gateway.links.modbus.tls import TlsRights, server_context  # cryptography only where a cell asks for it

            server.tls = server_context(settings.tls, folder)
            server.on_refused = Refusals(settings.name, self._tell).heard
            server.rights_for = TlsRights({role.role: role_rights(role) for role in settings.roles})
        elif settings.writers:
            server.rights_for = self.writers = WriterRights(settings)
        return server

    def _answered(self, address: str, function: int) -> None:
        """Life of this command source: requests of the client that writes; until somebody has written, of any (AX-148)."""
        if function in WRITES:
            self._writer = address
        if self._writer in ("", address):
            self.heard(time.monotonic_ns())


class Refusals:
    """Partners whose TLS handshake fails: each address once a minute in the journal, with how often meanwhile."""

    def __init__(self, name: str, journal: Tell) -> None:
        self._name, self._journal = name, journal
        self._told: dict[str, tuple[Ns, int]] = {}

    def heard(self, address: str, why: str) -> None:
        now = time.monotonic_ns()
        last, more = self._told.get(address, (-REFUSAL_EVERY, 0))
        if now - last < REFUSAL_EVERY:
            self._told[address] = last, more + 1
            return
        if len(self._told) >= MOST_REFUSED:
            self._told.clear()
        self._told[address] = now, 0
        again = f"; {more} more since the last report" if more else ""
        self._journal("link", f"{self._name}: TLS client {address} is refused: {why}{again}; check its certificate, key and CA")


def identity(settings: Modbus) -> Identity:
    """How a server calls itself (FC 17, FC 43/14)."""
    from importlib.metadata import version

    return Identity(revision=version("axisgate"), model=settings.view, application=settings.name)


class WriterRights:
    """[[modbus.writers]]: who may write where; all others read (AX-343)."""

    def __init__(self, settings: Modbus) -> None:
        self._writers = [
            (
                ipaddress.ip_network(writer.from_, strict=False),
                Rights(coils=spans(writer.coils), holding=spans(writer.holding), files=spans(writer.files)),
            )
            for writer in settings.writers
        ]

    def __call__(self, transport: asyncio.Transport) -> tuple[Rights, str] | None:
        """As for his address."""
        return self.of(str(transport.get_extra_info("peername")[0])), ""

    def of(self, host: str) -> Rights:
        """By the partner's address; the first table that fits decides."""
        partner = ipaddress.ip_address(host.partition("%")[0])
        if isinstance(partner, ipaddress.IPv6Address) and partner.ipv4_mapped is not None:
            partner = partner.ipv4_mapped
        return next((rights for network, rights in self._writers if partner in network), Rights(write=False))


def role_rights(role: ModbusRole) -> Rights:
    """Rights from [[modbus.roles]]; a table left out means all of it."""
    coils = None if role.coils is None else spans(role.coils)
    holding = None if role.holding is None else spans(role.holding)
    return Rights(role.read, role.write, coils, holding, None if role.files is None else spans(role.files))


def spans(texts: Sequence[str]) -> tuple[Span, ...]:
    """ "0..63" or "7"."""
    pairs = [text.partition("..") for text in texts]
    return tuple((int(first), int(last or first)) for first, _, last in pairs)
