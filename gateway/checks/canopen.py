"""CANopen buses: node numbers, data sheets, one controlword, no identifier with two senders (also when two protocols share a port)."""

from collections.abc import Iterator

from drivers.drives.canopen_plan import Used, collisions, dictionary_map_faults, gateway_identifiers, io_pdos, node_identifiers, restricted
from drivers.drives.cia402_boot import default_pdos, probe_pdos
from drivers.drives.cia402_family import GATEWAY_NODE
from gateway.assembly.programs import probe_of
from gateway.checks.context import Context
from gateway.files.eds_sheets import read_eds
from gateway.files.stop_report import UNTESTED, NoEvidence, stop_evidence
from gateway.pure.cell.cell import Axis, Bus, Cell, Notice
from gateway.registry import BUS_PROTOCOLS, DRIVE_FAMILIES
from protocols.servodyn import plan

SHOWN = 3  # faults of a data sheet reported one by one


def nodes(check: Context) -> None:
    """The gateway's own number is occupied; a data sheet may not map 6040h twice."""
    for axis in check.cell.axis:
        if not DRIVE_FAMILIES[axis.drive.type].objects:
            continue
        key = f"axis.{axis.name}.drive"
        if axis.drive.node == GATEWAY_NODE:
            check.fault(f"{key}.node", axis.drive.node, "the gateway's heartbeat is node 127", "1..126")
        sheet = read_eds(check.cell, axis, simulated=False)
        for fault in dictionary_map_faults(sheet.dictionary, axis.drive.node or 1) if sheet is not None else ():
            check.fault(f"{key}.eds", axis.drive.eds, fault)


def identifiers(check: Context) -> None:
    """All identifiers on one CAN port, of any protocol."""
    ports: dict[str, list[Bus]] = {}
    for bus in check.cell.bus:
        ports.setdefault(bus.name if bus.port == "sim" else bus.port, []).append(bus)
    for on_it in ports.values():
        if not any(BUS_PROTOCOLS[bus.protocol].nodes for bus in on_it):
            continue
        used = [entry for bus in on_it for entry in used_on(check.cell, bus)]
        for fault in (*collisions(used), *restricted(used)):
            check.fault(f"bus.{on_it[-1].name}", "", fault)


def used_on(cell: Cell, bus: Bus) -> list[Used]:
    """Identifiers of one bus."""
    axes = [axis for axis in cell.axis if axis.drive.bus == bus.name]
    if BUS_PROTOCOLS[bus.protocol].nodes:
        found = gateway_identifiers(GATEWAY_NODE)
        for axis in {axis.drive.node: axis for axis in reversed(axes)}.values():  # a node used twice is a fault of `drives`
            if axis.drive.node is not None:
                measuring = probe_of(cell, axis.name)
                pdos = default_pdos(axis.drive.node, torque=True)
                if measuring is not None:
                    pdos = probe_pdos(axis.drive.node, measuring.probe, pdos)
                found += node_identifiers(axis.drive.node, f"axis {axis.name}", pdos)
        for node in sorted({io.device.node for io in cell.io if io.device.bus == bus.name and io.device.node is not None}):
            found += node_identifiers(node, f"coupler {node}", io_pdos(node))
        return found
    found = [Used(plan.SYNC_ID, "SYNC of SERVODYN")]
    for axis in axes:
        if axis.drive.module is not None:
            found += [Used(plan.set_id(axis.drive.module), f"set value of axis {axis.name}")]
            found += [Used(plan.actual_id(axis.drive.module), f"actual value of axis {axis.name}")]
    blocks = (*cell.rho3.P31, *cell.rho3.P32) if cell.rho3 is not None else ()
    number = cell.bus.index(bus) + 1
    return found + [Used(block.id, f"I/O block {block.id}") for block in blocks if block.bus == number]


def sheets(cell: Cell) -> Iterator[Notice]:
    """Data sheets that are missing or faulty: the ignored entries and the reason."""
    named: dict[str, list[Axis]] = {}
    for axis in cell.axis:
        if DRIVE_FAMILIES[axis.drive.type].objects and axis.drive.eds:
            named.setdefault(axis.drive.eds, []).append(axis)
    for name, axes in named.items():
        sheet = read_eds(cell, axes[0], simulated=False)
        where = f"axis {', '.join(axis.name for axis in axes)}"
        if sheet is None:
            text = f"{name}: no such EDS file; --sim uses that of the emulated drive, a real bus needs that of the drive maker"
            yield Notice("note", where, text)
            continue
        for fault in sheet.faults[:SHOWN]:
            yield Notice("note", where, f"{sheet.path.name} {fault}")
        if len(sheet.faults) > SHOWN:
            yield Notice("note", where, f"{sheet.path.name}: {len(sheet.faults) - SHOWN} more faults")


def stop_evidences(check: Context) -> None:
    """A report that proves nothing for a drive cannot replace its 6007h."""
    for axis in check.cell.axis:
        key, given = f"axis.{axis.name}.stop_evidence", axis.stop_evidence
        if given and not DRIVE_FAMILIES[axis.drive.type].objects:
            check.fault(key, given, "only CiA 402 drives have 6007h; a SERVODYN drive stops by its own supervision: omit it")
        elif given not in ("", UNTESTED):
            try:
                stop_evidence(check.cell, axis)
            except NoEvidence as error:
                check.fault(key, given, str(error))


def without_6007h(cell: Cell) -> Iterator[Notice]:
    """Drives that are accepted by another evidence than their own 6007h."""
    for axis in cell.axis:
        where = f"axis {axis.name}"
        if axis.stop_evidence == UNTESTED:
            text = 'stop_evidence = "untested": a drive without 6007h is accepted although its stop at bus loss was never measured'
            yield Notice("warning", where, f"{text}; only for the cell of the loss test: axisgate drive loss-test CELL --running")
        elif axis.stop_evidence:
            found = stop_evidence(cell, axis)
            text = f"a drive without 6007h is accepted: {found.file}, measured {found.wall} with axis {found.axis}"
            yield Notice("note", where, f"{text}, reacted after {found.reaction_ms:g} ms; 1016h is read back at each start")


CHECKS = (nodes, identifiers, stop_evidences)
NOTES = (sheets, without_6007h)
