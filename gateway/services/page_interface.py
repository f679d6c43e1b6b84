"""The services' side of the page: a command source of its own beside the commissioning tools', and what only a page asks for.

Requests come as those of tools do (gateway.services.tool_server), with "door": 91.  look: data
blocks, named values, forces; tap: characters of the lines, requests of the Modbus servers; force_input, unforce_input: RC inputs
(AX-472); force_words, unforce_words: data words (AX-498).
"""

import time
from typing import TYPE_CHECKING

from gateway.pure.arbitration.block_keys import block_name
from gateway.pure.cell.web import PAGE_DOOR
from gateway.pure.image.records.cell import set_bit
from gateway.services.sources.modbus import ModbusSource
from gateway.services.sources.rk512 import Rk512Source
from gateway.services.sources.serial import SerialSource
from gateway.services.tool_interface import ENABLING_BITS, ENABLING_BYTE, ToolInterface
from protocols.base.machine import Damage, Ns

if TYPE_CHECKING:
    from gateway.services.loop import Services


class PageInterfaces:
    """The interfaces of tools and page, each a command source with its own life."""

    def __init__(self, services: "Services") -> None:
        self._services = services
        self.forces = services.forces
        self._tool = ToolInterface(services)
        self._page = ToolInterface(services, PAGE_DOOR, "page")

    @property
    def permits(self) -> bool:
        """One of them has set the enabling inputs of a simulated cell."""
        return self._tool.permits or self._page.permits

    def wake(self, now: Ns) -> None:
        """A silent one is a dead one."""
        self._tool.wake(now)
        kept = self._page.permits  # what the page shows as set stays set until somebody clears it, also while it asks for nothing
        self._page.wake(now)
        self._page.permits = kept

    def closed(self, connection: object) -> None:
        """A connection has ended."""
        self._tool.closed(connection)
        self._page.closed(connection)

    def holds(self, connection: object) -> bool:
        """This tool is in control."""
        return self._tool.holds(connection)

    def held_by_another(self, connection: object) -> bool:
        """A tool other than this one is in control."""
        return self._tool.held_by_another(connection)

    def answer(self, request: dict[str, object], connection: object = "") -> dict[str, object] | None:
        """None: not for this part.  KeyError, ValueError: reported as an error."""
        if request.get("door") != PAGE_DOOR:
            return self._tool.answer(request, connection)
        match request.get("op"):
            case "look":
                return self._look()
            case "tap":
                return self._tapped(request)
            case "permit" if request.get("on") is False:
                return self._clear_permits()
            case "force_input" | "unforce_input" as op:
                return self._force(request, lay=op == "force_input")
            case "force_words" | "unforce_words" as op:
                return self._force_words(request, lay=op == "force_words")
        return self._page.answer(request, connection)

    def _clear_permits(self) -> dict[str, object]:
        """The enabling inputs of a simulation go off again."""
        services, now = self._services, time.monotonic_ns()
        if not services.plan.simulated:
            return {"error": "enabling inputs are set by their command source; the page may do it in a simulation only"}
        self._page.permits = False
        for bit in ENABLING_BITS:
            set_bit(services.inputs.values, bit, False)
        services.inputs.stamps[ENABLING_BYTE] = now
        services.flush()
        return {"ok": True}

    def _look(self) -> dict[str, object]:
        """Bytes of every data block, named values with quality and age in ms, contacts, forced inputs."""
        services, now = self._services, time.monotonic_ns()
        blocks: dict[str, dict[str, object]] = {}
        for door in services.doors:
            if isinstance(door, Rk512Source):
                for number in sorted(door.data.blocks) if door.data is not None else (10, 11, 20, 21):
                    data = door.block_bytes(number)
                    blocks[str(number)] = {"line": door.name, "hex": (data or b"").hex(), "alive": door.watch.alive}
        named: dict[str, list[object]] = {}
        for name in services.named.names():
            sample = services.named.sample(name)
            age = round((now - sample.stamp_ns) / 1e6) if sample.stamp_ns else None
            named[name] = [sample.value, int(sample.quality), age, sample.source]
        return {"blocks": blocks, "named": named, "contacts": services.contacts.values(), **self._forced()}

    def _forced(self) -> dict[str, object]:
        """RC inputs with their values; words as block:word with the mask of forced bits."""
        words = {f"{block}:{word}": mask for (block, word), (mask, _) in self.forces.words.items()}
        return {"forced": {str(bit): int(value) for bit, value in self.forces.bits.items()}, "forced_words": words}

    def _tapped(self, request: dict[str, object]) -> dict[str, object]:
        """{line: [[number, stamp ns, side, hex or kind of damage]]} after the numbers given for each line."""
        since = request.get("since")
        seen = since if isinstance(since, dict) else {}
        found: dict[str, object] = {}
        for door in self._services.doors:
            if isinstance(door, SerialSource) and door.tap is not None:
                pieces = door.tap.since(int(seen.get(door.name, 0)))
                found[door.name] = [[n, at, side, f"!{w.name}" if isinstance(w, Damage) else w.hex()] for n, at, side, w in pieces]
        servers = {
            door.name: [exchange.row() for exchange in door.server.desk.since(int(seen.get(door.name, 0)))]
            for door in self._services.doors
            if isinstance(door, ModbusSource)
        }
        return {"lines": found, "modbus": servers}

    def _force(self, request: dict[str, object], *, lay: bool) -> dict[str, object]:
        services, who = self._services, str(request.get("who", "page"))
        bit = request.get("bit")
        number = None if bit is None else int(str(bit))
        if not lay:
            self.forces.drop(number)
            if number is None:
                self._end_words(list(self.forces.words))
            words = f"force of RC input {number} ended" if number is not None else "all forces ended"
        else:
            if number is None:
                raise ValueError("bit: number of an RC input")
            if number in ENABLING_BITS and not services.plan.simulated:
                raise ValueError(f"RC input {number} is an enabling input: it is forced in a simulation only")
            value = bool(int(str(request["value"])))
            self.forces.put(number, value, time.monotonic_ns())
            words = f"RC input {number} forced to {int(value)}"
        services.journal.write("force", f"{words} by {who}", bit=number, who=who)
        services.flush()
        return {"ok": True, **self._forced()}

    def _force_words(self, request: dict[str, object], *, lay: bool) -> dict[str, object]:
        """{"block": key, "words": [[word, mask, value], ...]}: taken whole, so that no half of a double word stands alone."""
        services, who, key = self._services, str(request.get("who", "page")), int(str(request["block"]))
        door = next((each for each in services.doors if isinstance(each, Rk512Source) and each.data and key in each.data.blocks), None)
        if door is None or door.data is None:
            raise ValueError(f"{block_name(key)}: no line of this cell declares it")
        block, rows = door.data.blocks[key], request["words"]
        if lay and block.from_plc and not services.plan.simulated:
            raise ValueError(f"{block_name(key)} is the PLC's: its words command axes and are forced in a simulation only")
        if not isinstance(rows, list) or any(not 0 <= int(word) < block.words for word, _, _ in rows):
            raise ValueError(f"{block_name(key)}: words 0..{block.words - 1}")
        for word, mask, value in rows:
            if lay:
                self.forces.put_word((key, int(word)), int(mask), int(value))
            else:
                self.forces.drop_word((key, int(word)), int(mask))
        door.data.forces_changed(key, time.monotonic_ns())
        told = ", ".join(f"DW {word} to {value:04X}h" if lay else f"DW {word}" for word, _, value in rows)
        services.journal.write("force", f"{block_name(key)} {told} {'forced' if lay else 'no longer forced'} by {who}", block=key, who=who)
        services.flush()
        return {"ok": True, **self._forced()}

    def _end_words(self, places: list[tuple[int, int]]) -> None:
        for place in places:
            self.forces.drop_word(place)
        for key in {key for key, _ in places}:
            for door in self._services.doors:
                if isinstance(door, Rk512Source) and door.data is not None and key in door.data.blocks:
                    door.data.forces_changed(key, time.monotonic_ns())
