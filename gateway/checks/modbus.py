"""[[modbus]]: ports and framing that fit, units that are one, registers that do not overlap, names that exist, values of clients."""

import ipaddress
from collections.abc import Iterator, Sequence

from gateway.checks.context import Context, near, twice
from gateway.checks.controller import phg_fault
from gateway.pure.cell.modbus import Modbus, ModbusValue
from gateway.pure.controllers.rho3.pendant.catalogue import PREFIX
from gateway.pure.image.names import lookup, spelled
from gateway.pure.modbus.registers import place
from gateway.registry import MODBUS_VIEWS
from protocols.modbus.numbers import words_of

BLOCK, BLOCK_END = 1000, 1064


def modbus(check: Context) -> None:
    """Every table by its role."""
    for server in check.cell.modbus:
        key = f"modbus.{server.name}"
        if server.role == "client":
            _client(check, server, key)
        else:
            _server(check, server, key)


def _server(check: Context, server: Modbus, key: str) -> None:
    if server.port > 65535:
        check.fault(f"{key}.bind", server.bind, "", "port 0..65535 (0: any free one)")
    if server.port_.startswith(("tcp://", "rfc2217://")):
        check.fault(f"{key}.port", server.port_, 'a server on TCP has `bind`; `port` is the serial port of framing = "rtu"')
    if server.serial and server.framing != "rtu":
        check.fault(f"{key}.framing", server.framing, 'a serial port carries RTU: framing = "rtu"')
    if server.tls is not None and (server.serial or server.framing == "rtu"):
        check.fault(f"{key}.tls", "", "TLS carries Modbus TCP only: omit framing and port")
    if (server.tls is None) == bool(server.roles):
        hint = (
            "roles come from certificates: [modbus.tls] is missing" if server.roles else "without [[modbus.roles]] no client has any right"
        )
        check.fault(f"{key}.{'roles' if server.roles else 'tls'}", "", hint)
    if server.writers and (server.allow or server.tls is not None):
        check.fault(f"{key}.writers", "", "either allow (anywhere), writers (by addresses) or roles (by certificate): keep one of them")
    if not (server.serial or server.local or server.allow or server.writers or server.roles or server.tls):
        hint = 'reached from other computers: name the PLC that may write, allow = ["10.0.0.5"], set writers or roles, or bind 127.0.0.1'
        check.fault(f"{key}.bind", server.bind, hint)
    if server.first_address:
        check.fault(
            f"{key}.first_address", server.first_address, "addresses on the line count from 0; axisgate map shows both counts: keep 0"
        )
    if server.device or server.value:
        check.fault(f"{key}.role", server.role, 'device and value belong to role = "client"')
    for text, where in (*((text, "allow") for text in server.allow), *((writer.from_, "writers") for writer in server.writers)):
        _network(check, f"{key}.{where}", text)
    kind = check.cell.controller.kind if check.cell.controller is not None else ""
    for view, where in ((server.view, "view"), *((unit.view, f"units[{n}]") for n, unit in enumerate(server.units))):
        if MODBUS_VIEWS[view].controller not in ("", kind):
            check.fault(f"{key}.{where}", view, f'this view belongs to another controller: it needs [controller] kind = "{view}"')
    for value, _, where in twice([(server.unit, "unit"), *((unit.unit, f"units[{n}]") for n, unit in enumerate(server.units))]):
        check.fault(f"{key}.{where}", value, "the unit id is used twice")
    _registers(check, server, key)


def _network(check: Context, key: str, text: str) -> None:
    try:
        ipaddress.ip_network(text, strict=False)
    except ValueError:
        check.fault(key, text, "", 'an address or a network, "10.0.0.5" or "10.0.0.0/24"')


def _registers(check: Context, server: Modbus, key: str) -> None:
    """Registers in addition to the view: known names, no register twice, none of the view's."""
    axes = [axis.name for axis in check.cell.axis]
    taken: dict[int, str] = {}
    for view in {server.view, *(unit.view for unit in server.units)}:
        taken |= dict.fromkeys(MODBUS_VIEWS[view].registers(check.cell.controller), MODBUS_VIEWS[view].words)
    if server.command_block and any(MODBUS_VIEWS[view].signals for view in (server.view, *(unit.view for unit in server.units))):
        taken |= dict.fromkeys(range(BLOCK, BLOCK_END), "the command and status block")
    for table in server.registers:
        where = f"{key}.registers[{table.at}]"
        found = lookup(table.from_)
        why = phg_fault(check.cell, table.from_)
        if why:
            check.fault(where, table.from_, why)
            continue
        there = found is not None and (found.which in ("", "*") or found.which in check.known[found.kind])
        if not table.from_.startswith(PREFIX) and not there:
            check.fault(
                where, table.from_, near(table.from_, spelled(axes, [])) or "no such value; `axisgate var` lists those of a running cell"
            )
            continue
        for placed in place(table.at, table.from_, table.type, axes):
            for register in range(placed.at, placed.at + placed.words):
                owner = taken.setdefault(register, placed.name)
                if register > 0xFFFF or owner != placed.name:
                    hint = "beyond register 65535" if register > 0xFFFF else f"register {register} is taken by {owner}"
                    check.fault(where, placed.name, hint)
                    break


def _client(check: Context, server: Modbus, key: str) -> None:
    if not server.port_:
        check.fault(f"{key}.port", "", 'a client needs the port of its devices: "tcp://10.0.0.7:502", "/dev/ttyUSB0"')
    if server.serial and server.framing != "rtu":
        check.fault(f"{key}.framing", server.framing, 'a serial port carries RTU: framing = "rtu"')
    if server.tls is not None and (not server.port_.startswith("tcp://") or server.framing == "rtu"):
        check.fault(f"{key}.tls", "", 'TLS carries Modbus TCP only: port = "tcp://host:802", no framing')
    if not server.device:
        check.fault(f"{key}.device", "", "a client without a [[modbus.device]] has nothing to poll")
    devices = [device.name for device in server.device]
    for value, _, _ in twice((name, f"{n}") for n, name in enumerate(devices)):
        check.fault(f"{key}.device", value, "the name is used twice among the devices")
    for n, value in enumerate(server.value):
        for hint in _value_faults(value, devices):
            check.fault(f"{key}.value[{n}]", value.name or value.table, hint)


def _value_faults(value: ModbusValue, devices: Sequence[str]) -> Iterator[str]:
    bits = value.table in ("coil", "discrete")
    if value.device not in devices:
        yield f"no device {value.device}; {near(value.device, devices) or 'there is ' + (', '.join(devices) or 'none')}"
    if bool(value.to) == bool(value.from_):
        yield "exactly one of `to` (read into this name) and `from` (written when this name changes)"
    if bits is not (value.type == "bit"):
        yield "coils and discrete inputs are bits, registers are numbers: table and type do not fit"
    if value.from_ and value.table in ("discrete", "input"):
        yield f"{value.table} values can only be read: use coil or holding"
    if value.scale == 0:
        yield "scale must not be 0"
    if not bits and value.type != "bit" and value.at + words_of(value.type) > 0x10000:
        yield f"{value.type} at {value.at} goes beyond register 65535"


CHECKS = (modbus,)
