"""The bridge: routes of the cell played by the services, once per cycle and at once when a command source has written.

The cycle signals through an event descriptor that it has published (AX-398), so nothing here polls; the services' own tick steps the routes
as well, or a dead cycle would keep a lost source unnoticed.
"""

import os
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

from gateway.assembly.contact_regions import MARKS_LAYOUT
from gateway.assembly.routes import Compiled, compile_routes, register_key
from gateway.pure.arbitration.data_blocks import DataBlock
from gateway.pure.image.records.cell import Quality
from gateway.pure.routes.addresses import Place, World, number_at, octets_of, put_at
from gateway.pure.routes.route import RouteTable
from gateway.runtime.regions import RegionReader
from gateway.services.sources.rk512 import Rk512Source
from protocols.base.machine import Ns, ms

if TYPE_CHECKING:
    import asyncio

    from gateway.services.loop import Services

Read = Callable[[], float | None]
Write = Callable[[float], None]
CYCLE_SILENT: Ns = ms(250)  # as the services judge it: what the cycle publishes is old then


class Bridge:
    """All routes of one run."""

    def __init__(self, services: "Services", fds: Mapping[str, int]) -> None:
        """`fds`: without "wake", the cycle's event descriptor, the cell has nothing to join."""
        self._services, self._wake, self._stepping = services, fds.get("wake"), False
        self._marks = RegionReader(fds["marks"], "marks", MARKS_LAYOUT) if "marks" in fds else None
        compiled = compile_routes(services.cell)
        self._controlled = _controlled(services, compiled)
        self.table = RouteTable([each.settings for each in compiled])
        self._sources = [self._reader(each.source) for each in compiled]
        self._targets = [self._writer(each.target, each.settings.name) for each in compiled]
        self._valid = [self._writer(each.valid, "") if each.valid else None for each in compiled]
        self._life = [self._writer(each.life, "") if each.life else None for each in compiled]
        self._octets = _octets(compiled)
        self._names = [each.target.name if each.target.world is World.NAME else "" for each in compiled]

    def start(self, loop: "asyncio.AbstractEventLoop") -> None:
        """Wake with the cycle from now on."""
        if self._wake is not None:
            loop.add_reader(self._wake, self._on_cycle)

    def _on_cycle(self) -> None:
        assert self._wake is not None
        try:
            os.eventfd_read(self._wake)
        except BlockingIOError:  # a predecessor's wake-up, already taken
            return
        self._services.on_cycle()

    def step(self, now: Ns) -> None:
        """Inputs in, routes, outputs out; nothing in a cell that joins nothing."""
        contacts = self._services.contacts
        if self._stepping or not (self.table.routes or contacts.contacts):
            return
        self._stepping = True  # what a telegram sets off may come back here
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
                self._services.named.source_gone(f"route.{route.settings.name}")
        for n, life in enumerate(self._life):
            if life is not None:
                life(float(routes[n].life))
        if changed:
            self._mark(now)

    def _mark(self, now: Ns) -> None:
        """An RC input byte is good while every route that writes into it is valid, else what stands there is marked stale."""
        inputs = self._services.inputs
        for octet, writers in self._octets.items():
            good = all(self.table.routes[n].valid for n in writers)
            inputs.quality[octet], inputs.stamps[octet] = Quality.GOOD if good else Quality.STALE, now

    def status(self) -> dict[str, object]:
        """For `links`; nothing for a cell without routes."""
        routes = self.table.routes
        lost = [route.settings.name for route in routes if not route.valid]
        return {"routes": {"count": len(routes), "lost": lost[:8], "misfits": sum(route.misfits for route in routes)}} if routes else {}

    def told(self, name: str) -> dict[str, object] | None:
        """`io.NAME` and `route.NAME` for tools; None: it is neither."""
        kind, _, rest = name.partition(".")
        contacts = self._services.contacts
        if kind == "io" and rest in contacts.by_name:
            said = contacts.said[contacts.by_name[rest]]
            return {"value": int(said.value), "quality": said.quality.name}
        route = next((route for route in self.table.routes if kind == "route" and route.settings.name == rest), None)
        if route is None:
            return None
        value = "never written" if route.value is None else route.value
        return {"value": value, "valid": route.valid, "life": route.life, "misfits": route.misfits}

    # ---- where values come from --------------------------------------------------------------------------------------
    def _reader(self, place: Place) -> Read:
        match place.world:
            case World.BLOCK:
                return self._from_block(place, self._block(place))
            case World.RC_INPUT:
                return self._from_inputs(place)
            case World.RC_OUTPUT:
                return self._from_outputs(place)
            case World.CONTACT:
                return lambda: self._services.contacts.read(place.name)
            case World.REGISTER:
                return partial(self._from_register, register_key(place, reads=True))
        return self._from_name(place.name)

    def _from_register(self, key: str) -> float | None:
        clients = self._services.clients
        return clients.registers.get(key) if clients is not None else None

    def _block(self, place: Place) -> DataBlock:
        door = next(door for door in self._services.doors if isinstance(door, Rk512Source) and door.name == place.name)
        assert door.data is not None  # it has a [[db]], or the cell's checks had refused the place
        return door.data.blocks[place.db]

    def _from_block(self, place: Place, block: DataBlock) -> Read:
        return lambda: number_at(place, block.data) if block.fresh else None

    def _from_inputs(self, place: Place) -> Read:
        inputs, octets = self._services.inputs, range(place.byte, place.byte + place.size)

        def read() -> float | None:
            if any(inputs.quality[octet] != Quality.GOOD for octet in octets):
                return None
            return number_at(place, inputs.values)

        return read

    def _from_outputs(self, place: Place) -> Read:
        octets = slice(place.byte, place.byte + place.size)

        def read() -> float | None:
            outputs = self._services.rc_out.read()
            marks = self._marks.read() if self._marks is not None else None
            if outputs is None or marks is None or not self._cycle_lives():
                return None
            return number_at(place, outputs) if all(mark == Quality.GOOD for mark in marks[octets]) else None

        return read

    def _cycle_lives(self) -> bool:
        return time.monotonic_ns() - self._services.axes.life[1] < CYCLE_SILENT

    def _from_name(self, name: str) -> Read:
        services = self._services

        def named() -> float | None:
            sample = services.named.sample(name)
            value = sample.value if sample.quality is Quality.GOOD else None
            return float(value) if isinstance(value, int | float) else None

        def own() -> float | None:
            return services.values.get(name) if self._cycle_lives() else None

        def controlled() -> float | None:
            control = services.signals.control
            return control.value(name) if control is not None else None

        if name in self._controlled:
            return controlled
        return named if name in services.named else own

    # ---- where values go ---------------------------------------------------------------------------------------------
    def _writer(self, place: Place, route: str) -> Write:
        services = self._services
        match place.world:
            case World.BLOCK:
                block = self._block(place)
                return lambda value: put_at(place, block.data, value)
            case World.RC_INPUT:
                return lambda value: put_at(place, services.inputs.values, value)
            case World.CONTACT:
                return lambda value: services.contacts.write(place.name, bool(value))
            case World.REGISTER:
                return partial(self._to_register, register_key(place, reads=False))
            case World.PARAMETER:
                return lambda value: services.canopen.parameters.put(place.name, (place.db, place.byte), octets_of(place, value))

        def wired(value: float) -> None:
            control = services.signals.control
            if control is not None:
                control.put(place.name, value)
                services.signals.wired = True

        if place.name in self._controlled:
            return wired

        def name(value: float) -> None:
            services.named.put(place.name, value, time.monotonic_ns(), f"route.{route}")
            services.settle()

        return name

    def _to_register(self, key: str, value: float) -> None:
        clients = self._services.clients
        if clients is not None:
            clients.registers[key] = value


def _controlled(services: "Services", compiled: list[Compiled]) -> frozenset[str]:
    """Values of [controller] that routes read or write; a cell without them loads nothing."""
    ends = {place.name for each in compiled for place in (each.source, each.target) if place.world is World.NAME}
    if services.cell.controller is None or not ends:
        return frozenset()
    from gateway.checks.controller import names_of

    return names_of(services.cell) & ends


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
