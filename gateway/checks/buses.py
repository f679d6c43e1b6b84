"""CAN buses: bit rate, cycle, layout, modules and nodes, identifiers, and the I/O bytes the axes leave (rho3 2.1 to 2.3)."""

from gateway.cell import Axis, Bus, IoBlock
from gateway.checks.context import Context, twice
from gateway.files import ConfigNotFound, beside

MODULES = 6  # axes on a bus (rho3 2.1, L7250)
BLOCK_BYTES = 8  # digital I/O per block (rho3 2.1, L7294)
FREE_BYTES = {6: (0, 0), 5: (8, 8), 4: (8, 8), 3: (16, 16), 2: (24, 24), 1: (32, 32), 0: (40, 32)}  # axes -> inputs, outputs (L7263-7268)


def modules_of(text: str) -> range:
    """ "1..6" -> 1..6, "3" -> 3, "" -> nothing."""
    if not text:
        return range(0)
    first, _, last = text.partition("..")
    return range(int(first), int(last or first) + 1)


def drives(check: Context) -> None:
    """Every axis hangs on a bus that speaks its drive's language, at a place of its own."""
    buses = {bus.name: bus for bus in check.cell.bus}
    taken: dict[tuple[str, str, int], str] = {}
    for axis in check.cell.axis:
        key = f"axis.{axis.name}.drive"
        if check.unknown(f"{key}.bus", axis.drive.bus, "bus"):
            continue
        wanted = "servodyn" if axis.drive.type == "servodyn" else "canopen"
        bus = buses.get(axis.drive.bus)
        if bus is not None and bus.protocol != wanted:
            check.fault(f"{key}.type", axis.drive.type, f'bus {bus.name} speaks "{bus.protocol}"; this drive needs protocol = "{wanted}"')
        name = "module" if axis.drive.type == "servodyn" else "node"
        number = getattr(axis.drive, name)
        other = axis.drive.node if name == "module" else axis.drive.module
        if number is None:
            check.fault(
                f"{key}.{name}", "", f"missing: a {axis.drive.type} drive is found by its {name}", "1..6" if name == "module" else "1..127"
            )
            continue
        if other is not None:
            check.fault(f"{key}.{'node' if name == 'module' else 'module'}", other, f"a {axis.drive.type} drive has no such number")
        _one_place(check, taken, axis, name, number)
        if bus is not None and name == "module" and bus.axes and number not in modules_of(bus.axes):
            check.fault(f"{key}.module", number, f'bus {bus.name} says axes = "{bus.axes}"')


def _one_place(check: Context, taken: dict[tuple[str, str, int], str], axis: Axis, name: str, number: int) -> None:
    place = (axis.drive.bus, name, number)
    if place in taken:
        check.fault(f"axis.{axis.name}.drive.{name}", number, f"axis {taken[place]} has {name} {number} on bus {axis.drive.bus} already")
    taken.setdefault(place, axis.name)


def buses(check: Context) -> None:
    """What a SERVODYN bus demands: 1 Mbit/s, at most six axes, a layout; its modules all have an axis."""
    for bus in check.cell.bus:
        if bus.protocol != "servodyn":
            continue
        key = f"bus.{bus.name}"
        on_it = [axis for axis in check.cell.axis if axis.drive.bus == bus.name]
        if bus.bitrate != "1 Mbit/s":
            check.fault(f"{key}.bitrate", bus.bitrate, "drives talk at 1 Mbit/s, fixed (rho3 L7280-7282)", '"1 Mbit/s"')
        if len(on_it) > MODULES:
            check.fault(key, f"{len(on_it)} axes", "take a second bus for axes 7..12", f"at most {MODULES} axes")
        try:
            beside(check.cell.file, bus.layout, "drives")
        except ConfigNotFound as error:
            check.fault(f"{key}.layout", bus.layout, str(error).split(": ", 1)[-1])
        missing = sorted(set(modules_of(bus.axes)) - {axis.drive.module for axis in on_it})
        if missing and not check.known["axis"] - {axis.name for axis in check.cell.axis}:
            check.fault(f"{key}.axes", bus.axes, f"no axis has module {', '.join(map(str, missing))}")
    cycles = [(bus.cycle_ms, f"bus.{bus.name}.cycle_ms") for bus in check.cell.bus if bus.protocol != "rho3-io"]
    for cycle, place in cycles[1:]:
        if cycle != cycles[0][0]:
            check.fault(place, cycle, f"one clock for all drives: {cycles[0][1]} = {cycles[0][0]}", "", "ms")


