"""Contacts on Modbus couplers: coils for outputs, discrete inputs for inputs, one client a link; loaded only where a cell has one."""

from collections.abc import Callable, Sequence

from gateway.assembly.contacts import MODBUS, outputs_of
from gateway.links.modbus.client import Device, Group, Kind, Link, ModbusClient, Result, exception_words, write_bits_pdu
from gateway.pure.buses.contacts import Outputs, Said
from gateway.pure.image.records.cell import RC_BYTES, Quality
from gateway.services.context import RunContext
from gateway.services.modbus_links import LinkReports
from gateway.services.shared_image import SharedImage
from protocols.base.machine import Ns, ms
from protocols.modbus.orders import Done, Failed, Refused

AGAIN: Ns = ms(500)  # interval for repeating unchanged outputs, and pause after a failure
RETRIES, TIMEOUT, PROBE = 1, ms(300), ms(1000)


class ModbusContacts:
    """All couplers of a run; `start` inside the loop, `step` with the cycle."""

    def __init__(self, run: RunContext, image: SharedImage, heard: Callable[[int, Said | None], None]) -> None:
        """`heard`: reported level of a contact; None: its device is silent."""
        cell = run.cell
        self._run, self._image, self._heard = run, image, heard
        self._mine = {n: io for n, io in enumerate(cell.io) if io.device.type == MODBUS}
        self._outputs = Outputs(outputs_of(cell, MODBUS, run.plan.p5_ms), len(cell.axis))
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
            reports = self._reports[url] = LinkReports(self._run.journal, f"Modbus couplers at {link.url}", link)
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
                self._heard(n, None if found is None else Said(bool(found[channel - first]), Quality.GOOD))

        client.poll(Group(f"{url} {unit}", str(unit), Kind.DISCRETE_INPUTS, first, last - first + 1, every), values)

    def show(self, shown: Sequence[Said], now: Ns) -> None:
        """Outputs as the cycle has them; the watchdog moves only when a new cycle was completed."""
        state = self._image.state
        if not self.started:
            return
        for url, client in self._clients.items():
            self._reports[url].step(client, now)
        if not state.generation:
            return
        outputs = self._image.outputs.read() or bytes(RC_BYTES)
        for n, value in self._outputs.show(state, outputs, shown).items():
            fresh = value != self._wanted.get(n)
            if fresh or now >= self._due.get(n, 0):
                self._wanted[n], self._due[n] = value, now + AGAIN
                self._write(n, value)

    def _write(self, n: int, value: bool) -> None:
        device = self._mine[n].device
        assert device.output is not None

        def result(found: Result) -> None:
            good = isinstance(found, Done)
            self._heard(n, Said(value, Quality.GOOD if good else Quality.BAD))
            if not isinstance(found, Failed):
                words = exception_words(found.code) if isinstance(found, Refused) else ""
                self._reports[device.url].written(str(device.unit), f"{self._mine[n].name} to coil {device.output}", words)

        self._clients[device.url].order(str(device.unit), write_bits_pdu(device.output, [value]), result)
