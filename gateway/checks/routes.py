"""Routes of a cell against everything else in it: places that exist, one writer each, numbers that fit, time that suffices (AX-397)."""

import math
from collections.abc import Iterator

from gateway.assembly.data_block_signals import place_of as entry_place
from gateway.assembly.routes import BOUNDED, POLL_MS, Compiled, compile_route, devices_of, lines_of, symbols_of
from gateway.assembly.telegrams import named_values
from gateway.checks.context import Context, near, number
from gateway.checks.controller import names_of, wired
from gateway.files.eds_sheets import read_eds
from gateway.pure.cell.cell import Cell, Db, Notice
from gateway.pure.cell.routes import Route
from gateway.pure.image.addresses import AddressFault, DataBit, DataWord, Part
from gateway.pure.image.names import Kind, lookup
from gateway.pure.reports.transfer_times import job_ms
from gateway.pure.routes.addresses import Place, World
from gateway.pure.routes.forms import BIT, FLOATS, span_of
from gateway.pure.routes.judge import Span, rings, two_writers
from gateway.registry import BUS_PROTOCOLS
from protocols.canopen.dictionary import Entry
from protocols.canopen.types import Kind as DataKind
from protocols.modbus.numbers import words_of

# Objects closed to routes: options of the start-up, set values, and limits that protect parts and keep their commissioned values.
LIMITS = frozenset(
    (*range(0x605A, 0x605F), *range(0x607B, 0x6081), 0x6007, 0x6065, 0x6066, 0x6071, 0x6098, 0x6099, 0x60B0, 0x60B1, 0x60B2, 0x60FF)
)
CYCLES = 2  # from one command source to the bus, or to the other command source (route.one_way)


def routes(check: Context) -> None:
    """Every fault of [[route]]."""
    cell = check.cell
    if not cell.route:
        return
    symbols, lines, devices = symbols_of(cell, check.signals), lines_of(cell), devices_of(cell)
    compiled: dict[str, Compiled] = {}
    for route in cell.route:
        key = f"route.{route.name}"
        if route.name in compiled:
            check.fault(f"{key}.name", route.name, "another route has this name")
            continue
        try:
            compiled[route.name] = compile_route(route, symbols, lines, devices)
        except AddressFault as fault:
            check.fault(key, f"{route.from_} -> {route.to}", str(fault))
            continue
        _sense(check, route)
        _ends(check, route, compiled[route.name])
        _overflow(check, route, compiled[route.name])
        _time(check, route, compiled[route.name])
    _together(check, list(compiled.values()))


def _sense(check: Context, route: Route) -> None:
    key = f"route.{route.name}"
    if route.scale == 0:
        check.fault(f"{key}.scale", route.scale, "a target that never follows its source is not a route: scale is not 0")
    if route.edge in ("rising", "falling") and (route.scale, route.offset) != (1.0, 0.0):
        check.fault(f"{key}.scale", route.scale, "an edge is passed on as a pulse of 1: no scale, no offset")
    if route.on_loss != "value" and (route.loss_value or route.loss_after_ms):
        check.fault(f"{key}.loss_value", route.loss_value, f'on_loss = "{route.on_loss}" shows no value: on_loss = "value" does')


def _ends(check: Context, route: Route, compiled: Compiled) -> None:
    """Permitted sources and targets of values."""
    key = f"route.{route.name}"
    _source(check, f"{key}.from", route.from_, compiled.source)
    _target(check, f"{key}.to", route.to, compiled.target)
    for mark, text, place in (("valid", route.valid, compiled.valid), ("life", route.life, compiled.life)):
        if place is None:
            continue
        if place.world not in (World.BLOCK, World.RC_INPUT):
            check.fault(f"{key}.{mark}", text, "a mark must be in a data block of this cell or in an RC input without an owner")
        else:
            _target(check, f"{key}.{mark}", text, place)


