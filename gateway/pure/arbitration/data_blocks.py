"""The old-style command source: data blocks as the PLC program already has them, and its start/busy/done handshake.

A SEND is processed as a unit: first all its words, then its edges, in a fixed order (AX-142).  Edges need a telegram before them: after a
start of services or a lost link the first telegram only sets the state of the bits, so a start bit already set starts nothing.

Targets, speed, number and override are `gateway.pure.arbitration.command_numbers`: a command that needs a value that was refused, or that
the PLC has not written since the link began, is refused completely (AX-610).
"""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

from gateway.pure.arbitration.block_handshake import BlockHandshake, HandshakeBits
from gateway.pure.arbitration.block_keys import block_name
from gateway.pure.arbitration.block_overrides import BlockOverrides
from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.command_numbers import NUMBER, PARITY, SPEED, START, MoveNumbers
from gateway.pure.arbitration.edges import Edges
from gateway.pure.arbitration.handshakes import Handshaking, Pattern
from gateway.pure.arbitration.plc_words import PlcWords
from gateway.pure.image.reasons import CommandState
from protocols.base.errors import ProtocolError
from protocols.base.machine import Ns
from protocols.base.step5 import Step5Type, decode, encode

RC_NAMES = {  # entries that are RC inputs -> field of RcNumbers (AX-002)
    "cell.emergency_stop_ok": "chain",
    "cell.control_allow": "control",
    "cell.feed_allow": "feed",
    "cell.feed_hold_not": "run",
    "cell.travel_allow": "travel",
}


RANGES = {  # range of counts of that type; the other types are the raw word
    Step5Type.KF: (-0x8000, 0x7FFF),
    Step5Type.DH: (-0x8000_0000, 0x7FFF_FFFF),
    Step5Type.KH: (0, 0xFFFF),
    Step5Type.KM: (0, 0xFFFF),
    Step5Type.KZ: (0, 999),
    Step5Type.BCD: (0, 9999),
    Step5Type.KG: (-1.7e38, 1.7e38),
    Step5Type.REAL: (-3.4e38, 3.4e38),
}
FLOATS = (Step5Type.KG, Step5Type.REAL)
SELECTED_BY = {Pattern.STROBE_PARITY: (NUMBER, PARITY), Pattern.NUMBER_SELECT: (NUMBER,)}  # what a request of this pattern carries
WHOLE = 1e-6  # tolerance within which a floating-point number counts as an integer


@dataclass(frozen=True, slots=True)
class Slot:
    """One entry of a data block, compiled."""

    db: int
    word: int
    type: Step5Type | None  # None: a bit
    name: str
    bit: int = 0
    half: str = ""  # L | R: one byte of the word (DL, DR)
    factor: float = 1.0  # one count in the unit of the name (mm, deg, %, 1)
    low: float | None = None  # in counts x factor
    high: float | None = None
    rising: bool = False

    @property
    def size(self) -> int:
        """Bytes this slot covers from the start of its word (or of its half)."""
        return 2 if self.type is None or self.half else self.type.size

    @property
    def range_words(self) -> str:
        """Return low..high without an open end."""
        return f"{'' if self.low is None else f'{self.low:g}'}..{'' if self.high is None else f'{self.high:g}'}"

    def within(self, first: int, end: int) -> bool:
        """All its words are among these bytes of the block."""
        return first <= 2 * self.word and 2 * self.word + self.size <= end

    def overlaps(self, first: int, end: int) -> bool:
        """One of its words is."""
        return first < 2 * self.word + self.size and 2 * self.word < end


