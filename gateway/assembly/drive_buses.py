"""Drive family of a bus, by its `protocol`: the frames of the cycle there.  Loads nothing large."""

from drivers.drives.family import BusFamily
from gateway.pure.cell.cell import Bus, Cell
from gateway.registry import BUS_PROTOCOLS

LISTENS = "listens only: no layout_evidence, and the SERVODYN layout is axisgate's own (AX-001); nothing is sent"
DRIVE_PROTOCOLS = tuple(BUS_PROTOCOLS)  # buses the cycle owns
MISSED = 3  # heartbeats of the gateway that may stay away (AX-303)


def listening(cell: Cell, *, simulated: bool) -> tuple[str, ...]:
    """Buses that are only listened to: real ones with SERVODYN drives and no evidence for their layout (design 5; AX-436)."""
    if simulated or cell.cell.target == "simulation":
        return ()
    return tuple(bus.name for bus in cell.bus if BUS_PROTOCOLS[bus.protocol].boosted and not bus.simulated and not bus.layout_evidence)


def make_family(cell: Cell, bus: Bus, p5_ms: int, *, simulated: bool = False) -> BusFamily:
    """The family of one drive bus with the axes of the cell on it."""
    if bus.name in listening(cell, simulated=simulated):
        from drivers.drives.listening import ListeningFamily

        return ListeningFamily()
    return BUS_PROTOCOLS[bus.protocol].family(cell, bus, p5_ms)


def canopen_family(cell: Cell, bus: Bus, p5_ms: int) -> BusFamily:
    """CiA 402 drives, and couplers where the cell has contacts."""
    from drivers.drives.cia402_family import Cia402Family
    from gateway.assembly.contacts import with_couplers

    on_it = [(n, axis) for n, axis in enumerate(cell.axis) if axis.drive.bus == bus.name]
    nodes = [(n, axis.drive.node) for n, axis in on_it if axis.drive.node is not None]
    beat = max(1, bus.heartbeat_ms // p5_ms)
    named = {name: each.probe for each in cell.measuring for name in each.drives}
    probes = {axis.drive.node: named[axis.name] for _, axis in on_it if axis.drive.node is not None and axis.name in named}
    family = Cia402Family(nodes, beat, (MISSED + 1) * bus.heartbeat_ms // p5_ms + 1, probes)
    return with_couplers(cell, bus, family, p5_ms) if cell.io else family


def servodyn_family(cell: Cell, bus: Bus) -> BusFamily:
    """SERVODYN drives, and I/O blocks of the rho 3."""
    from drivers.drives.servodyn_family import ServodynFamily
    from gateway.assembly.rho3_buses import with_rho3
    from gateway.files.dbc import load_servodyn
    from gateway.files.find import beside

    modules = [(n, axis.drive.module) for n, axis in enumerate(cell.axis) if axis.drive.bus == bus.name and axis.drive.module is not None]
    return with_rho3(cell, bus, ServodynFamily(load_servodyn(beside(cell.file, bus.layout, "drives")), modules))