def _source(check: Context, key: str, text: str, place: Place) -> None:
    match place.world:
        case World.BLOCK:
            block = _block(check.cell, place)
            if block is not None and block.writer == "axisgate":
                check.fault(key, text, f"DB {place.db} is written by axisgate itself: name the value of its entry, not the address")
            _inside(check, key, text, place, block)
        case World.CONTACT:
            _contact(check, key, text, place.name, output=False)
        case World.NAME:
            _name(check, key, text, place.name)
        case World.RC_INPUT | World.RC_OUTPUT:
            _image(check, key, text, place)
        case World.PARAMETER:
            check.fault(key, text, "a route writes drive parameters, it does not read them; read axis.NAME.actual or .torque")


def _target(check: Context, key: str, text: str, place: Place) -> None:
    match place.world:
        case World.BLOCK:
            block = _block(check.cell, place)
            _inside(check, key, text, place, block)
            if block is not None:
                _free(check, key, text, place, block)
        case World.RC_INPUT:
            _image(check, key, text, place)
            owners = {byte: source for byte, source in check.cell.rc_inputs.owner.items() if place.byte <= byte < place.byte + place.size}
            for byte, source in owners.items():
                check.fault(
                    key, text, f"two writers in RC input byte {byte}: {source} owns it ([rc_inputs]); a route needs a byte without an owner"
                )
        case World.RC_OUTPUT:
            check.fault(
                key, text, "only the cycle writes RC outputs: a route ends in an RC input, a block of this cell, a value or a contact"
            )
        case World.CONTACT:
            _contact(check, key, text, place.name, output=True)
        case World.REGISTER:
            _register(check, key, text, place)
        case World.PARAMETER:
            _parameter(check, key, text, place)
        case World.NAME:
            if place.name not in named_values(check.cell) and not wired(check.cell, place.name):
                hint = "commands come from command sources" if lookup(place.name) else _near_value(check, place.name)
                check.fault(key, text, f"a route writes values a telegram of the cell carries, and inputs of [controller]; {hint}")


def _register(check: Context, key: str, text: str, place: Place) -> None:
    """A target at a device: writable, and without another writer."""
    if place.db not in (0, 4):
        check.fault(key, text, "discrete inputs and input registers can only be read: a coil (00001) or a holding register (40001)")
    client, _, device = place.name.partition(".")
    for modbus in check.cell.modbus:
        for value in modbus.value if modbus.name == client else ():
            words = 1 if value.type == "bit" else words_of(value.type)
            table = f"table {0 if value.table == 'coil' else 4} of {client}.{value.device}"
            if value.from_ and value.device == device and place.span.meets(Span(table, 16 * value.at, 16 * words)):
                check.fault(key, text, f"two writers: [[modbus.value]] from {value.from_} is written there")


def _parameter(check: Context, key: str, text: str, place: Place) -> None:
    """A drive on CANopen, an object its start-up and its cycle leave alone, and one its EDS lets be written."""
    axis = next((axis for axis in check.cell.axis if axis.name == place.name), None)
    if axis is None:
        known = [axis.name for axis in check.cell.axis]
        check.fault(key, text, f"no axis {place.name}; {near(place.name, known) or 'there is ' + ', '.join(known)}")
        return
    if not any(bus.name == axis.drive.bus and BUS_PROTOCOLS[bus.protocol].nodes for bus in check.cell.bus):
        check.fault(key, text, f"the drive of {axis.name} is not on a CANopen bus: it has no parameters a route can write")
        return
    from gateway.assembly.canopen_nodes import OWN  # which imports figures of these checks

    kept = place.db in LIMITS or place.db in OWN
    if kept or not 0x2000 <= place.db < 0xA000:
        hint = "axisgate or the commissioning sets this object" if kept else "axisgate itself sets the communication objects of the device"
        check.fault(key, text, f"{hint}; a route may also write drive parameters", "2000h..9FFFh")
        return
    sheet = read_eds(check.cell, axis, simulated=False)
    if sheet is not None:
        _listed(check, key, text, place, sheet.dictionary.entries.get((place.db, place.byte)), sheet.path.name)


