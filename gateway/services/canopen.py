"""All CANopen buses of a run for the services: their masters, and the faults of each axis; loaded only if there is one."""

from collections.abc import Callable

from gateway.assembly.run import RunPlan
from gateway.pure.image.records.cell import AxisFlag, CellState
from gateway.registry import BUS_PROTOCOLS
from gateway.services.drive_parameters import Master, Parameters
from gateway.services.part import Part

Write = Callable[..., None]  # Journal.write


class CanopenServices(Part):
    """Masters by bus; `observe` every state the cycle publishes."""

    def __init__(self, plan: RunPlan, fds: dict[str, int], write: Write) -> None:
        self.masters: dict[str, Master] = {}
        self.parameters = Parameters(self.place, write)
        self._places: dict[int, tuple[str, int]] = {}  # axis -> bus, node
        self._names: dict[str, tuple[str, int]] = {}
        self._generation: int | None = None
        self._language = plan.cell.cell.language
        buses = [bus for bus in plan.cell.bus if bus.name in plan.buses]
        if not any(BUS_PROTOCOLS[bus.protocol].nodes for bus in buses):
            return
        from gateway.assembly.canopen_nodes import node_plans
        from gateway.assembly.contacts import coupler_plans
        from gateway.files.eds_sheets import read_eds
        from gateway.links.canopen import master as canopen_master
        from gateway.links.canopen.ring_link import Rings

        self.rings = Rings(fds["acyclic"], fds["heard"], len(buses))
        for number, bus in enumerate(buses):
            if not BUS_PROTOCOLS[bus.protocol].nodes:
                continue
            here = {axis.drive.node: (n, axis) for n, axis in enumerate(plan.cell.axis) if axis.drive.bus == bus.name and axis.drive.node}
            read = {axis.drive.eds: read_eds(plan.cell, axis, simulated=plan.simulated) for _, axis in here.values()}
            sheets = {node: sheet.dictionary for node, (_, axis) in here.items() if (sheet := read[axis.drive.eds]) is not None}
            nodes = [*node_plans(plan.cell, bus, plan.p5_ms, simulated=plan.simulated), *coupler_plans(plan.cell, bus)]
            self.masters[bus.name] = canopen_master.CanopenMaster(
                bus.name,
                self.rings.links[number],
                nodes,
                lambda kind, words, facts: write(kind, words, **facts),
                sheets,
                self._language,
                plan.p5_ms / 1000.0,
            )
            self._places |= {n: (bus.name, node) for node, (n, _) in here.items()}
            self._names |= {axis.name: (bus.name, node) for node, (_, axis) in here.items()}

    async def close(self) -> None:
        """Nodes stay as they are."""
        self.parameters.stop()
        if self._generation is not None:
            for master in self.masters.values():
                master.stop()

    def observe(self, state: CellState) -> None:
        """The nodes of the first cycle are adopted if it uses them; a new cycle has none: all are started up."""
        if not self.masters or state.generation in (0, self._generation):
            return
        first, self._generation = self._generation is None, state.generation
        for bus, master in self.masters.items():
            if first:
                spoken = [
                    node for n, (name, node) in self._places.items() if name == bus and not state.axes[n].flags & AxisFlag.UNCONFIGURED
                ]
                master.start(spoken)
            else:
                master.again()

    def coupler_fault(self, bus: str, node: int) -> str:
        """Why an I/O coupler, or its outputs, are not served; empty: they are."""
        master = self.masters.get(bus)
        found = master.nodes.get(node) if master is not None else None
        return found.why if found is not None else ""

    def place(self, axis: str) -> tuple[Master, int]:
        """Master and node of an axis; KeyError in words for one that is not on CANopen."""
        if axis not in self._names:
            raise KeyError(f"axis {axis} has no CANopen drive; those with one: {', '.join(self._names) or 'none'}")
        name, node = self._names[axis]
        return self.masters[name], node

    def why_not(self, axis: int) -> str:
        """Why this axis' drive is not ready; empty: it is, or it is not on these buses."""
        place = self._places.get(axis)
        if place is None:
            return ""
        node = self.masters[place[0]].nodes[place[1]]
        return node.why or node.health.value if node.health.name != "READY" else ""

    def fault(self, axis: int, code: int) -> str:
        """A fault in words; empty for a drive of another family."""
        if axis not in self._places:
            return ""
        from drivers.drives.cia402_words import sentence

        return sentence(code, self._language) if code else "(no emergency message received)"

    def status(self) -> dict[str, object]:
        """For `links`; nothing for a cell without CANopen."""
        if not self.masters:
            return {}
        short = ("node", "axis", "health", "why", "emergency")
        return {"nodes": [{key: row[key] for key in short} for master in self.masters.values() for row in master.status()]}
