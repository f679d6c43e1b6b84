"""[[route]] of a cell compiled: places and settings, the same for `check` and for the services that play them."""

from collections.abc import Mapping
from dataclasses import dataclass

from gateway.files.signal_lists import signal_list
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.modbus import ModbusTable, ModbusValue
from gateway.pure.cell.routes import Route
from gateway.pure.image.addresses import RcBit
from gateway.pure.image.signals import SignalList
from gateway.pure.routes.addresses import NO_DEVICES, REGISTER_TYPES, Place, World, place_of
from gateway.pure.routes.forms import BIT, span_of
from gateway.pure.routes.judge import Joined
from gateway.pure.routes.route import Edge, Loss, RouteSettings
from protocols.base.machine import ms

MARK_FORM = "u16"  # of a life counter
BOUNDED = (World.BLOCK, World.RC_INPUT, World.REGISTER, World.PARAMETER)  # targets whose number form has two ends


@dataclass(frozen=True, slots=True)
class Compiled:
    """One route ready to run."""

    source: Place
    target: Place
    valid: Place | None
    life: Place | None
    settings: RouteSettings

    @property
    def joined(self) -> Joined:
        """To be held against the others."""
        return Joined(self.settings.name, self.source.span, self.target.span, tuple(p.span for p in (self.valid, self.life) if p))


def symbols_of(cell: Cell, signals: SignalList | None = None) -> Mapping[str, RcBit]:
    """Signal names in capitals, axisgate's own at the places the cell moved them to."""
    known = (signals or signal_list()).symbols()
    moved = {name.upper(): RcBit(known[name.upper()].direction, bit) for name, bit in cell.signals.items() if name.upper() in known}
    return {**known, **moved}


def lines_of(cell: Cell) -> Mapping[int, str]:
    """Data block -> line, where it is served on one line only."""
    served: dict[int, set[str]] = {}
    for block in cell.db:
        if block.kind == "D":
            served.setdefault(block.number, set()).add(block.line)
    return {number: next(iter(lines)) for number, lines in served.items() if len(lines) == 1}


def devices_of(cell: Cell) -> Mapping[str, str]:
    """DEVICE, where one client alone has it, and CLIENT.DEVICE -> CLIENT.DEVICE."""
    full = [(device.name, f"{client.name}.{device.name}") for client in cell.modbus if client.role == "client" for device in client.device]
    short = [name for name, _ in full]
    return {**{name: whole for name, whole in full if short.count(name) == 1}, **{whole: whole for _, whole in full}}


COMMANDS = ("val3.run", "val3.move")  # values that start something when they become 1 (AX-1842)


def compile_route(
    route: Route, symbols: Mapping[str, RcBit], lines: Mapping[int, str], devices: Mapping[str, str] = NO_DEVICES
) -> Compiled:
    """Raises AddressFault for a place that is none; the cell's checks have named it before."""
    source = place_of(route.from_, route.type, route.order, symbols, lines, devices)
    to_type = route.to_type or route.type
    target = place_of(route.to, to_type, route.to_order, symbols, lines, devices)
    bounded = target.world in BOUNDED
    low, high = span_of(target.form) if bounded else (float("-inf"), float("inf"))
    settings = RouteSettings(
        route.name, route.scale, route.offset, low, high, Edge(route.edge), ms(route.pulse_ms), ms(route.debounce_ms), ms(route.every_ms),
        Loss(route.on_loss), route.loss_value, ms(route.loss_after_ms), target.world is World.NAME and target.name in COMMANDS,
    )  # fmt: skip
    valid = place_of(route.valid, BIT, "ABCD", symbols, lines) if route.valid else None
    life = place_of(route.life, MARK_FORM, "ABCD", symbols, lines) if route.life else None
    return Compiled(source, target, valid, life, settings)


def compile_routes(cell: Cell) -> list[Compiled]:
    """All routes of a checked cell."""
    symbols, lines, devices = symbols_of(cell), lines_of(cell), devices_of(cell)
    return [compile_route(route, symbols, lines, devices) for route in cell.route]


TABLES: Mapping[int, ModbusTable] = {0: "coil", 1: "discrete", 3: "input", 4: "holding"}
POLL_MS = 100  # of a register no route limits


def register_key(place: Place, *, reads: bool) -> str:
    """Key under which the client of a register keeps its value; the read and the written value are separate."""
    return f"{'from' if reads else 'to'} {place.name}.{TABLES[place.db]}.{place.byte}.{place.form}"


def routed_values(cell: Cell) -> Mapping[str, list[ModbusValue]]:
    """Client -> values read from or written to its devices, because a route begins or ends there (AX-407)."""
    found: dict[str, dict[str, ModbusValue]] = {}
    for compiled in compile_routes(cell):
        every_ms = compiled.settings.rate_ns // ms(1) or POLL_MS
        for place, reads in ((compiled.source, True), (compiled.target, False)):
            if place.world is not World.REGISTER:
                continue
            client, _, device = place.name.partition(".")
            key, type_ = register_key(place, reads=reads), REGISTER_TYPES[place.form]
            mine = found.setdefault(client, {})
            every_ms = min(every_ms, mine[key].every_ms) if key in mine else every_ms
            mine[key] = ModbusValue(device, TABLES[place.db], place.byte, type_, key if reads else "", "" if reads else key, every_ms)
    return {client: list(values.values()) for client, values in found.items()}
