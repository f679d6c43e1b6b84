"""The services' side of the page: a command source separate from the commissioning tools', and requests that only a page sends.

Requests have the form of the tools' requests (gateway.services.tool_server), with "source": 91.  look: data
blocks, named values, forces; tap: characters of the lines, requests of the Modbus servers; force_input, unforce_input: RC inputs
(AX-472); force_words, unforce_words: data words (AX-498).
"""

from collections.abc import Sequence

from gateway.pure.arbitration.block_keys import block_name
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.cell.web import PAGE_SOURCE
from gateway.services.canopen import CanopenServices
from gateway.services.contacts import DigitalContacts
from gateway.services.context import RunContext
from gateway.services.part import Part
from gateway.services.shared_image import SharedImage
from gateway.services.sources.base import BaseSource
from gateway.services.tool_interface import ENABLING_BITS, ENABLING_BYTE, TOOL_SOURCE, ToolInterface
from gateway.services.value_directory import ValueDirectory
from protocols.base.machine import Ns


class PageInterfaces(Part):
    """The interfaces of tools and page, each a command source with its own life."""

    def __init__(
        self,
        run: RunContext,
        image: SharedImage,
        values: ValueDirectory,
        dispatcher: CommandDispatcher,
        canopen: CanopenServices,
        contacts: DigitalContacts,
        sources: Sequence[BaseSource],
    ) -> None:
        self._run, self._image, self._values, self._contacts, self._sources = run, image, values, contacts, sources
        self.forces = image.forces
        self._tool = ToolInterface(run, image, dispatcher, canopen)
        self._page = ToolInterface(run, image, dispatcher, canopen, PAGE_SOURCE, "page")

    @property
    def permits(self) -> bool:
        """One of them has set the enabling inputs of a simulated cell."""
        return self._tool.permits or self._page.permits

    def step(self, now: Ns) -> None:
        """A silent one is a dead one."""
        self._tool.wake(now)
        kept = self._page.permits  # enabling inputs shown as set stay set until they are cleared, also while the page is silent
        self._page.wake(now)
        self._page.permits = kept

    def closed(self, connection: object) -> None:
        """A connection has ended."""
        self._tool.closed(connection)
        self._page.closed(connection)

    def holds(self, connection: object) -> bool:
        """This tool is in control."""
        return self._tool.holds(connection)

    def source_of(self, connection: object, *, page: bool) -> int:
        """The command source of a connection that is in control; 0: it is not."""
        if page:
            return PAGE_SOURCE if self._page.holds(connection) else 0
        return TOOL_SOURCE if self._tool.holds(connection) else 0

    def held_by_another(self, connection: object) -> bool:
        """A tool other than this one is in control."""
        return self._tool.held_by_another(connection)

    def answer(self, request: dict[str, object], connection: object = "") -> dict[str, object] | None:
        """None: not for this part.  KeyError, ValueError: reported as an error."""
        if request.get("source") != PAGE_SOURCE:
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
        if not self._run.plan.simulated:
            return {"error": "enabling inputs are set by their command source; the page may do it in a simulation only"}
        self._page.permits = False
        for bit in ENABLING_BITS:
            self._image.put_bit(bit, False)
        self._image.judge((ENABLING_BYTE,), self._image.inputs.quality[ENABLING_BYTE], self._run.clock())
        self._image.pass_on()
        return {"ok": True}

    def _look(self) -> dict[str, object]:
        """Bytes of every data block, named values with quality and age in ms, contacts, forced inputs."""
        now, store = self._run.clock(), self._values.named
        blocks: dict[str, dict[str, object]] = {}
        for line in self._values.lines:
            for number in sorted(line.data.blocks) if line.data is not None else (10, 11, 20, 21):
                data = line.block_bytes(number)
                blocks[str(number)] = {"line": line.name, "hex": (data or b"").hex(), "alive": line.watch.alive}
        named: dict[str, list[object]] = {}
        for name in store.names():
            sample = store.sample(name)
            age = round((now - sample.stamp_ns) / 1e6) if sample.stamp_ns else None
            named[name] = [sample.value, int(sample.quality), age, sample.source]
        return {"blocks": blocks, "named": named, "contacts": self._contacts.values(), **self._forced()}

    def _forced(self) -> dict[str, object]:
        """RC inputs with their values; words as block:word with the mask of forced bits."""
        words = {f"{block}:{word}": mask for (block, word), (mask, _) in self.forces.words.items()}
        return {"forced": {str(bit): int(value) for bit, value in self.forces.bits.items()}, "forced_words": words}

    def _tapped(self, request: dict[str, object]) -> dict[str, object]:
        """{line: [[number, stamp ns, side, hex or kind of damage]]} after the numbers given for each line."""
        since = request.get("since")
        seen = since if isinstance(since, dict) else {}
        found: dict[str, dict[str, object]] = {"lines": {}, "modbus": {}}
        for source in self._sources:
            passed = source.passed(int(seen.get(source.name, 0)))
            if passed is not None:
                found[source.medium][source.name] = passed
        return {"lines": found["lines"], "modbus": found["modbus"]}

    def _force(self, request: dict[str, object], *, lay: bool) -> dict[str, object]:
        who = str(request.get("who", "page"))
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
            if number in ENABLING_BITS and not self._run.plan.simulated:
                raise ValueError(f"RC input {number} is an enabling input: it is forced in a simulation only")
            value = bool(int(str(request["value"])))
            self.forces.put(number, value, self._run.clock())
            words = f"RC input {number} forced to {int(value)}"
        self._run.journal.write("force", f"{words} by {who}", bit=number, who=who)
        self._image.pass_on()
        return {"ok": True, **self._forced()}

    def _force_words(self, request: dict[str, object], *, lay: bool) -> dict[str, object]:
        """{"block": key, "words": [[word, mask, value], ...]}: all or none, so that a double word is never half forced."""
        who, key = str(request.get("who", "page")), int(str(request["block"]))
        line = next((each for each in self._values.lines if each.data and key in each.data.blocks), None)
        if line is None or line.data is None:
            raise ValueError(f"{block_name(key)}: no line of this cell declares it")
        block, rows = line.data.blocks[key], request["words"]
        if lay and block.from_plc and not self._run.plan.simulated:
            raise ValueError(f"{block_name(key)} is the PLC's: its words command axes and are forced in a simulation only")
        if not isinstance(rows, list) or any(not 0 <= int(word) < block.words for word, _, _ in rows):
            raise ValueError(f"{block_name(key)}: words 0..{block.words - 1}")
        for word, mask, value in rows:
            if lay:
                self.forces.put_word((key, int(word)), int(mask), int(value))
            else:
                self.forces.drop_word((key, int(word)), int(mask))
        line.data.forces_changed(key, self._run.clock())
        entries = ", ".join(f"DW {word} to {value:04X}h" if lay else f"DW {word}" for word, _, value in rows)
        self._run.journal.write(
            "force", f"{block_name(key)} {entries} {'forced' if lay else 'no longer forced'} by {who}", block=key, who=who
        )
        self._image.pass_on()
        return {"ok": True, **self._forced()}

    def _end_words(self, places: list[tuple[int, int]]) -> None:
        for place in places:
            self.forces.drop_word(place)
        for key in {key for key, _ in places}:
            for line in self._values.lines:
                if line.data is not None and key in line.data.blocks:
                    line.data.forces_changed(key, self._run.clock())
