"""The bridge: routes of the cell played by the services, once per cycle and at once when a command source has written.

The cycle signals through an event descriptor that it has published (AX-398), so nothing here polls; the services' own tick steps the routes
as well, or a dead cycle would keep a lost source unnoticed.
"""

import asyncio
import os
from collections.abc import Callable, Mapping
from functools import partial

from gateway.assembly.contact_regions import MARKS_LAYOUT
from gateway.assembly.routes import Compiled, compile_routes, register_key
from gateway.pure.arbitration.data_blocks import DataBlock
from gateway.pure.image.records.cell import Quality
from gateway.pure.routes.addresses import Place, World, number_at, octets_of, put_at
from gateway.pure.routes.route import RouteTable
from gateway.runtime.regions import RegionReader
from gateway.services.contacts import DigitalContacts
from gateway.services.context import RunContext
from gateway.services.part import Part
from gateway.services.shared_image import SharedImage
from gateway.services.value_directory import ValueDirectory
from protocols.base.machine import Ns

Read = Callable[[], float | None]
Write = Callable[[float], None]
ToDrive = Callable[[str, tuple[int, int], bytes], None]  # axis, object, octets


class Bridge(Part):
    """All routes of one run."""

    def __init__(
        self,
        run: RunContext,
        image: SharedImage,
        values: ValueDirectory,
        contacts: DigitalContacts,
        to_drive: ToDrive,
        fds: Mapping[str, int],
        on_cycle: Callable[[], None],
    ) -> None:
        """`to_drive`: writes an object of a drive; `fds`: without "wake", the cycle's event descriptor, the cell has nothing to join;
        `on_cycle`: the cycle has published."""
        self._clock, self._image, self._values, self._contacts, self._to_drive = run.clock, image, values, contacts, to_drive
        self._wake, self._on_cycle, self._stepping = fds.get("wake"), on_cycle, False
        self._marks = RegionReader(fds["marks"], "marks", MARKS_LAYOUT) if "marks" in fds else None
        compiled = compile_routes(run.cell)
        self.table = RouteTable([each.settings for each in compiled])
        self._sources = [self._reader(each.source) for each in compiled]
        self._targets = [self._writer(each.target, each.settings.name) for each in compiled]
        self._valid = [self._writer(each.valid, "") if each.valid else None for each in compiled]
        self._life = [self._writer(each.life, "") if each.life else None for each in compiled]
        self._octets = _octets(compiled)
        self._names = [each.target.name if each.target.world is World.NAME else "" for each in compiled]

    async def start(self) -> None:
        """Wake with the cycle from now on."""
        if self._wake is not None:
            asyncio.get_running_loop().add_reader(self._wake, self._woken)

    def _woken(self) -> None:
        assert self._wake is not None
        try:
            os.eventfd_read(self._wake)
        except BlockingIOError:  # a predecessor's wake-up, already read
            return
        self._on_cycle()

    def step(self, now: Ns) -> None:
        """Inputs in, routes, outputs out; nothing in a cell that joins nothing."""
        contacts = self._contacts
        if self._stepping or not (self.table.routes or contacts.contacts):
            return
        self._stepping = True  # a telegram may call back here
        try:
            contacts.listen(now)
            self._pass_on(now)
            contacts.show(now)
        finally:
            self._stepping = False

    def _pass_on(self, now: Ns) -> None:
        """Sources in, changed targets out."""
        routes = self.table.routes
        changed = self.table.step(now, [read() for read in self._sources])
        for n in changed:
            route = routes[n]
            if route.value is not None:
                self._targets[n](route.value)
            valid = self._valid[n]
            if valid is not None:
                valid(float(route.valid))
            if self._names[n] and not route.valid:
                self._values.named.source_gone(f"route.{route.settings.name}")
        for n, life in enumerate(self._life):
            if life is not None:
                life(float(routes[n].life))
        if changed:
            self._mark(now)

    def _mark(self, now: Ns) -> None:
        """An RC input byte is good while every route that writes into it is valid; otherwise it is marked stale."""
        for octet, writers in self._octets.items():
            good = all(self.table.routes[n].valid for n in writers)
            self._image.judge((octet,), Quality.GOOD if good else Quality.STALE, now)

    def status(self) -> dict[str, object]:
        """For `links`; nothing for a cell without routes."""
        routes = self.table.routes
        lost = [route.settings.name for route in routes if not route.valid]
        return {"routes": {"count": len(routes), "lost": lost[:8], "misfits": sum(route.misfits for route in routes)}} if routes else {}

    def facts_of(self, name: str) -> dict[str, object] | None:
        """`io.NAME` and `route.NAME` for tools; None: it is neither."""
        kind, _, rest = name.partition(".")
        contacts = self._contacts
        if kind == "io" and rest in contacts.by_name:
            said = contacts.said[contacts.by_name[rest]]
            return {"value": int(said.value), "quality": said.quality.name}
        route = next((route for route in self.table.routes if kind == "route" and route.settings.name == rest), None)
        if route is None:
            return None
        value = "never written" if route.value is None else route.value
        return {"value": value, "valid": route.valid, "life": route.life, "misfits": route.misfits}

    # ---- sources of values
    def _reader(self, place: Place) -> Read:
        match place.world:
            case World.BLOCK:
                return self._from_block(place, self._block(place))
            case World.RC_INPUT:
                return self._from_inputs(place)
            case World.RC_OUTPUT:
                return self._from_outputs(place)
            case World.CONTACT:
                return partial(self._values.current, f"io.{place.name}")
            case World.REGISTER:
                return partial(self._values.current, register_key(place, reads=True))
        return partial(self._values.current, place.name)

    def _block(self, place: Place) -> DataBlock:
        line = next(line for line in self._values.lines if line.name == place.name)
        assert line.data is not None  # it has a [[db]], or the cell's checks had refused the place
        return line.data.blocks[place.db]

    def _from_block(self, place: Place, block: DataBlock) -> Read:
        return lambda: number_at(place, block.data) if block.fresh else None

    def _from_inputs(self, place: Place) -> Read:
        inputs, octets = self._image.inputs, range(place.byte, place.byte + place.size)

        def read() -> float | None:
            if any(inputs.quality[octet] != Quality.GOOD for octet in octets):
                return None
            return number_at(place, inputs.values)

        return read

    def _from_outputs(self, place: Place) -> Read:
        octets = slice(place.byte, place.byte + place.size)

        def read() -> float | None:
            outputs = self._image.outputs.read()
            marks = self._marks.read() if self._marks is not None else None
            if outputs is None or marks is None or not self._image.cycle_lives():
                return None
            return number_at(place, outputs) if all(mark == Quality.GOOD for mark in marks[octets]) else None

        return read

    # ---- where values go ---------------------------------------------------------------------------------------------
    def _writer(self, place: Place, route: str) -> Write:
        match place.world:
            case World.BLOCK:
                block = self._block(place)
                return lambda value: put_at(place, block.data, value)
            case World.RC_INPUT:
                return lambda value: self._image.put_number(place, value)
            case World.CONTACT:
                return partial(self._to_name, f"io.{place.name}", f"route.{route}")
            case World.REGISTER:
                return partial(self._to_name, register_key(place, reads=False), f"route.{route}")
            case World.PARAMETER:
                return lambda value: self._to_drive(place.name, (place.db, place.byte), octets_of(place, value))
        return partial(self._to_name, place.name, f"route.{route}")

    def _to_name(self, name: str, by: str, value: float) -> None:
        self._values.write(name, value, self._clock(), by)


def _octets(compiled: list[Compiled]) -> dict[int, list[int]]:
    """RC input byte -> routes that write into it."""
    found: dict[int, list[int]] = {}
    for n, each in enumerate(compiled):
        if each.target.world is World.RC_INPUT:
            for octet in range(each.target.byte, each.target.byte + each.target.size):
                found.setdefault(octet, []).append(n)
        for mark in (each.valid, each.life):
            if mark is not None and mark.world is World.RC_INPUT:
                for octet in range(mark.byte, mark.byte + mark.size):
                    found.setdefault(octet, [])  # a mark itself is always right
    return found
