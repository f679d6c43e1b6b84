"""The door of a serial line: 3964R below, RK512 above, and either the cell's own data blocks or the standard command block.

Where the cell declares no blocks, DB 10 is the command block, DB 11 the status block; DB 20 and DB 21 are the RC inputs and outputs
(AX-012).
"""

import struct
import time
from typing import TYPE_CHECKING

from drivers.ports.open import open_bytes
from gateway.assembly import Door
from gateway.cell import Db, Entry, Handshake, Line
from gateway.doors import BaseDoor, Tell
from gateway.image import RegionWriter
from gateway.linejournal import journaled
from gateway.lineloop import LineRunner
from gateway.pure.addresses import DataBit, DataWord, Part, parse
from gateway.pure.command_block import COMMAND_WORDS, STATUS_WORDS, Code, Command
from gateway.pure.computerlink import ComputerLink
from gateway.pure.datadoor import RC_NAMES, DataBlock, DataDoor, HandshakeBits, Slot
from gateway.pure.dialects import BUEP64, buep64_fault, link_profile, rk512_dialect
from gateway.pure.office import Office, OnLoss
from gateway.pure.records import RC_BYTES, Motion, Quality, set_bit
from gateway.pure.supervision import LinkWatch
from protocols.base.machine import Ns
from protocols.base.step5 import Step5Type
from protocols.p3964r.profiles import Priority
from protocols.rk512.active import Active, Denied, Done, Failed, Unasked
from protocols.rk512.header import ErrorNumber
from protocols.rk512.passive import Continued, Fetched, Refused, UnexpectedReaction, Written
from protocols.rk512.station import Repeated

if TYPE_CHECKING:
    from gateway.processes.services import Services

COMMAND_DB, STATUS_DB, INPUTS_DB, OUTPUTS_DB = 10, 11, 20, 21


