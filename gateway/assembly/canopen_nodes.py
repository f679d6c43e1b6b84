"""From a cell to the settings of each CANopen node: maps, heartbeat, homing, parameters of its EDS or DCF."""

import pathlib

from drivers.drives.cia402_boot import PROBE_FUNCTION, Identity, Loss, NodePlan, Parameter, default_pdos, probe_parameter, probe_pdos
from drivers.drives.cia402_family import GATEWAY_NODE
from gateway.assembly.axis_scaling import scaling_of
from gateway.assembly.programs import probe_of
from gateway.files.eds_sheets import read_eds
from gateway.pure.cell.cell import Axis, Bus, Cell
from gateway.pure.reports.transfer_times import canopen_room
from motion.geometry.units import to_si
from protocols.canopen import eds
from protocols.canopen.dictionary import ObjectDictionary
from protocols.canopen.types import Value, encode

SLOW_SHARE = 0.2  # of the homing speed, where the cell names no slow speed
OWN = (0x1005, 0x1006, 0x1014, 0x1016, 0x1017, 0x6040, 0x6060, 0x607A, PROBE_FUNCTION, 0x60C2)  # written by the start-up itself


def node_plans(cell: Cell, bus: Bus, p5_ms: int, *, simulated: bool) -> list[tuple[str, NodePlan]]:
    """(axis, plan) for every axis on the bus."""
    torque = canopen_room(cell, bus, p5_ms)
    found = []
    for axis in cell.axis:
        if axis.drive.bus == bus.name and axis.drive.node is not None:
            found.append((axis.name, _plan(cell, bus, axis, axis.drive.node, p5_ms, torque, simulated)))
    return found


def _plan(cell: Cell, bus: Bus, axis: Axis, node: int, p5_ms: int, torque: bool, simulated: bool) -> NodePlan:
    sheet = read_eds(cell, axis, simulated=simulated)
    own = sheet is not None and bool(axis.drive.eds) and sheet.path.name == pathlib.Path(axis.drive.eds).name
    identity = identity_of(sheet.dictionary) if sheet is not None and own else Identity()
    serial = (int(axis.drive.serial, 0) or None) if axis.drive.serial[:1].isdigit() and not simulated else None  # 0: it has none
    parameters = (*_file_parameters(sheet.dictionary, node), *homing_parameters(axis)) if sheet is not None else homing_parameters(axis)
    pdos, measuring = default_pdos(node, torque=torque), probe_of(cell, axis.name)
    if measuring is not None:
        pdos = probe_pdos(node, measuring.probe, pdos)
        parameters = (*parameters, probe_parameter(f"measuring.{measuring.channel}.drives"))
    return NodePlan(
        node,
        pdos,
        Identity(identity.vendor, identity.product, None, serial),
        tuple(parameters),
        heartbeat_ms=bus.heartbeat_ms,
        gateway=GATEWAY_NODE,
        period_us=p5_ms * 1000,
        loss=Loss(axis.stop_on_bus_loss),
        stop_evidence=axis.stop_evidence,
    )


def identity_of(dictionary: ObjectDictionary) -> Identity:
    """Identity of the device in the file; a missing number is not compared."""

    def number(key: str) -> int | None:
        try:
            value = eds.number_of(dictionary.device.get(key, ""))
        except ValueError:
            return None
        return value or None

    return Identity(number("vendornumber"), number("productnumber"))


def _file_parameters(dictionary: ObjectDictionary, node: int) -> list[Parameter]:
    """Values that a DCF sets in the device, without those that the start-up decides itself."""
    found = []
    for entry in dictionary:
        value: Value | None = entry.parameter_of(node)
        pdo = 0x1400 <= entry.index < 0x1C00
        if value is None or not entry.access.writable or pdo or entry.index in OWN:
            continue
        found.append(Parameter(entry.index, entry.sub, encode(entry.type, value), "DCF"))
    return found


def homing_parameters(axis: Axis) -> list[Parameter]:
    """607Ch = 0: the offset is our arithmetic (AX-306); 6098h, 6099h in the drive's units, increments and seconds (AX-311)."""
    home = axis.home
    if home.by != "drive" or home.method is None:
        return []
    factor = abs(scaling_of(axis).inc_per_unit)

    def speed(value: float) -> bytes:
        return max(1, round(to_si(value, axis.unit) * factor)).to_bytes(4, "little")

    key = f"axis.{axis.name}.home"
    return [
        Parameter(0x6098, 0, home.method.to_bytes(1, "little", signed=True), f"{key}.method"),
        Parameter(0x607C, 0, bytes(4), f"{key}.offset is the gateway's"),
        Parameter(0x6099, 1, speed(home.speed), f"{key}.speed"),
        Parameter(0x6099, 2, speed(home.slow_speed or SLOW_SHARE * home.speed), f"{key}.slow_speed"),
    ]