@dataclass(slots=True)
class DataBlock:
    """One declared block; `data` is 2 bytes a word, high byte first (AX-010)."""

    number: int
    words: int
    from_plc: bool
    slots: tuple[Slot, ...] = ()
    data: bytearray = field(default_factory=bytearray)
    fresh: bool = False  # the PLC has written it since the link began: none of its words is older

    def __post_init__(self) -> None:
        self.data = bytearray(2 * self.words)

    def bit(self, word: int, bit: int) -> bool:
        """D word.bit: bit 0 is the lowest of the right byte."""
        return bool(int.from_bytes(self.data[2 * word : 2 * word + 2], "big") >> bit & 1)

    def put_bit(self, word: int, bit: int, value: bool) -> None:
        old = int.from_bytes(self.data[2 * word : 2 * word + 2], "big")
        new = old | 1 << bit if value else old & ~(1 << bit)
        self.data[2 * word : 2 * word + 2] = new.to_bytes(2, "big")

    def get(self, slot: Slot) -> float:
        """Return the slot's value in its unit.  Raise ProtocolError when the bytes are not a number of that type."""
        if slot.type is None:
            return float(self.bit(slot.word, slot.bit))
        at = 2 * slot.word
        if slot.half:
            return self.data[at + (slot.half == "R")] * slot.factor
        raw = bytes(self.data[at : at + slot.size])
        number = decode(slot.type, raw) if slot.type in RANGES else int.from_bytes(raw, "big")
        assert isinstance(number, int | float)
        return number * slot.factor

    def put(self, slot: Slot, value: float) -> bool:
        """Write a value in its unit; beyond the type's range the nearest limit is written (False)."""
        if slot.type is None:
            self.put_bit(slot.word, slot.bit, bool(value))
            return True
        count = value / slot.factor
        low, high = (0, 255) if slot.half else RANGES.get(slot.type, (0, 0xFFFF))
        kept = min(max(count, low), high)
        at = 2 * slot.word
        if slot.half:
            self.data[at + (slot.half == "R")] = round(kept)
        elif slot.type in RANGES:
            self.data[at : at + slot.size] = encode(slot.type, kept if slot.type in FLOATS else round(kept))
        else:
            self.data[at : at + 2] = round(kept).to_bytes(2, "big")
        return kept == count


@dataclass(frozen=True, slots=True)
class BlockHost:
    """What the data blocks of a line call.

    command(command): a fresh one; value(name): status; bad_number(name, text): a number that is none or out of min..max;
    level(name, value): of an RC input; refuse(code, text): a command whose numbers were refused.
    """

    command: Callable[[Command], None]
    value: Callable[[str], float]
    bad_number: Callable[[str, str], None]
    level: Callable[[str, float], None]
    refuse: Callable[[Code, str], None] = lambda code, words: None


@dataclass(frozen=True, slots=True)
class Selected:
    """`pattern`: another handshake than start-busy-done; `positions`: what its numbers select, targets and speed (0..1); `programs`:
    numbers that select a program of the cell (AX-406)."""

    pattern: Handshaking | None = None
    positions: Mapping[int, tuple[Mapping[str, float], float]] = field(default_factory=dict)
    programs: frozenset[int] = frozenset()


AS_WRITTEN = Selected()


