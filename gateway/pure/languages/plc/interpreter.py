"""Runs the compiled form command by command and counts: a number of commands a period, and the test display."""

import operator
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

from gateway.pure.languages.plc import arithmetic as sums
from gateway.pure.languages.plc.commands import (
    CALLS,
    COMPARES,
    ENDS_CHAIN,
    JUMPS,
    LOGIC,
    OPENERS,
    Code,
    Command,
    Operand,
    Program,
    Routine,
)
from gateway.pure.languages.plc.state import State

ARITHMETIC: Mapping[Code, Callable[[int, int, int], int]] = {
    Code.ACCU_AND: lambda one, two, n: one & two,
    Code.ACCU_OR: lambda one, two, n: one | two,
    Code.ACCU_XOR: lambda one, two, n: one ^ two,
    Code.SHIFT_RIGHT: lambda one, two, n: sums.shift_right(one, n),
    Code.SHIFT_LEFT: lambda one, two, n: sums.shift_left(one, n),
    Code.ROTATE_RIGHT: lambda one, two, n: sums.rotate_right(one, n),
    Code.ROTATE_LEFT: lambda one, two, n: sums.rotate_left(one, n),
    Code.PLUS: lambda one, two, n: sums.wrap(two + one),
    Code.MINUS: lambda one, two, n: sums.wrap(two - one),
    Code.ADD_NUMBER: lambda one, two, n: sums.wrap(one + n),
    Code.ONES: lambda one, two, n: ~one,
    Code.TWOS: lambda one, two, n: sums.wrap(-one),
    Code.TO_BCD: lambda one, two, n: sums.to_bcd(one),
    Code.FROM_BCD: lambda one, two, n: sums.from_bcd(one),
}


class More(Protocol):
    """Called at a jump backwards and at a call once the allowance is used up: returns further commands, or raises TimeError."""

    def __call__(self, routine: str, line: int) -> int: ...


COMPARED: Mapping[Code, Callable[[int, int], bool]] = {  # of the second accumulator with the first
    Code.EQUAL: operator.eq,
    Code.UNEQUAL: operator.ne,
    Code.NOT_LESS: operator.ge,
    Code.GREATER: operator.gt,
    Code.NOT_GREATER: operator.le,
    Code.LESS: operator.lt,
}


JOINED: Mapping[Code, Callable[[bool, bool], bool]] = {  # the result so far and the next link
    **dict.fromkeys((Code.AND, Code.AND_NOT, Code.OPEN_AND), operator.and_),
    **dict.fromkeys((Code.OR, Code.OR_NOT, Code.OPEN_OR), operator.or_),
    **dict.fromkeys((Code.XOR, Code.XOR_NOT, Code.OPEN_XOR), operator.xor),
}
CONDITIONAL: Mapping[Code, tuple[Code, bool]] = {  # the command and the result for which it acts
    Code.JUMP_IF: (Code.JUMP, True),
    Code.JUMP_IF_NOT: (Code.JUMP, False),
    Code.CALL_IF: (Code.CALL, True),
    Code.CALL_IF_NOT: (Code.CALL, False),
}
BYTE, LONG, SIGNED = struct.Struct("<B"), struct.Struct("<I"), struct.Struct("<i")


class Bound(NamedTuple):
    """A command with what acts on it."""

    act: Callable[[Command], None]
    command: Command
    leads: bool  # a jump or a call: it may lead elsewhere and asks for allowance
    ends: bool  # the next link begins a new chain
    byte: int  # of the bit that the test display shows; NO_BIT: its operand is a cell
    mask: int


NO_BIT = -1
AHEAD = 64  # commands taken from a routine at one go; a jump drops the rest of them
LEADS = (*JUMPS, *CALLS)


class Shown(NamedTuple):
    """Values of the test display after a command: state of the operand, result, accumulators."""

    status: bool
    result: bool
    accu1: int
    accu2: int


