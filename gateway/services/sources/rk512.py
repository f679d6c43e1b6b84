"""The command source of a serial line: 3964R below, RK512 above, and either the cell's own data blocks or the standard command block.

Where the cell declares no blocks, DB 10 is the command block, DB 11 the status block; DB 20 and DB 21 are the RC inputs and outputs
(AX-012).
"""

import struct

from gateway.assembly.axis_signals import rc_numbers
from gateway.assembly.data_block_signals import flags_of, inputs_of
from gateway.assembly.lanes import robot_axes
from gateway.assembly.line_dialects import rk512_dialect
from gateway.pure.arbitration.block_handshake import HandshakeBits
from gateway.pure.arbitration.block_keys import block_key
from gateway.pure.arbitration.command_block import COMMAND_WORDS, STATUS_WORDS, Code, Command
from gateway.pure.arbitration.data_blocks import RC_NAMES, BlockHost, DataBlock, DataBlocks, Selected, Slot
from gateway.pure.arbitration.handshakes import Handshaking, Pattern
from gateway.pure.arbitration.own_jobs import OwnJob, OwnJobs
from gateway.pure.cell.cell import Cell, Db, Entry, Handshake, Line
from gateway.pure.image.addresses import DataBit, DataWord, Part, parse
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import RC_BYTES, Motion, Quality
from gateway.pure.lines.fault_texts import fault_words
from gateway.pure.lines.line_profiles import link_profile
from gateway.pure.lines.rk512_link import Rk512Link
from gateway.registry import layer_spoken
from gateway.services.sources.base import SourceContext
from gateway.services.sources.bit_coupling import RECEIVED_DB, SENT_DB
from gateway.services.sources.rk512_areas import LineAreas
from gateway.services.sources.serial import SerialSource
from protocols.base.errors import EncodeError
from protocols.base.machine import Ns, ms
from protocols.base.step5 import Step5Type
from protocols.p3964r.profiles import Priority
from protocols.rk512.active import Active, Denied, Done, Failed, Unasked
from protocols.rk512.header import ErrorNumber, Flag, Kind
from protocols.rk512.passive import Continued, Fetched, Refused, UnexpectedReaction, Written
from protocols.rk512.station import Repeated

COMMAND_DB, STATUS_DB, INPUTS_DB, OUTPUTS_DB = 10, 11, 20, 21
WAITS = (ErrorNumber.LOCKED, ErrorNumber.STOPPED)  # refusals that a partner awaits as it should: a sign of life (AX-650)
ANY_DB = 1  # entries only name their place within the block


class NotActive(RuntimeError):
    """The cell has role = "passive": this line never sends a job of its own."""


