"""CAN buses: bit rate, cycle, layout, modules and nodes, contacts (rho3 2.1 to 2.3); the P list of a bus: rho3can."""

import re

from drivers.ports.base import PortError
from drivers.ports.can.adapter_url import adapter_of, is_adapter
from gateway.checks.context import Context, twice
from gateway.files.find import ConfigNotFound, beside
from gateway.pure.cell.cell import Axis
from gateway.registry import BUS_PROTOCOLS, DRIVE_FAMILIES

OURS = re.compile(r"^(sim|socketcan:[\w.-]{1,15}|broker:[\w-]+|memory:[\w-]+)$")
MODULES = 6  # axes on a bus (rho3 2.1, L7250)


def modules_of(text: str) -> range:
    """ "1..6" -> 1..6, "3" -> 3, "" -> nothing."""
    if not text:
        return range(0)
    first, _, last = text.partition("..")
    return range(int(first), int(last or first) + 1)


def drives(check: Context) -> None:
    """Every axis is on a bus with its drive's protocol, at a place of its own."""
    buses = {bus.name: bus for bus in check.cell.bus}
    taken: dict[tuple[str, str, int], str] = {}
    for axis in check.cell.axis:
        key = f"axis.{axis.name}.drive"
        if check.unknown(f"{key}.bus", axis.drive.bus, "bus"):
            continue
        family = DRIVE_FAMILIES[axis.drive.type]
        wanted = family.protocol
        bus = buses.get(axis.drive.bus)
        if bus is not None and bus.protocol != wanted:
            check.fault(f"{key}.type", axis.drive.type, f'bus {bus.name} uses "{bus.protocol}"; this drive needs protocol = "{wanted}"')
        name = family.address
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
            check.fault(f"{key}.module", number, f'bus {bus.name} has axes = "{bus.axes}"')


def _one_place(check: Context, taken: dict[tuple[str, str, int], str], axis: Axis, name: str, number: int) -> None:
    place = (axis.drive.bus, name, number)
    if place in taken:
        check.fault(f"axis.{axis.name}.drive.{name}", number, f"axis {taken[place]} has {name} {number} on bus {axis.drive.bus} already")
    taken.setdefault(place, axis.name)


def buses(check: Context) -> None:
    """Requirements of a SERVODYN bus: 1 Mbit/s, at most six axes, a layout; its modules all have an axis."""
    for bus in check.cell.bus:
        if not BUS_PROTOCOLS[bus.protocol].boosted:
            continue
        key = f"bus.{bus.name}"
        on_it = [axis for axis in check.cell.axis if axis.drive.bus == bus.name]
        if bus.bitrate != "1 Mbit/s":
            check.fault(f"{key}.bitrate", bus.bitrate, "drives communicate at a fixed 1 Mbit/s (rho3 L7280-7282)", '"1 Mbit/s"')
        if len(on_it) > MODULES:
            check.fault(key, f"{len(on_it)} axes", "use another bus for the others", f"at most {MODULES} axes")
        try:
            beside(check.cell.file, bus.layout, "drives")
        except ConfigNotFound as error:
            check.fault(f"{key}.layout", bus.layout, str(error).split(": ", 1)[-1])
        missing = sorted(set(modules_of(bus.axes)) - {axis.drive.module for axis in on_it})
        if missing and not check.known["axis"] - {axis.name for axis in check.cell.axis}:
            check.fault(f"{key}.axes", bus.axes, f"no axis has module {', '.join(map(str, missing))}")
    cycles = [(bus.cycle_ms, f"bus.{bus.name}.cycle_ms") for bus in check.cell.bus if BUS_PROTOCOLS[bus.protocol].clocked]
    for cycle, place in cycles[1:]:
        if cycle != cycles[0][0]:
            check.fault(place, cycle, f"one cycle time for all drives: {cycles[0][1]} = {cycles[0][0]}", "", "ms")


def adapters(check: Context) -> None:
    """One of our port kinds needs its form; a port of python-can needs an interface it knows, and one bit rate in the complete file."""
    for bus in check.cell.bus:
        key = f"bus.{bus.name}.port"
        if not is_adapter(bus.port):
            if not OURS.match(bus.port):
                check.fault(key, bus.port, "", "sim | socketcan:can0 | broker:NAME | INTERFACE:CHANNEL of python-can")
            continue
        try:
            adapter = adapter_of(bus.port)
        except PortError as error:
            check.fault(key, bus.port, str(error).removeprefix(f"{bus.port!r}: "))
            continue
        from can import VALID_INTERFACES  # only where one is named: it is not quick

        if adapter.interface not in VALID_INTERFACES:
            known = sorted(VALID_INTERFACES - {"cycle"})
            check.fault(key, bus.port, f"python-can has no interface {adapter.interface!r}", ", ".join(known))
        if adapter.bitrate is not None and adapter.bitrate != bus.bits_per_s:
            check.fault(key, bus.port, f"opens it at {adapter.bitrate} bit/s, but bus.{bus.name}.bitrate = {bus.bitrate}: omit @...")


def contacts(check: Context) -> None:
    """Contacts name a bus that exists, one direction, and a place of their own."""
    places = []
    for io in check.cell.io:
        key = f"io.{io.name}.device"
        if io.device.bus:
            check.unknown(f"{key}.bus", io.device.bus, "bus")
        if (io.device.input is None) == (io.device.output is None):
            check.fault(key, "", "exactly one of input = n and output = n")
        device = io.device
        whose = (device.bus, device.node, device.url, device.unit, device.chip)
        places.append(((*whose, device.input, device.output), key))
    for _, first, place in twice(places):
        check.fault(place, "", f"{first} is already this contact")


CHECKS = (drives, buses, adapters, contacts)
