"""Contacts on Modbus couplers: coils for outputs, discrete inputs for inputs, one client a link; loaded only where a cell has one."""

from typing import TYPE_CHECKING

from gateway.assembly.contacts import MODBUS, outputs_of
from gateway.links.modbus.client import Device, Group, Kind, Link, ModbusClient, Result, exception_words, write_bits_pdu
from gateway.pure.buses.contacts import Outputs, Said
from gateway.pure.image.records.cell import RC_BYTES, Quality
from gateway.services.modbus_links import LinkReports
from protocols.base.machine import Ns, ms
from protocols.modbus.orders import Done, Failed, Refused

if TYPE_CHECKING:
    from gateway.services.contacts import DigitalContacts
    from gateway.services.loop import Services

AGAIN: Ns = ms(500)  # outputs are written again so often though nothing has changed, and after a failure
RETRIES, TIMEOUT, PROBE = 1, ms(300), ms(1000)


class ModbusContacts:
    """All couplers of a run; `start` inside the loop, `step` with the cycle."""

    def __init__(self, services: "Services", office: "DigitalContacts") -> None:
        cell = services.cell
        self._services, self._office = services, office
        self._mine = {n: io for n, io in enumerate(cell.io) if io.device.type == MODBUS}
        self._outputs = Outputs(outputs_of(cell, MODBUS, services.plan.p5_ms), len(cell.axis))
        self._clients: dict[str, ModbusClient] = {}
        self._reports: dict[str, LinkReports] = {}
        self._wanted: dict[int, bool] = {}
        self._due: dict[int, Ns] = {}
        self.started = False

    def start(self) -> None:
        """One client a link, one device a unit."""
        urls = {io.device.url for io in self._mine.values()}
        for url in sorted(urls):
            units = sorted({io.device.unit for io in self._mine.values() if io.device.url == url})
            devices = [Device(str(unit), unit, TIMEOUT, retries=RETRIES, probe_every=PROBE) for unit in units]
            framing = "tcp" if url.startswith("tcp://") else "rtu"
            link = Link(url.removeprefix("rtu:"), framing)
            reports = self._reports[url] = LinkReports(self._services.journal, f"Modbus couplers at {link.url}", link)
            client = self._clients[url] = ModbusClient(link, devices, reports.device, on_refused=reports.read)
            client.start()
            for unit in units:
                self._poll(client, url, unit)
        self.started = True

    def status(self) -> dict[str, object]:
        """For tools and the page, by url."""
        return {url: self._reports[url].status(client) for url, client in self._clients.items()}

    def close(self) -> None:
        for client in self._clients.values():
            client.close()

    def _poll(self, client: ModbusClient, url: str, unit: int) -> None:
        """Inputs of one device as one group, from the first channel to the last."""
        here = {n: io.device.input for n, io in self._mine.items() if (io.device.url, io.device.unit) == (url, unit)}
        channels = {n: channel for n, channel in here.items() if channel is not None}
        if not channels:
            return
        first, last = min(channels.values()), max(channels.values())
        every = ms(min(self._mine[n].device.poll_ms for n in channels))

        def values(found: tuple[int, ...] | None, now: Ns) -> None:
            for n, channel in channels.items():
                said = Said() if found is None else Said(bool(found[channel - first]), Quality.GOOD)
                self._office.said[n] = self._office.said[n]._replace(quality=Quality.BAD) if found is None else said

        client.poll(Group(f"{url} {unit}", str(unit), Kind.DISCRETE_INPUTS, first, last - first + 1, every), values)

    def step(self, now: Ns) -> None:
        """Outputs as the cycle has them; the watchdog moves only when a new cycle was completed."""
        state = self._services.values.state
        if not self.started:
            return
        for url, client in self._clients.items():
            self._reports[url].step(client, now)
        if not state.generation:
            return
        outputs = self._services.rc_out.read() or bytes(RC_BYTES)
        for n, value in self._outputs.show(state, outputs, self._office.shown).items():
            fresh = value != self._wanted.get(n)
            if fresh or now >= self._due.get(n, 0):
                self._wanted[n], self._due[n] = value, now + AGAIN
                self._write(n, value)

    def _write(self, n: int, value: bool) -> None:
        device = self._mine[n].device
        assert device.output is not None

        def result(found: Result) -> None:
            good = isinstance(found, Done)
            self._office.said[n] = Said(value, Quality.GOOD if good else Quality.BAD)
            if not isinstance(found, Failed):
                words = exception_words(found.code) if isinstance(found, Refused) else ""
                self._reports[device.url].written(str(device.unit), f"{self._office.contacts[n].name} to coil {device.output}", words)

        self._clients[device.url].order(str(device.unit), write_bits_pdu(device.output, [value]), result)
