"""Contacts in the services: outputs of data that only the services have, inputs to signals and routes (AX-400, AX-402).

An input drives its signal while it is good; a bad one reads `on_loss`, or 0.  Outputs may be forced by `axisgate io test` while no drive is
on, for as long as it repeats its request, and never the watchdog.
"""

from collections.abc import Callable, Iterable, Mapping

from gateway.assembly.contacts import CHIP, COUPLER, MODBUS, outputs_of, signal_bit
from gateway.assembly.routes import symbols_of
from gateway.pure.buses.contacts import SAID_LAYOUT, WATCHDOG, Said, pack_said, unpack_said
from gateway.pure.buses.contacts import Source as Known
from gateway.pure.image.records.cell import AxisFlag, Quality
from gateway.runtime.regions import RegionReader, RegionWriter
from gateway.services.context import RunContext
from gateway.services.part import Part
from gateway.services.shared_image import SharedImage
from gateway.services.value_directory import Reader, ValueDirectory
from protocols.base.machine import Ns, ms
from protocols.telegrams.fields import Value

LONGEST_FORCE: Ns = ms(60_000)
REPORT_EVERY: Ns = ms(1000)


class DigitalContacts(Part):
    """All contacts of a run, by their place among the [[io]] tables.  `listen` and `show` are called by the routes, once per cycle."""

    def __init__(
        self, run: RunContext, image: SharedImage, values: ValueDirectory, coupler_fault: Callable[[str, int], str], fds: Mapping[str, int]
    ) -> None:
        """`coupler_fault`: fault of a node of a bus, in words; empty: none."""
        cell = run.cell
        self._run, self._image, self._values, self._coupler_fault, self.contacts = run, image, values, coupler_fault, cell.io
        self.by_name = {io.name: n for n, io in enumerate(cell.io)}
        self.said = [Said()] * len(cell.io)  # inputs as received; outputs as confirmed by their device
        self.shown = [Said()] * len(cell.io)  # our values of outputs
        self._routed: dict[int, bool] = {}
        self._forced: dict[int, tuple[bool, Ns]] = {}
        self._ours = {o.number for kind in (COUPLER, MODBUS, CHIP) for o in outputs_of(cell, kind, 1) if o.source is Known.SERVICES}
        self._reported: dict[int, Ns] = {}
        self._before: dict[int, bool] = {}
        symbols = symbols_of(cell) if cell.io else {}
        self._bits = {n: bit for n, io in enumerate(cell.io) if (bit := signal_bit(cell, io, symbols)) is not None}  # RC inputs they drive
        self._regions = [
            (kind, RegionReader(fds[name], name, SAID_LAYOUT)) for kind, name in ((COUPLER, "io_in"), (CHIP, "io_chip")) if name in fds
        ]
        self._out = RegionWriter(fds["io_out"], "io_out", SAID_LAYOUT) if "io_out" in fds else None
        self._written = b""
        self._payloads: dict[str, tuple[bytes, list[Said]]] = {}
        self.modbus = None
        if any(io.device.type == MODBUS for io in cell.io):
            from gateway.services.contacts_modbus import ModbusContacts  # only if a cell needs it

            self.modbus = ModbusContacts(run, image, self._heard_of)

        values.register(ContactValues(self))

    def _heard_of(self, n: int, said: Said | None) -> None:
        """A Modbus coupler: contact n; None: it is silent, the value stays."""
        self.said[n] = self.said[n]._replace(quality=Quality.BAD) if said is None else said

    # ---- routes ------------------------------------------------------------------------------------------------------
    def read(self, name: str) -> float | None:
        """An input; None: it is not valid."""
        said = self.said[self.by_name[name]]
        return float(said.value) if said.quality is Quality.GOOD else None

    def write(self, name: str, value: bool) -> None:
        """An output a route drives."""
        self._routed[self.by_name[name]] = value

    # ---- once per cycle and tick --------------------------------------------------------------------------------------
    async def start(self) -> None:
        """Inside the running loop."""
        if self.modbus is not None:
            self.modbus.start()

    async def close(self) -> None:
        if self.modbus is not None:
            self.modbus.close()

    def listen(self, now: Ns) -> None:
        """Inputs to their signals."""
        for kind, region in self._regions:
            payload = region.read()
            if payload is None:
                continue
            heard = self._heard(kind, payload)
            fresh = kind != CHIP or now - region.life[1] < ms(1000)  # the chips' process may be gone
            for n, io in enumerate(self.contacts):
                if io.device.type == kind:
                    self.said[n] = heard[n] if fresh else heard[n]._replace(quality=Quality.BAD)
        self._drive(now)

    def _heard(self, kind: str, payload: bytes) -> list[Said]:
        """Unpacked only when it is another payload than before."""
        before = self._payloads.get(kind)
        if before is None or before[0] is not payload:
            before = self._payloads[kind] = (payload, unpack_said(payload))
        return before[1]

    def show(self, now: Ns) -> None:
        """Outputs to the processes that drive them."""
        self._publish(now)
        if self.modbus is not None:
            self.modbus.show(self.shown, now)

    def _drive(self, now: Ns) -> None:
        image = self._image
        for n, bit in self._bits.items():
            said = self.said[n]
            value = said.value if said.quality is Quality.GOOD else bool(self.contacts[n].on_loss)
            image.put_bit(bit, value)
            if image.inputs.quality[bit >> 3] != Quality.GOOD:
                image.judge((bit >> 3,), Quality.GOOD, now)
        for n, io in enumerate(self.contacts):
            if io.device.input is not None and self.said[n].quality is Quality.GOOD:
                self._note(n, self.said[n].value, now)

    def _note(self, n: int, value: bool, now: Ns) -> None:
        """First-out: the input that reports first is first in the journal; a chattering one is reported once a second."""
        before = self._before.get(n)
        self._before[n] = value
        if before not in (None, value) and now - self._reported.get(n, -REPORT_EVERY) >= REPORT_EVERY:
            self._reported[n] = now
            name = self.contacts[n].name
            self._run.journal.write("contact", f"contact {name}: {int(before or 0)} -> {int(value)}", contact=name, value=int(value))

    def _publish(self, now: Ns) -> None:
        state = self._image.state
        if any(axis.flags & AxisFlag.ENABLED for axis in state.axes):
            self._forced.clear()
        for n, (_, until) in list(self._forced.items()):
            if now >= until:
                del self._forced[n]
        for n in {*self._ours, *self._forced, *(n for n, said in enumerate(self.shown) if said.forced)}:
            self.shown[n] = self._say(n)
        octets = pack_said(self.shown)
        if self._out is not None and octets != self._written:
            self._written = octets
            self._out.write(octets, now)

    def _say(self, n: int) -> Said:
        if n in self._forced:
            return Said(self._forced[n][0], Quality.GOOD, forced=True)
        if n not in self._ours:
            return Said()
        signal = self.contacts[n].signal
        if signal == f"io.{self.contacts[n].name}":
            return Said(self._routed[n], Quality.GOOD) if n in self._routed else Said()
        named = self._values.named
        if signal in named:
            sample = named.sample(signal)
            return Said(bool(sample.value), sample.quality)
        return Said(bool(self._values.number(signal)), Quality.GOOD)

    def values(self) -> dict[str, list[int]]:
        """Name -> value, quality, whether forced; for an output the confirmed value of its device."""
        return {io.name: [int(self.said[n].value), int(self.said[n].quality), int(n in self._forced)] for n, io in enumerate(self.contacts)}

    # ---- tools -------------------------------------------------------------------------------------------------------
    def rows(self) -> list[dict[str, object]]:
        """Present state of every contact, for `io test` and the page."""
        return [
            {
                "name": io.name,
                "device": io.device.type,
                "way": "input" if io.device.input is not None else "output",
                "channel": io.device.input if io.device.input is not None else io.device.output,
                "signal": io.signal,
                "value": int(self.said[n].value),
                "quality": self.said[n].quality.name,
                "forced": n in self._forced,
                "why": self._why(n),
            }
            for n, io in enumerate(self.contacts)
        ]

    def _why(self, n: int) -> str:
        """Reason why a contact is not good: its coupler's fault, by object; empty: nothing known."""
        device = self.contacts[n].device
        if device.type != COUPLER or device.node is None or self.said[n].quality is Quality.GOOD:
            return ""
        return self._coupler_fault(device.bus, device.node)

    def faults(self) -> list[str]:
        """One sentence for each coupler that is not served completely, with the contacts that are not good."""
        found: dict[str, list[str]] = {}
        for n, io in enumerate(self.contacts):
            if why := self._why(n):
                found.setdefault(f"{io.device.bus} node {io.device.node}: {why}", []).append(io.name)
        return [f"{why} (contacts: {', '.join(names)})" for why, names in found.items()]

    def force(self, name: str, value: bool | None, seconds: float) -> str:
        """None: released.  Returns "" or the reason of a refusal."""
        n = self.by_name.get(name)
        if n is None:
            return f"{name}: no such contact; there is {', '.join(self.by_name) or 'none'}"
        if self.contacts[n].device.output is None:
            return f"{name} is an input"
        if self.contacts[n].signal == WATCHDOG:
            return f"{name} is the watchdog: it toggles from completed cycles and is never forced"
        if value is not None and any(axis.flags & AxisFlag.ENABLED for axis in self._image.state.axes):
            return f"{name}: drives are on; contacts are tried with all drives off"
        if value is None:
            self._forced.pop(n, None)
        else:
            self._forced[n] = (value, self._run.clock() + min(LONGEST_FORCE, int(seconds * 1e9)))
        self.show(self._run.clock())
        return ""

    def answer(self, request: dict[str, object]) -> dict[str, object]:
        """`contacts`, or `force` NAME VALUE (null: free) SECONDS."""
        if request.get("op") == "contacts":
            return {"contacts": self.rows()}
        value = request.get("value")
        refused = self.force(str(request.get("name")), None if value is None else bool(value), float(str(request.get("seconds", 10))))
        return {"error": refused} if refused else {"contacts": self.rows()}


class ContactValues:
    """Provider of io.NAME: inputs as they were received, outputs as their device confirms them; outputs routes drive can be written."""

    def __init__(self, contacts: DigitalContacts) -> None:
        self._contacts = contacts

    def _number(self, name: str) -> int:
        head, _, rest = name.partition(".")
        if head != "io":
            raise KeyError(name)
        return self._contacts.by_name[rest]

    def names(self) -> Iterable[str]:
        return [f"io.{name}" for name in self._contacts.by_name]

    def read(self, name: str, reader: Reader | None) -> Value:
        return int(self._contacts.said[self._number(name)].value)

    def valid(self, name: str) -> bool:
        return self._contacts.said[self._number(name)].quality is Quality.GOOD

    def write(self, name: str, value: Value, now: Ns, by: str) -> None:
        io = self._contacts.contacts[self._number(name)]
        if io.device.output is None or io.signal != name:
            raise KeyError(f"{name}: an input, or an output with a signal of its own")
        self._contacts.write(io.name, bool(value))
