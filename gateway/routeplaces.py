"""[[route]] of a cell compiled: places and settings, the same for `check` and for the services that play them."""

from collections.abc import Mapping
from dataclasses import dataclass

from gateway.cell import Cell
from gateway.cell_routes import Route
from gateway.files import read_signals
from gateway.pure.addresses import RcBit
from gateway.pure.routes.forms import BIT, span_of
from gateway.pure.routes.judge import Joined
from gateway.pure.routes.places import Place, World, place_of
from gateway.pure.routes.route import Edge, Loss, RouteSettings
from gateway.pure.signals import SignalList, from_tables
from protocols.base.machine import ms

MARK_FORM = "u16"  # of a life counter


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
    known = (signals or from_tables(read_signals())).symbols()
    moved = {name.upper(): RcBit(known[name.upper()].direction, bit) for name, bit in cell.signals.items() if name.upper() in known}
    return {**known, **moved}


def lines_of(cell: Cell) -> Mapping[int, str]:
    """Data block -> line, where it is served on one line only."""
    served: dict[int, set[str]] = {}
    for block in cell.db:
        if block.kind == "D":
            served.setdefault(block.number, set()).add(block.line)
    return {number: next(iter(lines)) for number, lines in served.items() if len(lines) == 1}


def compile_route(route: Route, symbols: Mapping[str, RcBit], lines: Mapping[int, str]) -> Compiled:
    """Raises AddressFault for a place that is none; the cell's checks have named it before."""
    source = place_of(route.from_, route.type, route.order, symbols, lines)
    to_type = route.to_type or route.type
    target = place_of(route.to, to_type, route.to_order, symbols, lines)
    low, high = span_of(target.form) if target.world in (World.BLOCK, World.RC_INPUT) else (float("-inf"), float("inf"))
    settings = RouteSettings(
        route.name, route.scale, route.offset, low, high, Edge(route.edge), ms(route.pulse_ms), ms(route.debounce_ms), ms(route.every_ms),
        Loss(route.on_loss), route.loss_value, ms(route.loss_after_ms),
    )  # fmt: skip
    valid = place_of(route.valid, BIT, "ABCD", symbols, lines) if route.valid else None
    life = place_of(route.life, MARK_FORM, "ABCD", symbols, lines) if route.life else None
    return Compiled(source, target, valid, life, settings)


def compile_routes(cell: Cell) -> list[Compiled]:
    """All routes of a checked cell."""
    symbols, lines = symbols_of(cell), lines_of(cell)
    return [compile_route(route, symbols, lines) for route in cell.route]
