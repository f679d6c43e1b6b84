"""The frames a cell puts on each of its buses (AX-001, AX-302, rho3 2.1)."""

from gateway.pure.buses.load import Traffic
from gateway.pure.cell.cell import Bus, Cell
from gateway.pure.reports.transfer_times import canopen_room
from gateway.registry import BUS_PROTOCOLS
from protocols.canopen import cob_id as cobid
from protocols.servodyn.plan import SYNC_ID, actual_id, set_id

GATEWAY_NODE = 127
COMMAND_AND_POSITION = 6  # 6040h + 607Ah, 6041h + 6064h
DRIVE_BYTES = 8


def traffic(cell: Cell, bus: Bus) -> list[Traffic]:
    """In the order of a cycle."""
    return BUS_PROTOCOLS[bus.protocol].traffic(cell, bus)


def bitrate(bus: Bus) -> int:
    """bit/s."""
    value, unit = bus.bitrate.split()
    return round(float(value) * (1_000_000 if unit == "Mbit/s" else 1000))


def servodyn_traffic(cell: Cell, bus: Bus) -> list[Traffic]:
    modules = [(axis.name, axis.drive.module) for axis in cell.axis if axis.drive.bus == bus.name and axis.drive.module is not None]
    plan = [Traffic("SYNC", SYNC_ID, 0)]
    plan += [Traffic(f"set value {name}", set_id(module), DRIVE_BYTES) for name, module in modules]
    plan += [Traffic(f"actual value {name}", actual_id(module), DRIVE_BYTES) for name, module in modules]
    return plan + block_traffic(cell, bus)


def canopen_traffic(cell: Cell, bus: Bus) -> list[Traffic]:
    nodes = [(axis.name, axis.drive.node) for axis in cell.axis if axis.drive.bus == bus.name and axis.drive.node is not None]
    plan = [Traffic("SYNC", cobid.SYNC, 0)]
    plan += [Traffic(f"RPDO1 {name}", cobid.rpdo(1, node), COMMAND_AND_POSITION) for name, node in nodes]
    plan += [Traffic(f"TPDO1 {name}", cobid.tpdo(1, node), COMMAND_AND_POSITION) for name, node in nodes]
    if nodes and canopen_room(cell, bus, cell.cycle_ms):
        plan += [Traffic(f"TPDO2 {name}", cobid.tpdo(2, node), COMMAND_AND_POSITION) for name, node in nodes]
    beat = float(bus.heartbeat_ms)
    plan += [Traffic("heartbeat gateway", cobid.heartbeat(GATEWAY_NODE), 1, beat)]
    plan += [Traffic(f"heartbeat {name}", cobid.heartbeat(node), 1, beat) for name, node in nodes]
    first = nodes[0][1] if nodes else 1
    return [
        *plan,
        Traffic("SDO request", cobid.sdo_request(first), DRIVE_BYTES, acyclic=True),
        Traffic("SDO answer", cobid.sdo_answer(first), DRIVE_BYTES, acyclic=True),
    ]


def block_traffic(cell: Cell, bus: Bus) -> list[Traffic]:
    """I/O blocks of P31 and P32; the n-th CAN bus of the cell is the rho 3's bus n."""
    number = 1 + [one.name for one in cell.bus].index(bus.name)
    if cell.rho3 is None:
        return []
    inputs = [Traffic(f"input block {block.id}", block.id, block.length) for block in cell.rho3.P31 if block.bus == number]
    return inputs + [Traffic(f"output block {block.id}", block.id, block.length) for block in cell.rho3.P32 if block.bus == number]