class LineDoor(BaseDoor):
    """One serial line to a PLC."""

    def __init__(
        self,
        door: Door,
        office: Office,
        watch: LinkWatch,
        on_loss: OnLoss,
        region: RegionWriter,
        tell: Tell,
        line: Line,
        services: "Services",
    ) -> None:
        super().__init__(door, office, watch, on_loss, region, tell)
        self.line = line
        self._services = services
        blocks = [compile_block(db) for db in services.cell.db if db.line == line.name]
        self.data = self._data_door(blocks) if blocks else None
        self._partner = dict.fromkeys(("sends", "fetches", "refused", "bad_blocks", "own_jobs", "own_faults"), 0)
        self._life: int | None = None
        self._life_place = _word_of(line.supervision.life_word)
        priority = Priority.HIGH if line.priority == "high" else Priority.LOW
        self.machine = ComputerLink(link_profile(line), priority, self, rk512_dialect(line), line.baud)
        self._runner: LineRunner[object] | None = None
        self._journal_next: Ns = 0
        tell(
            "link", f"door {self.number} {self.name}: {line.protocol} {line.profile} on {services.plan.lines[line.name]}", door=self.number
        )

    def _data_door(self, blocks: list[DataBlock]) -> DataDoor:
        services = self._services
        handshake = services.cell.handshake.get("move")

        def command(fresh: Command) -> None:
            self.office.command(self.number, fresh, time.monotonic_ns())

        def bad_number(name: str, words: str) -> None:
            self._tell("command", f"door {self.number}: {words}", door=self.number, what="refused")

        def level(name: str, value: bool) -> None:
            number: int = getattr(services.numbers, RC_NAMES[name])
            octet = number >> 3
            if services.owned.get(octet) == self.number:
                set_bit(services.inputs.values, number, value)
                services.inputs.quality[octet], services.inputs.stamps[octet] = Quality.GOOD, time.monotonic_ns()

        names = [axis.name for axis in services.cell.axis]

        def value(name: str) -> float:
            return services.values.get(name, self)

        return DataDoor(blocks, names, compile_handshake(handshake) if handshake else None, command, value, bad_number, level)

    # ---- life --------------------------------------------------------------------------------------------------------
    def open(self, url: str) -> None:
        """Start the line; inside the running loop."""
        machine = journaled(self.machine, self._services.plan, self.line)
        self._runner = LineRunner[object](lambda: open_bytes(url, self.line.format), machine, self._on_event)

    def close(self) -> None:
        if self._runner is not None:
            self._runner.close()

    def restart(self) -> None:
        """Edges and toggle are adopted from the next telegram (AX-141)."""
        super().restart()
        if self.data is not None:
            self.data.restart()

    def settle(self) -> None:
        """At each tick: the handshake's outcome, and control given back at rest."""
        if self.data is None:
            return
        job = self.office.door(self.number).by_code.get(Code.PTP_ABSOLUTE)
        if job is not None:
            self.data.move_state(job.state)
        state = self._services.values.state
        self.data.settle(at_rest=state.motion in (Motion.IDLE, Motion.STOPPED))

    @property
    def active(self) -> Active:
        """Our own SEND and FETCH jobs (role "both"); call `started` after giving one."""
        return self.machine.active

    def started(self) -> None:
        """A job was given to `active`."""
        self.machine.start(time.monotonic_ns())
        if self._runner is not None:
            self._runner.kick()

    def _on_event(self, event: object, now: Ns) -> None:
        """The store was read or written inside the machine; here it is counted and handed on."""
        if isinstance(event, Written | Fetched | Continued | Refused | UnexpectedReaction | Repeated):
            life, self._life = self._life, None
            self._count(event, now)
            self.heard(now, life)
            self._services.flush()
        elif isinstance(event, Done):
            self._partner["own_jobs"] += 1
        elif isinstance(event, Denied | Failed | Unasked):
            self._fault("own_faults", self._in_words(event), now)
        else:
            self._fault("bad_blocks", str(event), now)

    def _in_words(self, event: Denied | Failed | Unasked) -> str:
        if isinstance(event, Unasked) or self.machine.active.name != BUEP64:
            return str(event)
        return f"job {event.job}: {buep64_fault(event)}"

    def _count(self, result: object, now: Ns) -> None:
        if isinstance(result, Written):
            self._partner["sends"] += 1
        elif isinstance(result, Fetched):
            self._partner["fetches"] += 1
        elif not isinstance(result, Continued):
            self._fault("refused", str(result), now)

    def _fault(self, counter: str, words: str, now: Ns) -> None:
        """A partner's faults are counted; the journal hears of them at most once a second."""
        self._partner[counter] += 1
        if now >= self._journal_next:
            self._journal_next = now + 1_000_000_000
            self._tell("line", f"{self.name}: {words}", door=self.number)

    def counters(self) -> dict[str, object]:
        """For tools."""
        state = self._runner.state if self._runner is not None else None
        return {**self._partner, "connected": state.connected if state else False, "why": state.why if state else ""}

    # ---- the store RK512 serves --------------------------------------------------------------------------------------
    def block_bytes(self, db: int) -> bytes | None:
        """The whole block as it would be fetched; None where there is none."""
        if self.data is not None and db in self.data.blocks:
            return self.data.fill(db)
        services = self._services
        if db == INPUTS_DB:
            return bytes(services.inputs.values)
        if db == OUTPUTS_DB:
            return services.rc_out.read() or bytes(RC_BYTES)
        if self.data is not None:
            return None
        if db == COMMAND_DB:
            return struct.pack(f">{COMMAND_WORDS}H", *self.block.words)
        if db == STATUS_DB:
            return struct.pack(f">{STATUS_WORDS}H", *self.block.status_words(self.status))
        return None

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        """FETCH."""
        data = self.block_bytes(db)
        if data is None or 2 * (word + words) > len(data):
            return ErrorNumber.BLOCK
        return data[2 * word : 2 * (word + words)]

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        """SEND: taken whole or not at all."""
        now = time.monotonic_ns()
        if self.data is not None and db in self.data.blocks:
            block = self.data.blocks[db]
            if not block.from_plc:
                return ErrorNumber.NOT_ALLOWED
            if 2 * word + len(data) > len(block.data):
                return ErrorNumber.BLOCK
            self.data.written(db, word, data, now)
            self._note_life(db, word, data)
            return None
        if db == INPUTS_DB:
            return self._write_inputs(word, data)
        if self.data is not None or db != COMMAND_DB:
            return ErrorNumber.BLOCK
        if word + len(data) // 2 > COMMAND_WORDS or len(data) % 2:
            return ErrorNumber.BLOCK
        self.write_words(word, struct.unpack(f">{len(data) // 2}H", data), now)
        self._note_life(db, word, data)
        return None

    def _write_inputs(self, word: int, data: bytes) -> ErrorNumber | None:
        octets = range(2 * word, 2 * word + len(data))
        services = self._services
        if octets.stop > RC_BYTES:
            return ErrorNumber.BLOCK
        if any(services.owned.get(octet) != self.number for octet in octets):
            return ErrorNumber.NOT_ALLOWED
        services.inputs.values[octets.start : octets.stop] = data
        for octet in octets:
            services.inputs.quality[octet], services.inputs.stamps[octet] = Quality.GOOD, time.monotonic_ns()
        return None

    def _note_life(self, db: int, word: int, data: bytes) -> None:
        if self._life_place is not None and self._life_place[0] == db and word <= self._life_place[1] < word + len(data) // 2:
            at = 2 * (self._life_place[1] - word)
            self._life = int.from_bytes(data[at : at + 2], "big")

    def write_as_plc(self, db: int, word: int, data: bytes) -> str:
        """`axisgate var --set`: as if the PLC had sent it; empty when done, else why not."""
        refused = self.write(db, word, data)
        self._services.flush()
        return "" if refused is None else f"DB {db} DW {word}: refused with RK512 error {int(refused):02X}h ({refused.name})"


def _word_of(address: str | None) -> tuple[int, int] | None:
    if address is None:
        return None
    place = parse(address)
    return (place.db, place.word) if isinstance(place, DataWord) else None


def compile_handshake(handshake: Handshake) -> HandshakeBits:
    """start-busy-done with its bits found."""

    def bit(text: str) -> tuple[int, int, int]:
        place = parse(text)
        assert isinstance(place, DataBit)  # the cell's checks have seen to it
        return place.db, place.word, place.bit

    refused = bit(handshake.refused) if handshake.refused else None
    return HandshakeBits(bit(handshake.start), bit(handshake.busy), bit(handshake.done), refused)


def compile_block(db: Db) -> DataBlock:
    """[[db]] to places and types."""
    return DataBlock(db.number, db.words, db.writer == "plc", tuple(compile_slot(db, entry) for entry in db.entries))


def compile_slot(db: Db, entry: Entry) -> Slot:
    """One entry; the cell's checks have already refused what does not fit."""
    place = parse(entry.at, db=db.number)
    factor = float(entry.unit.split()[0]) if entry.unit else 1.0
    rising = entry.edge == "rising"
    if isinstance(place, DataBit):
        return Slot(db.number, place.word, None, entry.signal, bit=place.bit, rising=rising)
    assert isinstance(place, DataWord)
    half = {Part.LEFT: "L", Part.RIGHT: "R"}.get(place.part, "")
    return Slot(
        db.number, place.word, Step5Type[entry.type], entry.signal, half=half, factor=factor, low=entry.min, high=entry.max,
        rising=rising,
    )  # fmt: skip
