"""Ports of a cell that a run does not open because the cell's target is the simulation."""

from gateway.pure.cell.cell import Cell

UNUSED = 'target = "simulation": everything is simulated, not used: {ports}'
SIM = "sim"


def unused_ports(cell: Cell, *, bus: bool = True) -> str:
    """Return the sentence that names them; empty: there are none.  bus: include those of CAN buses (`run --bus` sets another one)."""
    if cell.cell.target != "simulation":
        return ""
    ports = [f"line {line.name} ({line.port})" for line in cell.line if line.port != SIM]
    ports += [f"bus {each.name} ({each.port})" for each in cell.bus if bus and each.port != SIM]
    ports += [f"modbus {each.name} ({each.port_})" for each in cell.modbus if each.serial and each.port_ != SIM]
    ports += [f"io {each.name} (gpiochip)" for each in cell.io if each.device.type == "gpiochip"]
    return UNUSED.format(ports=", ".join(ports)) if ports else ""