class Rk512Source(SerialSource):
    """One serial line to a PLC."""

    counted = ("sends", "fetches", "refused", "bad_blocks", "own_jobs", "own_faults")

    def __init__(self, context: SourceContext, line: Line) -> None:
        super().__init__(context, line)
        cell = context.run.cell
        mine = [db for db in cell.db if db.line == line.name]
        self.data = self._data_blocks([compile_block(db) for db in mine]) if mine else None
        self._own = OwnJobs(compile_job(db) for db in mine if db.every_ms or db.on_change)
        self._life: int | None = None
        self._now: Ns = 0  # of the block or tick that is being worked on
        self._refusal: Refused | None = None  # of the last job, where it counts for no sign of life
        self._life_place = _word_of(line.supervision.life_word)
        priority = Priority.HIGH if line.priority == "high" else Priority.LOW
        self._areas = LineAreas(self, context.image, context.run.clock, remote=cell.controller is not None and cell.controller.remote)
        self._spoken = layer_spoken(line)
        link = Rk512Link(link_profile(line), priority, self, rk512_dialect(line), line.baud, self._areas)
        self.flags = link.passive.flags
        self._link = self.machine = link
        context.values.lines.append(self)

    def _data_blocks(self, blocks: list[DataBlock]) -> DataBlocks:
        cell = self._run.cell
        handshake = cell.handshake.get("move")
        inputs = inputs_of(cell).get(self.name, {})
        flags = flags_of(cell, self.name)
        numbers = rc_numbers(cell)

        def command(fresh: Command) -> None:
            self.dispatcher.command(self.number, fresh, self._now)

        def refuse(code: Code, words: str) -> None:
            self.dispatcher.refuse(self.number, code, Reason.FORMAT_SUSPICION, words)

        def bad_number(name: str, words: str) -> None:
            self._journal("command", f"command source {self.number}: {words}", source=self.number, what="refused")

        def level(name: str, value: float) -> None:
            if name in flags:
                self._values.write(str(flags[name]), round(value), self._now, self.name)
                return
            number: int = getattr(numbers, RC_NAMES[name]) if name in RC_NAMES else inputs[name]
            if self._image.owned_by(self.number, (number >> 3,)):
                self._image.put_bit(number, bool(value))
                self._image.judge((number >> 3,), Quality.GOOD, self._now)

        names = [axis.name for axis in cell.axis]

        def value(name: str) -> float:
            return self._values.number(name, self)

        host = BlockHost(command, value, bad_number, level, refuse)
        bits = compile_handshake(handshake) if handshake else None
        source = DataBlocks(blocks, names, bits, host, (*inputs, *flags), compile_pattern(cell))
        source.forced = self._image.forces.words
        source.overrides.robots = robot_axes(cell)
        return source

    # ---- life --------------------------------------------------------------------------------------------------------
    def restart(self) -> None:
        """Edges and toggle are adopted from the next telegram (AX-141)."""
        super().restart()
        if self.data is not None:
            self.data.restart()

    def settle(self) -> None:
        """At each tick: our own jobs, coordination flags, the handshake's outcome, and release of control at rest."""
        self._now = self._run.clock()
        self._give_own_jobs(self._now)
        if self.data is not None:
            jobs = self.dispatcher.source(self.number).by_code
            ordered = [jobs[code] for code in (Code.PTP_ABSOLUTE, Code.PROGRAM) if code in jobs]
            if ordered:
                self.data.move_state(max(ordered, key=lambda job: job.id).state)
            self.data.settle(at_rest=self._image.state.motion in (Motion.IDLE, Motion.STOPPED))
        self.reset_used_flags()

    def move_bit(self, key: str) -> bool:
        """A bit of its data blocks."""
        return super().move_bit(key) if self.data is None else self.data.handshake_bit(key)

    def reset_used_flags(self) -> None:
        """Coordination flags are reset when their data have been used: edges are processed at once, a move they started has
        ended (AX-251).
        """
        if self.line.rk512.coordination_flag == "serve" and not (self.data is not None and self.data.handshake_bit("busy")):
            self.flags.set.clear()

    # ---- our own jobs ------------------------------------------------------------------------------------------------
    @property
    def active(self) -> Active:
        """For SEND and FETCH of our own; call `started` after giving one.  NotActive where the cell has role = "passive"."""
        if self.line.role == "passive":
            raise NotActive(
                f'line {self.name}: role = "passive": only the partner sends and fetches; "both" or "active" allows jobs of axisgate'
            )
        return self._link.active

    def started(self) -> None:
        """A job was passed to `active`."""
        self._link.start(self._run.clock())
        self.kick()

    def _give_own_jobs(self, now: Ns) -> None:
        if not self._own.jobs or not self.connected:
            return
        before = self.active.pending
        for job, data in self._own.due(now, self._content):
            try:
                number = (
                    self.active.fetch(job.word, job.words, job.block, job.kind, job.flag)
                    if job.fetch
                    else self.active.send(job.word, data, job.block, job.kind, job.flag)
                )
            except EncodeError as error:  # the cell's checks have seen to it
                self._fault("own_faults", str(error), now)
                continue
            self._own.given(number, job, data, now)
        if self.active.pending > before:
            self.started()

    def _content(self, key: int) -> bytes:
        assert self.data is not None  # our jobs come from its blocks
        return self.data.fill(key)

    def _done(self, event: Done, now: Ns) -> None:
        """Our job is done: treat fetched data as if the partner had sent them."""
        job = self._own.over(event.job)
        self._partner["own_jobs"] += 1
        if job is not None and job.fetch and self.data is not None:
            self._now = now
            self.data.written(job.key, 0, event.data, now)
            self._note_life(job.key, 0, event.data)
        life, self._life = self._life, None
        self.heard(now, life)
        self._image.pass_on()

    def _on_event(self, event: object, now: Ns) -> None:
        """The store was read or written inside the machine; here it is counted and reported."""
        if isinstance(event, Written | Fetched | Continued | Refused | UnexpectedReaction | Repeated):
            self._count(event, now)
            if isinstance(event, UnexpectedReaction) or (isinstance(event, Refused) and event.number not in WAITS):
                self._refusal = event if isinstance(event, Refused) else self._refusal
            else:
                life, self._life, self._refusal = self._life, None, None
                self.heard(now, life)
            self._image.pass_on()
        elif isinstance(event, Done):
            self._done(event, now)
        elif isinstance(event, Denied | Failed | Unasked):
            if not isinstance(event, Unasked):
                self._own.failed(event.job, now)
            self._fault("own_faults", self._in_words(event), now)
        else:
            self._link_fault(event, now)

    def silence(self) -> str:
        """A partner whose jobs are all refused is not silent, but nothing of it counts."""
        if self._refusal is None:
            return super().silence()
        return f"no job that could be served, the last one refused with {self._refusal.number:02X}h ({self._refusal.why}),"

    def _in_words(self, event: Denied | Failed | Unasked) -> str:
        failure = self._spoken.failure
        return fault_words(event) if isinstance(event, Unasked) or failure is None else f"job {event.job}: {failure(event)}"

    def _count(self, result: object, now: Ns) -> None:
        if isinstance(result, Written):
            self._partner["sends"] += 1
        elif isinstance(result, Fetched):
            self._partner["fetches"] += 1
        elif not isinstance(result, Continued):
            self._fault("refused", fault_words(result), now)

    # ---- the store RK512 serves --------------------------------------------------------------------------------------
    def block_bytes(self, db: int) -> bytes | None:
        """The complete block as a FETCH would return it; None without one."""
        if self.data is not None and db in self.data.blocks:
            return self.data.fill(db)
        if db == INPUTS_DB:
            return bytes(self._image.inputs.values)
        if db == OUTPUTS_DB:
            return self._image.outputs.read() or bytes(RC_BYTES)
        if db == SENT_DB and self._areas.coupling.remote:
            return self._areas.coupling.sent_blocks()
        if self.data is not None:
            return None
        if db == COMMAND_DB:
            return struct.pack(f">{COMMAND_WORDS}H", *self.block.words)
        if db == STATUS_DB:
            return struct.pack(f">{STATUS_WORDS}H", *self.block.status_words(self.block_status))
        return None

    def refused(self, kind: str) -> ErrorNumber | None:
        """The error number for any job to this type: the line serves no jobs (role active), or not this type."""
        if self.line.role == "active":
            return ErrorNumber.NOT_ALLOWED
        return None if kind in self.line.rk512.types else ErrorNumber.TYPE_NOT_SERVED

    def read(self, db: int, word: int, words: int) -> bytes | ErrorNumber:
        """FETCH."""
        refused = self.refused("D")
        if refused is not None:
            return refused
        data = self.block_bytes(db)
        if data is None or 2 * (word + words) > len(data):
            return ErrorNumber.BLOCK
        return data[2 * word : 2 * (word + words)]

    def write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        """SEND: all or nothing."""
        return self.refused("D") or self._write(db, word, data)

    def _write(self, db: int, word: int, data: bytes) -> ErrorNumber | None:
        now = self._run.clock()
        if self.data is not None and db in self.data.blocks:
            return self.write_block(db, word, data, now)
        if db == INPUTS_DB:
            return self.write_inputs(2 * word, data)
        if db == RECEIVED_DB and word == 0 and self._areas.coupling.remote:
            return self._areas.coupling.received(data)
        if self.data is not None or db != COMMAND_DB:
            return ErrorNumber.BLOCK
        if word + len(data) // 2 > COMMAND_WORDS or len(data) % 2:
            return ErrorNumber.BLOCK
        self.write_words(word, struct.unpack(f">{len(data) // 2}H", data), now)
        self._note_life(db, word, data)
        return None

    def write_block(self, key: int, word: int, data: bytes, now: Ns) -> ErrorNumber | None:
        """Words into a declared block, known by its line_blocks.block_key."""
        block = self.data.blocks.get(key) if self.data is not None else None
        if self.data is None or block is None or 2 * word + len(data) > len(block.data):
            return ErrorNumber.BLOCK
        if not block.from_plc:
            return ErrorNumber.NOT_ALLOWED
        self._now = now
        self.data.written(key, word, data, now)
        self._note_life(key, word, data)
        return None

    def write_inputs(self, first: int, data: bytes) -> ErrorNumber | None:
        """RC input bytes from `first` on; all of them must belong to this source."""
        octets = range(first, first + len(data))
        if octets.stop > RC_BYTES:
            return ErrorNumber.BLOCK
        if not self._image.owned_by(self.number, octets):
            return ErrorNumber.NOT_ALLOWED
        self._image.write(first, data, self._run.clock())
        return None

    def reset_flag(self, byte: int, bit: int) -> bool:
        """`axisgate var "M 6.4" --set 0`: a coordination flag is reset, its data have been used.  False: it was not set."""
        found = [flag for flag in self.flags.set if (flag.byte, flag.bit) == (byte, bit)]
        for flag in found:
            self.flags.reset(flag)
        return bool(found)

    def flag_bytes(self) -> bytes:
        """Present contents of area M."""
        return self._areas.content("M", 0) or b""

    def _note_life(self, db: int, word: int, data: bytes) -> None:
        if self._life_place is not None and self._life_place[0] == db and word <= self._life_place[1] < word + len(data) // 2:
            at = 2 * (self._life_place[1] - word)
            self._life = int.from_bytes(data[at : at + 2], "big")

    def write_as_plc(self, db: int, word: int, data: bytes) -> str:
        """`axisgate var --set`: as if the PLC had sent it; returns "" or the reason of a refusal."""
        refused = self._write(db, word, data)
        self._image.pass_on()
        return "" if refused is None else f"DB {db} DW {word}: refused with RK512 error {int(refused):02X}h ({refused.name})"