@dataclass(slots=True)
class Frame:
    """A routine that runs: next command, open brackets with the result and the state before them."""

    routine: Routine
    at: int = 0
    brackets: list[tuple[Callable[[bool, bool], bool], bool, bool]] = field(default_factory=list)


def labels_of(routine: Routine) -> dict[str, int]:
    """Place of each label."""
    return {command.name: at for at, command in enumerate(routine.commands) if command.code is Code.LABEL}


@dataclass(slots=True)
class Interpreter:
    """One scan at a time: `begin`, then `run` until it returns True."""

    program: Program
    state: State
    more: More
    watched: str = ""  # routine the test display shows
    result: bool = True
    fresh: bool = True  # the next link begins a chain
    accu1: int = 0
    accu2: int = 0
    allowance: int = 0
    seen: dict[int, tuple[bool | int, bool, int, int]] = field(default_factory=dict)  # by place in the watched routine
    _frames: list[Frame] = field(default_factory=list)
    _labels: dict[str, dict[str, int]] = field(default_factory=dict)
    _acts: dict[Code, Callable[[Command], None]] = field(default_factory=dict)
    _bound: dict[str, list[Bound]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._labels = {name: labels_of(routine) for name, routine in self.program.routines.items()}
        self._acts = {
            Code.JUMP: self._jump,
            Code.CALL: self._call,
            Code.LOAD: self._load,
            Code.LOAD_BYTE: self._load_byte,
            Code.LOAD_LONG: self._load_long,
            **dict.fromkeys((Code.COUNT_UP, Code.COUNT_DOWN), self._count),
            Code.CLOSE: self._close,
            Code.TIMER: lambda c: self.state.cells.start(c.cell, c.name, self.result, self.accu1),
            Code.COUNTER_SET: lambda c: self.state.cells.preset(c.cell, self.result, self.accu1),
            Code.CELL_RESET: lambda c: self.state.cells.reset(c.cell, self.result),
            Code.DIVIDE: self._divide,
            Code.TIMES: self._times,
            Code.EXCHANGE: self._exchange,
            Code.LABEL: lambda c: None,
            Code.BEGIN: self._begin,
        }
        self._bound = {name: [self._bind(command) for command in routine.commands] for name, routine in self.program.routines.items()}

    def _bind(self, command: Command) -> Bound:
        """What a command needs of its code and its operand is looked at once, not in each scan."""
        code = command.code
        if code in LOGIC and command.operand is Operand.BIT:
            act = self._linker(command)
        elif code in (Code.SET, Code.RESET, Code.ASSIGN):
            act = self._writer(command)
        elif code in LOGIC:
            act = self._cell_linker(command)
        elif code in OPENERS:
            act = self._opener(code)
        elif code in (Code.STORE_BYTE, Code.STORE_LONG):
            act = self._number_writer(command)
        elif code in CONDITIONAL:
            act = self._brancher(code)
        elif code in COMPARES:
            act = self._comparer(code)
        elif code in ARITHMETIC:
            act = self._calculator(command)
        else:
            act = self._acts[code]
        byte = command.byte if command.operand is Operand.BIT else NO_BIT
        return Bound(act, command, code in LEADS, code in ENDS_CHAIN, byte, command.mask)

    def _linker(self, command: Command) -> Callable[[Command], None]:
        """Return the function of a link; programs consist mostly of bit links."""
        memory, byte, mask = self.state.memory, command.byte, command.mask
        inverted = command.code in (Code.AND_NOT, Code.OR_NOT, Code.XOR_NOT)

        def link_and(command: Command) -> None:
            value = (memory[byte] & mask == 0) == inverted
            self.result, self.fresh = value and (self.fresh or self.result), False

        def link_or(command: Command) -> None:
            value = (memory[byte] & mask == 0) == inverted
            self.result, self.fresh = value or (self.result and not self.fresh), False

        def link_xor(command: Command) -> None:
            value = (memory[byte] & mask == 0) == inverted
            self.result, self.fresh = value != (self.result and not self.fresh), False

        return {Code.AND: link_and, Code.AND_NOT: link_and, Code.OR: link_or, Code.OR_NOT: link_or}.get(command.code, link_xor)

    def _writer(self, command: Command) -> Callable[[Command], None]:
        """S, R and =."""
        memory, written, byte, mask = self.state.memory, self.state.written, command.byte, command.mask
        at, kept = byte - self.state.layout.outputs, ~mask & 0xFF
        is_output = 0 <= at < self.state.layout.area
        sets, always = command.code is not Code.RESET, command.code is Code.ASSIGN

        def write(command: Command) -> None:
            if self.result and sets:
                memory[byte] |= mask
            elif self.result or always:
                memory[byte] &= kept
            else:
                return
            if is_output:
                written[at] |= mask

        return write

    def _cell_linker(self, command: Command) -> Callable[[Command], None]:
        """Links of timers and counters."""
        cells, cell, joined = self.state.cells, command.cell, JOINED[command.code]
        state_of = cells.timer if command.operand is Operand.TIMER else cells.counter
        inverted = command.code in (Code.AND_NOT, Code.OR_NOT, Code.XOR_NOT)

        def link(command: Command) -> None:
            value = state_of(cell) != inverted
            self.result, self.fresh = value if self.fresh else joined(self.result, value), False

        return link

    def _opener(self, code: Code) -> Callable[[Command], None]:
        joined = JOINED[code]

        def open_bracket(command: Command) -> None:
            self._frames[-1].brackets.append((joined, self.result, self.fresh))
            self.fresh = True

        return open_bracket

    def _number_writer(self, command: Command) -> Callable[[Command], None]:
        """T and TD."""
        memory, written, byte = self.state.memory, self.state.written, command.byte
        put, all_ones = (BYTE, 0xFF) if command.code is Code.STORE_BYTE else (LONG, 0xFFFFFFFF)
        first, area = byte - self.state.layout.outputs, self.state.layout.area
        outputs = [at for at in range(first, first + put.size) if 0 <= at < area]

        def write(command: Command) -> None:
            put.pack_into(memory, byte, self.accu1 & all_ones)
            for at in outputs:
                written[at] = 0xFF

        return write

    def _brancher(self, code: Code) -> Callable[[Command], None]:
        """Jumps and calls with a condition."""
        branch, wanted = CONDITIONAL[code]
        act = self._jump if branch is Code.JUMP else self._call

        def branch_if(command: Command) -> None:
            if self.result == wanted:
                act(command)

        return branch_if

    def _comparer(self, code: Code) -> Callable[[Command], None]:
        compared = COMPARED[code]

        def compare(command: Command) -> None:
            self.result, self.fresh = compared(self.accu2, self.accu1), False

        return compare

    def _calculator(self, command: Command) -> Callable[[Command], None]:
        """What reads the accumulators alone and leaves its result in the first."""
        calculated, number = ARITHMETIC[command.code], command.number

        def calculate(command: Command) -> None:
            self.accu1 = calculated(self.accu1, self.accu2, number)

        return calculate

    @property
    def shown(self) -> dict[int, Shown]:
        """What the test display shows, by the place of the command in its routine."""
        return {at: Shown(bool(status), result, one, two) for at, (status, result, one, two) in sorted(self.seen.items())}

    def begin(self, allowance: int) -> None:
        """The next scan: result 1, a new chain, accumulators 0."""
        self._frames = [Frame(self.program.routines[self.program.start])]
        self.result, self.fresh, self.accu1, self.accu2, self.allowance = True, True, 0, 0, allowance
        self.seen = {}

    @property
    def place(self) -> tuple[str, int]:
        """Routine and step that come next."""
        frame = self._frames[-1] if self._frames else Frame(self.program.routines[self.program.start])
        commands = frame.routine.commands
        return frame.routine.name, commands[frame.at].line if frame.at < len(commands) else frame.routine.last

    def run(self, most: int | None = None) -> bool:
        """Run at most `most` commands; True: the end of the start routine was reached."""
        done, frames = 0, self._frames
        while frames:
            frame = frames[-1]
            name = frame.routine.name
            count = self._run_frame(frame, self._bound[name], -1 if most is None else most - done, name == self.watched)
            done += count
            if frame is frames[-1] and frame.at >= len(frame.routine.commands):
                frames.pop()
                self.fresh = True
            elif done == most:
                return False
        return True

    def _run_frame(self, frame: Frame, bound: list[Bound], most: int, watched: bool) -> int:
        """Run one routine up to its end, its next call or `most` commands; return the number of commands."""
        frames, memory, seen, status_of = self._frames, self.state.memory, self.seen, self._status
        at, done, paid, size, depth = frame.at, 0, 0, len(bound), len(frames)
        while at < size and done != most and len(frames) == depth:
            first = at
            for act, command, leads, ends, byte, mask in bound[at : at + (AHEAD if most < 0 else min(AHEAD, most - done))]:
                if leads:  # commands that request allowance, and the place of an error
                    frame.at = at + 1
                    self.allowance -= done + frame.at - first - paid
                    paid = done + frame.at - first
                act(command)
                if ends:
                    self.fresh = True
                if watched:
                    status = memory[byte] & mask if byte >= 0 else status_of(command)
                    seen[at] = (status, self.result, self.accu1, self.accu2)
                at += 1
                if leads and (frame.at != at or len(frames) != depth):
                    break
            done += at - first
            if leads:
                at = frame.at
        frame.at = at
        self.allowance -= done - paid
        return done

    def _status(self, command: Command) -> bool:
        """Of a timer or a counter."""
        cells = self.state.cells
        return cells.timer(command.cell) if command.operand is Operand.TIMER else cells.counter(command.cell)

    def _close(self, command: Command) -> None:
        joined, before, fresh = self._frames[-1].brackets.pop()
        if not fresh:
            self.result = joined(before, self.result)
        self.fresh = False

    def _begin(self, command: Command) -> None:
        self.result = self.fresh = True

    def _load(self, command: Command) -> None:
        self.accu1, self.accu2 = command.number, self.accu1

    def _load_byte(self, command: Command) -> None:
        self.accu1, self.accu2 = self.state.memory[command.byte], self.accu1

    def _load_long(self, command: Command) -> None:
        self.accu1, self.accu2 = SIGNED.unpack_from(self.state.memory, command.byte)[0], self.accu1

    def _count(self, command: Command) -> None:
        self.state.cells.count(command.cell, self.result, 1 if command.code is Code.COUNT_UP else -1)

    def _exchange(self, command: Command) -> None:
        self.accu1, self.accu2 = self.accu2, self.accu1

    def _error(self) -> None:
        byte, mask = self.state.layout.error
        self.state.memory[byte] |= mask

    def _times(self, command: Command) -> None:
        product = self.accu2 * self.accu1
        self.accu1 = sums.wrap(product)
        if self.accu1 != product:
            self._error()

    def _divide(self, command: Command) -> None:
        found = sums.divide(self.accu2, self.accu1)
        if found is None:
            self._error()
        else:
            self.accu1, self.accu2 = found

    def _jump(self, command: Command) -> None:
        frame = self._frames[-1]
        target = self._labels[frame.routine.name][command.name]
        if target < frame.at:
            self._allow(frame.routine.name, command.line)
        frame.at = target

    def _call(self, command: Command) -> None:
        self._allow(self._frames[-1].routine.name, command.line)
        self._frames.append(Frame(self.program.routines[command.name]))

    def _allow(self, routine: str, line: int) -> None:
        if self.allowance < 0:
            self.allowance += self.more(routine, line)