def io_blocks(check: Context) -> None:
    """P30..P32: as many blocks as announced, own identifiers, no overlapping bytes, and not more than the axes leave room for."""
    params = check.cell.rho3
    if params is None:
        return
    for number, announced in enumerate(params.P30, 1):
        axes = _axes_on(check, number)
        for index, (name, blocks, count) in enumerate((("P31", params.P31, announced.inputs), ("P32", params.P32, announced.outputs))):
            here = [block for block in blocks if block.bus == number]
            what = "input" if name == "P31" else "output"
            if len(here) != count:
                hint = f"P30 announces {count} {what} blocks on bus {number} (system error 151 on the rho 3)"
                check.fault(f"rho3.{name}", f"{len(here)} blocks", hint)
            if count * BLOCK_BYTES > FREE_BYTES[min(axes, MODULES)][index]:
                left = f"{FREE_BYTES[min(axes, MODULES)][index]} bytes of {what}s"
                hint = f"{axes} axes on bus {number} leave {left}: {_table(index)}; use the other bus"
                check.fault("rho3.P30", f"{count} {what} blocks", hint)
        if axes and announced.baud:
            check.fault(
                "rho3.P30", f"baud = {announced.baud}", f"bus {number} carries axes: 1 Mbit/s, baud = 0 (system error 150 on the rho 3)"
            )
    _identifiers(check, "P31", params.P31)
    _identifiers(check, "P32", params.P32)


def _table(index: int) -> str:
    return ", ".join(f"{axes} axes {free[index]}" for axes, free in FREE_BYTES.items())


def _axes_on(check: Context, number: int) -> int:
    if number > len(check.cell.bus):
        return 0
    bus: Bus = check.cell.bus[number - 1]
    return sum(axis.drive.bus == bus.name for axis in check.cell.axis)


def _identifiers(check: Context, name: str, blocks: tuple[IoBlock, ...]) -> None:
    for value, _, _ in twice(((block.bus, block.id), f"{number}") for number, block in enumerate(blocks)):
        check.fault(f"rho3.{name}", f"bus, id = {value}", "this identifier stands twice on its bus")
    covered: dict[int, int] = {}
    for number, block in enumerate(blocks, 1):
        span = range(block.start, block.start + block.length)
        if span.stop > 128:
            check.fault(f"rho3.{name}", f"start {block.start}, length {block.length}", "beyond the PIC image", "bytes 0..127")
        clash = next((byte for byte in span if byte in covered), None)
        if clash is not None:
            check.fault(f"rho3.{name}", f"start {block.start}", f"byte {clash} belongs to block {covered[clash]} already")
        covered.update(dict.fromkeys(span, number))
        if name == "P31" and 480 < block.id < 541:
            check.fault("rho3.P31", f"id = {block.id}", "modules send 541..550; 471..480 couples another rho 3", "541..550 or 471..480")


def contacts(check: Context) -> None:
    """Contacts name a bus that exists, one direction, and a place of their own."""
    places = []
    for io in check.cell.io:
        key = f"io.{io.name}.device"
        if io.device.bus:
            check.unknown(f"{key}.bus", io.device.bus, "bus")
        if (io.device.input is None) == (io.device.output is None):
            check.fault(key, "", "exactly one of input = n and output = n")
        places.append(((io.device.bus, io.device.node, io.device.input, io.device.output), key))
    for _, first, place in twice(places):
        check.fault(place, "", f"{first} is this contact already")


CHECKS = (drives, buses, io_blocks, contacts)