def _listed(check: Context, key: str, text: str, place: Place, entry: Entry | None, file: str) -> None:
    """As the EDS has it."""
    if entry is None:
        check.fault(key, text, f"{file} lists no object {place.db:04X}h:{place.byte:02X}")
    elif not entry.access.writable:
        check.fault(key, text, f"{entry.name}: read-only according to {file} ({entry.access.value})")
    elif entry.type.size != place.size or (entry.type.kind is DataKind.REAL) is not (place.form in FLOATS):
        check.fault(key, text, f"{entry.name}: {entry.type.name} in {file}; {place.form} has {place.size} bytes: another to_type")


def _block(cell: Cell, place: Place) -> Db | None:
    return next((block for block in cell.db if block.kind == "D" and (block.number, block.line) == (place.db, place.name)), None)


def _inside(check: Context, key: str, text: str, place: Place, block: Db | None) -> None:
    if block is None:
        check.fault(key, text, f"DB {place.db} is not served on line {place.name}; write a [[db]] for it")
    elif place.byte + place.size > 2 * block.words:
        check.fault(key, text, f"beyond the block: it has {block.words} words", f"word 0..{block.words - 1}")


def _free(check: Context, key: str, text: str, place: Place, block: Db) -> None:
    """A target in a block: ours, and no entry there."""
    if block.writer != "axisgate":
        who = "the PLC" if block.writer == "plc" else "a Modbus client"
        check.fault(key, text, f'two writers in one word: DB {block.number} is written by {who} (writer = "{block.writer}")')
    for entry in block.entries:
        address = entry_place(block, entry)
        if address is not None and place.span.meets(Span(place.span.world, *_bits(address))):
            check.fault(key, text, f"overlaps the entry {entry.at} ({entry.signal}): two writers in one word")


def _bits(address: DataWord | DataBit) -> tuple[int, int]:
    """First bit and count of an entry, counted as Place.span does (high bit first)."""
    word = 16 * address.word
    if isinstance(address, DataBit):
        return word + 15 - address.bit, 1
    first, width = {Part.WORD: (0, 16), Part.LEFT: (0, 8), Part.RIGHT: (8, 8), Part.DOUBLE: (0, 32)}[address.part]
    return word + first, width


def _image(check: Context, key: str, text: str, place: Place) -> None:
    if place.byte + place.size > 128:
        check.fault(key, text, "the image ends at byte 127", "0..127")


def _contact(check: Context, key: str, text: str, name: str, *, output: bool) -> None:
    found = next((io for io in check.cell.io if io.name == name), None)
    if found is None:
        check.fault(key, text, f"no such contact; {near(name, [io.name for io in check.cell.io]) or 'write an [[io]] for it'}")
    elif (found.device.output is not None) is not output:
        check.fault(key, text, f"io.{name} is an {'input' if output else 'output'}")
    elif output and found.signal != f"io.{name}":
        check.fault(key, text, f'two writers: the contact shows {found.signal}; signal = "io.{name}" leaves it to the route')


def _name(check: Context, key: str, text: str, name: str) -> None:
    found = lookup(name)
    if name in named_values(check.cell) or name in names_of(check.cell):
        return
    if found is None or not found.name.from_ or name.startswith("move."):
        check.fault(key, text, f"no value that can be read; {_near_value(check, name)}")
    elif found.which not in ("", "*") and found.which not in (known := check.known[found.kind]):
        there = near(found.which, known) or "there is " + (", ".join(sorted(known)) or "none")
        check.fault(key, text, f"no such {found.kind}; {there}")


def _near_value(check: Context, name: str) -> str:
    from gateway.pure.image.names import spelled

    known = [*spelled(sorted(check.known["axis"]), ()), *named_values(check.cell).names(), *names_of(check.cell)]
    return near(name, known) or "axisgate var lists them"


