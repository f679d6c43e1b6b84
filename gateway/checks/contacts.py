"""Contacts: a device that is complete, one input or output a contact, signals that exist, one writer each, polling that fits."""

from gateway.assembly.contacts import CHIP, COUPLER, MODBUS
from gateway.assembly.routes import symbols_of
from gateway.assembly.telegrams import named_values
from gateway.checks.context import Context, near
from gateway.checks.controller import names_of
from gateway.pure.arbitration.data_blocks import RC_NAMES
from gateway.pure.buses.contacts import CONTACTS, WATCHDOG, Source, source_of
from gateway.pure.cell.cell import Io
from gateway.pure.image.addresses import Direction
from gateway.pure.image.names import Kind, lookup
from gateway.registry import BUS_PROTOCOLS

CHANNELS = 64  # digital inputs or outputs of PDO 1 (CiA 401)
TCP_REQUEST_MS, RTU_CHARACTER_MS, RTU_REQUEST_CHARS = 2.0, 11 / 9.6, 8 + 7  # one question and its answer, at 9600 Bd
REIS = "reis.output."  # an output of a Reis by byte and bit, reis.output.3.7
SHOWN_ONLY = "cell.safety_ok"  # an input that is shown and reported first-out, and moves nothing


def contacts(check: Context) -> None:
    """Every fault of [[io]]."""
    if len(check.cell.io) > CONTACTS:
        check.fault("io", len(check.cell.io), "", f"at most {CONTACTS}", "contacts")
    written: dict[object, str] = {}
    for io in check.cell.io:
        _device(check, io)
        if io.device.output is not None:
            _output(check, io)
        elif io.device.input is not None:
            _input(check, io, written)
    _polling(check)


def _device(check: Context, io: Io) -> None:
    """Required and unknown settings of each kind of device."""
    key, device = f"io.{io.name}.device", io.device
    needed = {COUPLER: ("bus", "node"), MODBUS: ("url",), CHIP: ("chip",)}[device.type]
    for name in needed:
        if getattr(device, name) in ("", None):
            check.fault(f"{key}.{name}", "", f"a {device.type} device needs it")
    for name, kinds in (("bus", COUPLER), ("node", COUPLER), ("url", MODBUS), ("chip", CHIP)):
        if getattr(device, name) not in ("", None) and device.type != kinds:
            check.fault(f"{key}.{name}", getattr(device, name), f"a {device.type} device has none; {kinds} has")
    if device.active_low and device.type != CHIP:
        check.fault(f"{key}.active_low", "true", "only a gpiochip inverts levels")
    bus = next((bus for bus in check.cell.bus if bus.name == device.bus), None)
    if device.type == COUPLER and bus is not None and not BUS_PROTOCOLS[bus.protocol].nodes:
        check.fault(f"{key}.bus", device.bus, f'a CANopen coupler belongs on a bus with protocol = "canopen", not "{bus.protocol}"')
    channel = device.input if device.output is None else device.output
    if device.type == COUPLER and channel is not None and channel >= CHANNELS:
        check.fault(key, channel, "", f"0..{CHANNELS - 1}", "channel")


def _output(check: Context, io: Io) -> None:
    """A signal that can be read, or `io.NAME` for a route."""
    key = f"io.{io.name}.signal"
    if io.signal == f"io.{io.name}":
        if not any(route.to == io.signal for route in check.cell.route):
            check.fault(key, io.signal, f'no route writes it: [[route]] to = "{io.signal}"')
        return
    place = symbols_of(check.cell, check.signals).get(io.signal.upper())
    if place is not None:
        if place.direction is Direction.INPUT:
            check.fault(key, io.signal, "an RC input is written by command sources; an output contact shows RC outputs and values")
        return
    source = source_of(io.signal, [axis.name for axis in check.cell.axis], None)[0]
    found = lookup(io.signal)
    readable = found is not None and found.name.from_ and found.name.kind is Kind.BIT and not io.signal.startswith("move.")
    readable = readable or io.signal in named_values(check.cell) or (io.signal.startswith(REIS) and io.signal in names_of(check.cell))
    if source is Source.SERVICES and not readable:
        known = [WATCHDOG, "cell.ready", "cell.drives_on", "cell.emergency_stop", "cell.error"]
        known += [
            f"axis.{axis.name}.{what}" for axis in check.cell.axis for what in ("brake", "enabled", "referenced", "in_position", "fault")
        ]
        check.fault(key, io.signal, f"an output cannot show this bit; {near(io.signal, known) or 'as ' + ', '.join(known[:5])}")
    if io.signal == WATCHDOG and io.toggle_ms < check.cell.cycle_ms:
        check.fault(
            f"io.{io.name}.toggle_ms", io.toggle_ms, "a watchdog output toggles with completed cycles", f">= {check.cell.cycle_ms}", "ms"
        )


def _input(check: Context, io: Io, written: dict[object, str]) -> None:
    """An enabling name, an RC input without another owner, or the safety contact; routes can read `io.NAME` as well."""
    key = f"io.{io.name}.signal"
    if io.signal in (SHOWN_ONLY, f"io.{io.name}"):
        return
    enabling = io.signal in RC_NAMES
    place = symbols_of(check.cell, check.signals).get(io.signal.upper())
    if not enabling and (place is None or place.direction is Direction.OUTPUT):
        known = [SHOWN_ONLY, *RC_NAMES]
        check.fault(
            key, io.signal, f"not a signal that an input may drive; {near(io.signal, known) or 'as ' + ', '.join(known)} or an RC input"
        )
        return
    byte = 3 if place is None else place.number >> 3  # enabling inputs are in byte 3 unless [signals] moves them
    if byte in check.cell.rc_inputs.owner:
        check.fault(key, io.signal, f"two writers in RC input byte {byte}: {check.cell.rc_inputs.owner[byte]} owns it ([rc_inputs])")
    what: object = io.signal if place is None else place
    if what in written:
        check.fault(key, io.signal, f"io.{written[what]} drives it already")
    written.setdefault(what, io.name)


def _polling(check: Context) -> None:
    """Modbus couplers: all questions of a link have to fit into the shortest interval."""
    links: dict[str, dict[int, list[Io]]] = {}
    for io in check.cell.io:
        if io.device.type == MODBUS:
            links.setdefault(io.device.url, {}).setdefault(io.device.unit, []).append(io)
    for url, units in links.items():
        serial = not url.startswith("tcp://")
        one = RTU_CHARACTER_MS * RTU_REQUEST_CHARS + 8 if serial else TCP_REQUEST_MS
        polled = [io for devices in units.values() for io in devices if io.device.input is not None]
        questions = sum(any(io.device.input is not None for io in devices) for devices in units.values())
        questions += sum(io.device.output is not None for devices in units.values() for io in devices)
        if polled and one * questions > min(io.device.poll_ms for io in polled):
            first = min(polled, key=lambda io: io.device.poll_ms)
            hint = f"polling does not fit: {questions} requests of {one:.0f} ms on {url}"
            check.fault(f"io.{first.name}.device.poll_ms", first.device.poll_ms, hint, f">= {one * questions:.0f}", "ms")


CHECKS = (contacts,)