class DataBlocks:
    """All data blocks of one line."""

    def __init__(
        self,
        blocks: Sequence[DataBlock],
        axes: Sequence[str],
        handshake: HandshakeBits | None,
        host: BlockHost,
        inputs: Sequence[str] = (),
        selected: Selected = AS_WRITTEN,
    ) -> None:
        """`inputs`: signals and flags that are RC inputs in addition to cell.feed_allow and the like."""
        self.blocks: Mapping[int, DataBlock] = {block.number: block for block in blocks}
        self.life: int | None = None  # life word of the last telegram, if it wrote one
        self.clamped = 0
        self.forced: Mapping[tuple[int, int], tuple[int, int]] = {}  # block, word -> mask and values that override every writer (AX-498)
        self._said = PlcWords({block.number: block.words for block in blocks})
        self._axes = tuple(axes)
        self._handshake = BlockHandshake(selected.pattern, handshake)
        self._selected = selected
        self._inputs = (*RC_NAMES, *inputs)
        self._host = host
        self._edges = Edges()
        self._reported: dict[Slot, str] = {}  # reported fault per slot whose number is still invalid
        self._numbers = MoveNumbers({slot.name for block in blocks if block.from_plc for slot in block.slots})
        self.overrides = BlockOverrides(self._numbers, len(self._axes))
        self._leaving = False  # drives-on fell: release control as soon as the axes rest

    # ---- from the PLC ------------------------------------------------------------------------------------------------
    def restart(self) -> None:
        """Start of services or return of the link: the next telegram only sets the state of the bits (AX-141)."""
        self._edges.restart()
        self._numbers.clear()
        self._handshake.restart()
        self.overrides.restart()
        self._said.restart()
        for block in self.blocks.values():
            block.fresh = block.fresh and not block.from_plc  # writes of a Modbus client belong to that command source

    def written(self, db: int, word: int, data: bytes, now: Ns) -> None:
        """Process one SEND that fits: first all its words, then its edges."""
        block, first, end = self.blocks[db], 2 * word, 2 * word + len(data)
        block.data[first:end] = self.laid(db, self._said.write(db, first, data))[first:end]
        block.fresh = True
        self._take(block, [slot for slot in block.slots if slot.overlaps(first, end)], first, len(data))

    def _take(self, block: DataBlock, slots: Sequence[Slot], first: int, size: int) -> None:
        """Process the slots written in `size` words from `first`: store their values, then act on them."""
        levels: dict[str, float] = {}
        for slot in slots:
            if slot.within(first, first + size):
                value, words = self._read(block, slot)
            else:
                value, words = None, f"{slot.name}: only a part of its words was written; write all of them with one SEND"
            self._numbers.put(slot.name, value, words)
            if value is not None:
                levels[slot.name] = value
        self.life = next((round(v) for name, v in levels.items() if name.startswith("line.") and name.endswith(".life")), None)
        asked = {slot.name for slot in slots}
        self._act({name: value for name, value in levels.items() if not name.endswith((".target", ".life"))}, asked)

    def laid(self, db: int, data: bytes) -> bytes:
        """Return the complete block with its forced words applied."""
        mine = [(word, *over) for (block, word), over in self.forced.items() if block == db]
        if not mine:
            return data
        new = bytearray(data)
        for word, mask, value in mine:
            old = int.from_bytes(new[2 * word : 2 * word + 2], "big")
            new[2 * word : 2 * word + 2] = (old & ~mask | value).to_bytes(2, "big")
        return bytes(new)

    def forces_changed(self, db: int, now: Ns) -> None:
        """A force came or went: it acts at once where the PLC has written, else with the PLC's first telegram."""
        block = self.blocks[db]
        if block.from_plc and block.fresh:
            block.data[:] = self.laid(db, self._said.whole(db))
            written = [slot for slot in block.slots if self._said.complete(db, 2 * slot.word, slot.size)]
            self._take(block, written, 0, len(block.data))

    def _read(self, block: DataBlock, slot: Slot) -> tuple[float | None, str]:
        """The slot's value; None and why when it is none or out of its range, which is reported once until it changes."""
        try:
            value = block.get(slot)
            words = ""
        except ProtocolError as error:
            words = str(error)
        else:
            if (slot.low is not None and value < slot.low) or (slot.high is not None and value > slot.high):
                words = f"{slot.name} {value:g}; {slot.range_words}"
            elif not math.isfinite(value):
                words = f"{slot.name} {value:g} is not a number"
            elif slot.name == NUMBER and abs(value - round(value)) > WHOLE:
                words = f"{slot.name} {value:g}; a whole number is expected"
        if words and self._reported.get(slot) != words:
            self._host.bad_number(slot.name, f"{block_name(block.number)} DW {slot.word}: {words}")
        self._reported[slot] = words
        return (None, words) if words else (value, "")

    def _act(self, levels: Mapping[str, float], asked: Collection[str]) -> None:
        """Edges in a fixed order: stop before everything that might start something, start last (AX-142)."""
        all_axes = (1 << len(self._axes)) - 1
        for name in self._inputs:
            if name in levels:
                self._host.level(name, levels[name])
        on = self._edges.of("drives.on", levels)
        if self._edges.of("cell.stop", levels) == 1:
            self._host.command(Command(Code.STOP))
        if on == -1:
            self._host.command(Command(Code.DISABLE, all_axes))
            self._leaving = True
        if self._edges.of("cell.reset", levels) == 1:
            self._host.command(Command(Code.FAULT_RESET))
        if on == 1:
            self._leaving = False
            self._host.command(Command(Code.REQUEST_CONTROL))
            self._host.command(Command(Code.ENABLE, all_axes))
        self._override(levels, fresh=on == 1)
        if self._edges.of("axis.*.reference", levels) == 1:
            self._give(Command(Code.REFERENCE, all_axes), self.overrides.refused)
        if self._edges.of("cell.resume", levels) == 1:
            self._give(Command(Code.RESUME), self.overrides.refused)
        if (pattern := self._handshake.pattern) is not None:
            self._ask(pattern, levels, asked)
            return
        start = self._edges.of("move.start", levels)
        if start == 1:
            self._start()
        elif start == -1:
            self._handshake.let_go()

    def _give(self, command: Command, fault: str) -> None:
        """A command, or its refusal."""
        if fault:
            self._host.refuse(Code(command.code), fault)
        else:
            self._host.command(command)

    def _ask(self, pattern: Handshaking, levels: Mapping[str, float], asked: Collection[str]) -> None:
        """Update the request from this telegram."""
        if not {START, NUMBER, PARITY} & set(asked):
            return
        request = self._handshake.hear(levels, self._numbers.missing(SELECTED_BY.get(pattern.pattern, ())))
        if not self._numbers.seen(NUMBER if pattern.pattern is Pattern.NUMBER_SELECT else START):
            return  # where the bit or number that starts is, is not known yet: it may have been there for long
        if not pattern.see(request):
            if pattern.wrong:
                self._host.refuse(Code.PTP_ABSOLUTE, pattern.wrong)
            return
        if pattern.selects and request.number in self._selected.programs:
            self._begin(Command(Code.PROGRAM, request.number, self._numbers.speed, 1.0), [SPEED])
        else:
            self._start(self._selected.positions.get(request.number) if pattern.selects else None)

    def _override(self, levels: Mapping[str, float], *, fresh: bool) -> None:
        found = self.overrides.take(levels, fresh=fresh, control=bool(self._host.value("cell.control")))
        if isinstance(found, str):
            self._host.refuse(Code.OVERRIDE, found)
        else:
            for command in found:
                self._host.command(command)

    def _start(self, position: tuple[Mapping[str, float], float] | None = None) -> None:
        """The selected position, or the targets of the same telegram, or the latest ones written before it."""
        numbers = self._numbers
        at, speed = (numbers.targets, numbers.speed) if position is None else position
        mask = sum(1 << n for n, name in enumerate(self._axes) if name in at)
        targets = tuple(at.get(name, 0.0) for name in self._axes)
        self._begin(Command(Code.PTP_ABSOLUTE, mask, speed, 1.0, targets), [*numbers.target_names, SPEED] if position is None else [])

    def _begin(self, command: Command, needed: Sequence[str]) -> None:
        """Begin a move or program; refuse it while one of its numbers is refused or not written."""
        self._handshake.begin()
        fault = self._numbers.missing([*needed, *self.overrides.names])
        if not fault:
            self._host.command(command)
            return
        self.move_state(CommandState.REFUSED)
        self._host.refuse(Code(command.code), fault)

    def settle(self, *, at_rest: bool) -> None:
        """Call when time has passed: control is released at rest, after drives-on fell."""
        if self._leaving and at_rest:
            self._leaving = False
            self._host.command(Command(Code.RELEASE_CONTROL))

    # ---- to the PLC --------------------------------------------------------------------------------------------------
    def move_state(self, state: CommandState) -> None:
        """What became of the last move; shown in the handshake bits until start falls."""
        self._handshake.moved(state)

    def handshake_bit(self, key: str) -> bool:
        """busy, done, refused of the last move; done and refused fall with the start bit."""
        return self._handshake.bit(key)

    def fill(self, db: int) -> bytes:
        """The block as the PLC fetches it now; all of one moment."""
        block = self.blocks[db]
        if block.from_plc:
            return bytes(block.data)
        for slot in block.slots:
            self.clamped += not block.put(slot, self._host.value(slot.name))
        bits = self._handshake.bits
        if bits is not None:
            for place, key in ((bits.busy, "busy"), (bits.done, "done")):
                if place is not None and place[0] == db:
                    block.put_bit(place[1], place[2], self.handshake_bit(key))
            if bits.refused is not None and bits.refused[0] == db and self.handshake_bit("refused"):
                block.put_bit(bits.refused[1], bits.refused[2], True)  # the bit may also be the cell's error bit
        return self.laid(db, bytes(block.data))