def _word_of(address: str | None) -> tuple[int, int] | None:
    if address is None:
        return None
    place = parse(address)
    return (place.db, place.word) if isinstance(place, DataWord) else None


def compile_handshake(handshake: Handshake) -> HandshakeBits:
    """start-busy-done with its bits found."""

    def bit(text: str) -> tuple[int, int, int] | None:
        if not text:
            return None
        place = parse(text)
        assert isinstance(place, DataBit)  # the cell's checks have seen to it
        return place.db, place.word, place.bit

    return HandshakeBits(bit(handshake.start), bit(handshake.busy), bit(handshake.done), bit(handshake.refused))


def compile_pattern(cell: Cell) -> Selected:
    """The pattern of [handshake.move], None for start-busy-done, which the data blocks handle themselves, and the table that its numbers
    select from.
    """
    positions = {position.number: (position.at, position.speed / 100.0) for position in cell.position}
    programs = frozenset(program.number for program in cell.program)
    handshake = cell.handshake.get("move")
    if handshake is None or handshake.pattern == Pattern.START_BUSY_DONE.value:
        return Selected(None, positions, programs)
    pattern = Handshaking(Pattern(handshake.pattern), positions.keys() | programs, odd=handshake.parity == "odd")
    return Selected(pattern, positions, programs)


