"""The command source of a Modbus server: RC signals by their bit numbers, the own command block (AX-012), registers of the cell file.

Over TCP, over TLS, RTU in a TCP stream, RTU on a serial port: the command source is the same, only the transport differs.
"""

import asyncio
import ipaddress
import pathlib
import struct
import time
from collections.abc import Collection, Sequence

from gateway.links.modbus.rtu_server import ModbusLine
from gateway.links.modbus.tcp_server import Limits, ModbusServer
from gateway.pure.cell.modbus import Modbus, ModbusRole
from gateway.pure.controllers.control import Control
from gateway.pure.image.records.cell import Quality
from gateway.pure.modbus.other_views import ReisView, Val3View
from gateway.pure.modbus.registers import Placed, Registers, RegistersView, place
from gateway.pure.modbus.rho3_view import BlockFiles, RhoView
from gateway.pure.recording.messages import Source
from gateway.registry import MODBUS_VIEWS
from gateway.services.sources.base import BaseSource, SourceContext, WriteJournal
from protocols.base.machine import Ns, ms
from protocols.modbus.rights import Rights, Span
from protocols.modbus.station import Identity
from protocols.modbus.view import View

REFUSAL_EVERY, MOST_REFUSED = ms(60_000), 256  # of one address in the journal; addresses kept
QUICK = 40  # attempts to listen, 50 ms apart; then it is reported and tried every second
WRITES = (5, 6, 15, 16, 21, 22, 23)
Bind = tuple[str, int] | str  # host and port, or the url of a serial port


def placed(settings: Modbus, axes: Sequence[str]) -> list[Placed]:
    """[[modbus.registers]] one value after another."""
    return [each for table in settings.registers for each in place(table.at, table.from_, table.type, axes)]


