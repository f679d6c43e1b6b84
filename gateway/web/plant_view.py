"""The emulator panel: cables to pull and drives to fault, through the sockets `axisgate fault` uses.  Simulated cells only (AX-476)."""

import contextlib
from typing import Any

from drivers.emulator.cia402.errors import CAUSES as CIA402_CAUSES
from drivers.emulator.servodyn.axis import CAUSES as SERVODYN_CAUSES
from drivers.ports.base import runtime_dir
from gateway.assembly.run import RunPlan
from gateway.observer.tool_link import Gone, Hand, Refused
from gateway.registry import DRIVE_FAMILIES

Row = dict[str, Any]
PLAIN = ("stuck_encoder", "wrong_sign", "true_encoder", "power_off", "power_on")
BY_NODE = ("reset_node", "bus_off", "bus_on")


class Plant:
    """Controls everything simulated of one run."""

    def __init__(self, plan: RunPlan) -> None:
        self.plan = plan
        folder = runtime_dir()
        simulated = plan.simulated
        self.cables = {
            line: Hand(str(folder / f"line-{plan.slug}-{line}.sock"), f"line {line}")
            for line, url in plan.lines.items()
            if simulated and url.startswith("pty:")
        }
        self.emulators = {
            bus: Hand(str(folder / f"emulator-{plan.slug}-{bus}.sock"), f"emulator {bus}")
            for bus in plan.buses
            if simulated and any(axis.drive.bus == bus for axis in plan.cell.axis)
        }

    def known(self) -> list[Row]:
        """Emulated drives with the faults they know."""
        rows = []
        for axis in self.plan.cell.axis:
            if axis.drive.bus not in self.emulators:
                continue
            servodyn = DRIVE_FAMILIES[axis.drive.type].boosted
            faults = [*PLAIN, *(() if servodyn else BY_NODE), "force_fault"]
            switched = [*(SERVODYN_CAUSES if servodyn else CIA402_CAUSES), "stick_brake"]
            key = {"axis": axis.drive.module} if servodyn else {"node": axis.drive.node}
            rows.append({"axis": axis.name, "emulator": axis.drive.bus, "key": key, "faults": faults, "switched": switched})
        return rows

    async def look(self) -> Row:
        """State of every cable and emulator; one that does not answer is marked."""
        cables: dict[str, Row] = {}
        for line, hand in self.cables.items():
            cables[line] = await _status(hand, "status")
        emulators: dict[str, Row] = {}
        for bus, hand in self.emulators.items():
            emulators[bus] = await _status(hand, "state")
        return {"cables": cables, "emulators": emulators}

    async def cable(self, line: str, do: str, **arguments: object) -> Row:
        """plug, unplug, remove, insert, damage, calm.  KeyError: no such cable; Gone, Refused."""
        return await self.cables[line].ask(do, **arguments)

    async def fault(self, emulator: str, do: str, **arguments: object) -> Row:
        """One fault of an emulated drive or of its frames.  KeyError, Gone, Refused."""
        return await self.emulators[emulator].ask(do, **arguments)

    def close(self) -> None:
        for hand in (*self.cables.values(), *self.emulators.values()):
            hand.close()


async def _status(hand: Hand, do: str) -> Row:
    with contextlib.suppress(Gone):
        try:
            return await hand.ask(do)
        except Refused as why:
            return {"why": str(why)}
    return {"why": "no answer"}