def compile_block(db: Db) -> DataBlock:
    """[[db]] to places and types."""
    key = block_key(db.kind, db.number)
    return DataBlock(key, db.words, db.writer == "plc", tuple(compile_slot(key, entry) for entry in db.entries))


def compile_job(db: Db) -> OwnJob:
    """every_ms and on_change of a [[db]]."""
    kind, block, word = partner_place(db)
    flag = None
    if db.flag:
        byte, _, bit = db.flag.lstrip("MF ").partition(".")
        flag = Flag(int(byte), int(bit))
    return OwnJob(
        block_key(db.kind, db.number), db.writer == "plc", kind, block, word, db.words, ms(db.every_ms), db.on_change, flag
    )  # fmt: skip


def partner_place(db: Db) -> tuple[Kind, int, int]:
    """Type, block and first word of a block at the partner."""
    if not db.at_partner:
        return Kind(ord(db.kind)), db.number, 0
    block, _, word = db.at_partner.partition(".DW")
    return Kind.BLOCK if block[1] == "B" else Kind.EXTENDED, int(block[2:]), int(word)


def compile_slot(key: int, entry: Entry) -> Slot:
    """One entry of the block with this key; the cell's checks have already refused invalid ones."""
    place = parse(entry.at, db=ANY_DB)
    factor = float(entry.unit.split()[0]) if entry.unit else 1.0
    rising = entry.edge == "rising"
    if isinstance(place, DataBit):
        return Slot(key, place.word, None, entry.signal, bit=place.bit, rising=rising)
    assert isinstance(place, DataWord)
    half = {Part.LEFT: "L", Part.RIGHT: "R"}.get(place.part, "")
    return Slot(
        key, place.word, Step5Type[entry.type], entry.signal, half=half, factor=factor, low=entry.min, high=entry.max,
        rising=rising,
    )  # fmt: skip