class ModbusSource(BaseSource):
    """One Modbus server."""

    medium = "modbus"
    view: RhoView
    server: ModbusServer | ModbusLine
    other_views: tuple[ReisView | Val3View, ...] = ()  # units that show another control's
    writers: "WriterRights | None" = None  # [[modbus.writers]]
    _writer = ""  # host:port of the client that wrote last

    def __init__(self, context: SourceContext) -> None:
        super().__init__(context)
        self._written_files = tuple(block.number for block in context.run.cell.db if block.writer == self.name)
        self._late: asyncio.Task[None] | None = None  # waits for its address, port or adapter

    def listen(self, settings: Modbus) -> None:
        """Make views and server; not started yet."""
        run, image, values = self._run, self._image, self._values
        axes = [axis.name for axis in run.cell.axis]
        owned = [octet for octet, owner in run.cell.rc_inputs.owner.items() if owner == self.name]
        extras = placed(settings, axes)
        registers = Registers(extras, self._value, settings.float) if extras else None
        taken = self._command_words if settings.command_block else None
        self.view = RhoView(
            image.inputs,
            owned,
            self._inputs_written,
            taken,
            registers,
            lambda: [code for code, _ in self._errors()],
            BlockFiles(values.filled_block, self._written_files, self._file_written),
        )
        self.view.command_words = self.block.words
        values.views.append(self.view)
        bare = RegistersView(Registers(extras, self._value, settings.float))
        shown: dict[str, View] = {"rho3": self.view, "registers": bare}
        asked = {settings.view, *(unit.view for unit in settings.units)}
        controller = run.cell.controller
        if any(MODBUS_VIEWS[view].controller for view in asked) and controller is not None:  # the cell's checks have seen to its kind
            from gateway.assembly.modbus_views import view_of

            shown[controller.kind] = made = view_of(controller, image.inputs, owned, self._inputs_written, registers, settings.float)
            self.other_views = (made,)
        views = {unit.unit: shown[unit.view] for unit in settings.units}
        views[settings.unit] = shown[settings.view]
        bind = run.plan.modbus[self.name]
        folder = pathlib.Path(run.cell.file).resolve().parent  # certificates are searched next to it
        self.server = self._line(settings, bind, views) if isinstance(bind, str) else self._tcp(settings, bind, views, folder)

    # ---- writes and reads of clients
    def _value(self, name: str) -> float:
        return self._values.number(name, self)

    def _errors(self) -> Sequence[tuple[int, str]]:
        return self._values.errors

    def _inputs_written(self, octets: Collection[int]) -> None:
        now, values = self._run.clock(), self._image.inputs.values
        pairs = bytes(each for octet in octets for each in (octet, values[octet]))
        self._run.recorder.put(now, Source.WRITTEN, self.number, pairs)
        self._image.judge(octets, Quality.GOOD, now)
        self._image.pass_on()  # routes and the cycle have it now, not with the next tick

    def _command_words(self, first: int, values: Sequence[int]) -> None:
        now = self._run.clock()
        self._run.recorder.put(now, Source.COMMAND, self.number, struct.pack(f"<{len(values) + 1}H", first, *values))
        self.write_words(first, values, now)
        self.view.status = self.block.status_words(self.block_status)  # the answer to the next read is fresh without waiting for a tick
        self._image.pass_on()

    def _file_written(self, number: int, word: int, data: bytes) -> None:
        block = self._values.data_block(number)
        if block is not None:
            block.data[2 * word : 2 * word + len(data)] = data
            block.fresh = True
        self._image.pass_on()

    # ---- life --------------------------------------------------------------------------------------------------------
    async def start(self) -> None:
        """Listens; while its address, port or adapter is missing it is tried again."""
        if await self._try():
            self._late = asyncio.create_task(self._start_late())

    async def _try(self) -> str:
        """Empty: it listens; else why it does not."""
        try:
            await self.server.start()
        except OSError as error:  # a predecessor's port still in use, an address or adapter that is not there yet
            return str(error)
        return ""

    async def _start_late(self) -> None:
        """Quickly at first, then every second; reported once, and when it is over."""
        attempts = 0
        while words := await self._try():
            attempts += 1
            if attempts == QUICK:
                self._journal("alarm", f"{words}; it is tried again every second", source=self.name)
            await asyncio.sleep(0.05 if attempts < QUICK else 1.0)
        if attempts >= QUICK:
            self._journal("link", f"Modbus server {self.name} listens now", source=self.name)

    async def close(self) -> None:
        if self._late is not None:
            self._late.cancel()
        await self.server.close()

    def counters(self) -> dict[str, object]:
        return {"requests": self.server.counters.requests}

    def passed(self, number: int) -> list[list[object]] | None:
        """Exchanges of the server."""
        return [exchange.row() for exchange in self.server.responder.since(number)]

    def join(self, control: Control) -> None:
        """Flags or markers for its views."""
        self.view.flags = control
        for shown in self.other_views:
            from gateway.assembly.modbus_views import join

            join(shown, control)

    def restart(self) -> None:
        """Values written before are old."""
        super().restart()
        for number in self._written_files:
            block = self._values.data_block(number)
            if block is not None:
                block.fresh = False

    def show(self, outputs: bytes | None) -> None:
        """Image for the next requests; None: RC outputs have not been published yet."""
        self.view.status = self.block.status_words(self.block_status)
        if outputs is not None:
            self.view.outputs = outputs
            for shown in self.other_views:
                shown.image.outputs = outputs

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
            allow=settings.allow or None,
        )
        server = ModbusServer(
            views.get,
            *bind,
            unit=settings.unit,
            limits=limits,
            on_request=self._answered,
            rtu=settings.framing == "rtu",
            identity=identity(settings),
        )
        if settings.tls is not None:
            from gateway.links.modbus.tls import TlsRights, server_context  # cryptography only if a cell needs it

            server.tls = server_context(settings.tls, folder)
            server.on_refused = Refusals(settings.name, self._journal).heard
            server.rights_for = TlsRights({role.role: role_rights(role) for role in settings.roles})
        elif settings.writers:
            server.rights_for = self.writers = WriterRights(settings)
        return server

    def _answered(self, address: str, function: int) -> None:
        """Life of this command source: requests of the client that writes; before the first write, of any client (AX-148)."""
        if function in WRITES:
            self._writer = address
        if self._writer in ("", address):
            self.heard(self._run.clock())


class Refusals:
    """Partners whose TLS handshake fails: each address once a minute in the journal, with the number of failures."""

    def __init__(self, name: str, journal: WriteJournal) -> None:
        self._name, self._journal = name, journal
        self._refused: dict[str, tuple[Ns, int]] = {}

    def heard(self, address: str, why: str) -> None:
        now = time.monotonic_ns()
        last, more = self._refused.get(address, (-REFUSAL_EVERY, 0))
        if now - last < REFUSAL_EVERY:
            self._refused[address] = last, more + 1
            return
        if len(self._refused) >= MOST_REFUSED:
            self._refused.clear()
        self._refused[address] = now, 0
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