def _overflow(check: Context, route: Route, compiled: Compiled) -> None:
    """The largest source value against the target's form; floats have no known range."""
    span = _source_span(check.cell, compiled.source)
    if span is None or compiled.target.world not in BOUNDED or route.edge in ("rising", "falling"):
        return
    ends = sorted(value * route.scale + route.offset for value in span)
    low, high = span_of(compiled.target.form)
    if ends[0] < low or ends[1] > high:
        hint = f"{route.from_} results in {number(ends[0])}..{number(ends[1])}, {compiled.target.form} holds {number(low)}..{number(high)}"
        check.fault(f"route.{route.name}.to", route.to, f"overflow: {hint}; a wider to_type, or another scale")
    if route.on_loss == "value" and not low <= route.loss_value <= high:
        check.fault(
            f"route.{route.name}.loss_value", route.loss_value, f"{compiled.target.form} cannot hold it", f"{number(low)}..{number(high)}"
        )


def _source_span(cell: Cell, place: Place) -> tuple[float, float] | None:
    if place.world is not World.NAME:
        return None if place.form in FLOATS else span_of(place.form)
    found = lookup(place.name)
    if found is None or place.name.split(".")[0] not in ("cell", "axis"):
        return None
    if found.name.kind is Kind.BIT:
        return span_of(BIT)
    if found.name.kind is Kind.PERCENT:
        return 0.0, 100.0
    axis = next((axis for axis in cell.axis if axis.name == found.which), None)
    return (axis.limits.min, axis.limits.max) if axis is not None and place.name.endswith(".actual") else None


def expected_ms(cell: Cell, compiled: Compiled) -> float:
    """Worst-case delay of a change from one partner to the other: both lines' rounds, debounce, and two cycles."""
    total = compiled.settings.debounce_ns / 1e6 + CYCLES * cell.cycle_ms
    lines = {line.name: line for line in cell.line}
    for place in (compiled.source, compiled.target):
        if place.world is World.BLOCK and place.name in lines:
            line = lines[place.name]
            total += sum(job_ms(line, block.words) for block in cell.db if block.line == line.name)
        elif place.world is World.REGISTER and place is compiled.source:
            total += compiled.settings.rate_ns / 1e6 or POLL_MS
    return total


def _time(check: Context, route: Route, compiled: Compiled) -> None:
    """`within_ms` against the delay of the lines; a pulse must be long enough for a polling partner."""
    needed = expected_ms(check.cell, compiled)
    if route.within_ms and needed > route.within_ms:
        hint = f"polling does not fit: SEND and FETCH, debounce and {CYCLES} cycles take {needed:.0f} ms at worst"
        check.fault(f"route.{route.name}.within_ms", route.within_ms, hint, f">= {math.ceil(needed)}", "ms")
    if route.edge in ("rising", "falling") and compiled.target.world is World.BLOCK and route.pulse_ms < needed:
        hint = f"the PLC fetches the block every {needed:.0f} ms: a pulse of {route.pulse_ms} ms passes between two of them unseen"
        check.fault(f"route.{route.name}.pulse_ms", route.pulse_ms, hint, f">= {math.ceil(needed)}", "ms")


def _together(check: Context, compiled: list[Compiled]) -> None:
    joined = [each.joined for each in compiled]
    for first, second, span in two_writers(joined):
        who = f"route {first} writes it already" if first != second else "its value and its marks overlap"
        check.fault(f"route.{second}.to", f"{span.world} bit {span.first}", f"routes that disagree: {who}")
    for ring in rings(joined):
        check.fault(f"route.{ring[0]}.to", " -> ".join((*ring, ring[0])), "routes in a ring: the value would feed itself")


def reach(cell: Cell) -> Iterator[Notice]:
    """Requirements of each route, if they exceed the cycle."""
    if not cell.route:
        return
    symbols, lines, devices = symbols_of(cell), lines_of(cell), devices_of(cell)
    for route in cell.route:
        needed = expected_ms(cell, compile_route(route, symbols, lines, devices))
        if needed > 10 * cell.cycle_ms:
            yield Notice("note", f"route {route.name}", f"{route.from_} -> {route.to}: at worst {needed:.0f} ms from partner to partner")


CHECKS = (routes,)
NOTES = (reach,)
