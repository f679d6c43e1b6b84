"""Runs the compiled form command by command and counts: a number of commands a period, and the test display."""

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
    """Asked at a jump backwards and at a call once the allowance is used up: commands to go on with, or TimeError."""

    def __call__(self, routine: str, line: int) -> int: ...


Bound = tuple[Callable[[Command], None], Command, bool]  # act, command, whether the next link begins a chain behind it


class Shown(NamedTuple):
    """What the test display shows behind a command: state of the operand, result, accumulators."""

    status: bool
    result: bool
    accu1: int
    accu2: int


@dataclass(slots=True)
class Frame:
    """A routine that runs: next command, open brackets with the result and the state in front of them."""

    routine: Routine
    at: int = 0
    brackets: list[tuple[Code, bool, bool]] = field(default_factory=list)


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
            **dict.fromkeys(LOGIC, self._logic),
            **dict.fromkeys(OPENERS, self._open),
            **dict.fromkeys(COMPARES, self._compare),
            **dict.fromkeys(JUMPS, self._jump),
            **dict.fromkeys(CALLS, self._call),
            **dict.fromkeys((Code.SET, Code.RESET, Code.ASSIGN), self._write),
            **dict.fromkeys((Code.LOAD, Code.LOAD_BYTE, Code.LOAD_LONG), self._load),
            **dict.fromkeys((Code.STORE_BYTE, Code.STORE_LONG), self._store),
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
        act = self._acts.get(command.code, self._arithmetic)
        return (self._linker(command) if command.code in LOGIC else act), command, command.code in ENDS_CHAIN

    def _linker(self, command: Command) -> Callable[[Command], None]:
        """Links of bits are what programs are made of: their codes are looked at once."""
        kind, inverted = LOGIC.index(command.code) // 2, command.code in (Code.AND_NOT, Code.OR_NOT, Code.XOR_NOT)
        if command.operand is not Operand.BIT:
            return self._logic
        memory, byte, mask = self.state.memory, command.byte, command.mask

        def link(command: Command) -> None:
            value = (memory[byte] & mask == 0) == inverted
            if self.fresh:
                self.result, self.fresh = value, False
            elif kind == 0:
                self.result = self.result and value
            elif kind == 1:
                self.result = self.result or value
            else:
                self.result = self.result != value

        return link

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
        """Runs at most so many commands; True: the end of the start routine was reached."""
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
        """Runs one routine up to its end, its next call or so many commands; how many it were."""
        frames, memory, seen = self._frames, self.state.memory, self.seen
        done, size, depth = 0, len(bound), len(frames)
        while frame.at < size and done != most and len(frames) == depth:
            at = frame.at
            act, command, ends = bound[at]
            frame.at = at + 1
            done += 1
            self.allowance -= 1
            act(command)
            if ends:
                self.fresh = True
            if watched:
                status = memory[command.byte] & command.mask if command.operand is Operand.BIT else self._status(command)
                seen[at] = (status, self.result, self.accu1, self.accu2)
        return done

    def _status(self, command: Command) -> bool:
        cells = self.state.cells
        if command.operand is Operand.BIT:
            return bool(self.state.memory[command.byte] & command.mask)
        return cells.timer(command.cell) if command.operand is Operand.TIMER else cells.counter(command.cell)

    def _link(self, code: Code, before: bool, fresh: bool, value: bool) -> None:
        if fresh:
            self.result = value
        elif code in (Code.AND, Code.AND_NOT, Code.OPEN_AND):
            self.result = before and value
        elif code in (Code.OR, Code.OR_NOT, Code.OPEN_OR):
            self.result = before or value
        else:
            self.result = before != value
        self.fresh = False

    def _logic(self, command: Command) -> None:
        inverted = command.code in (Code.AND_NOT, Code.OR_NOT, Code.XOR_NOT)
        self._link(command.code, self.result, self.fresh, self._status(command) != inverted)

    def _open(self, command: Command) -> None:
        self._frames[-1].brackets.append((command.code, self.result, self.fresh))
        self.fresh = True

    def _close(self, command: Command) -> None:
        code, before, fresh = self._frames[-1].brackets.pop()
        self._link(code, before, fresh, self.result)

    def _begin(self, command: Command) -> None:
        self.result = self.fresh = True

    def _compare(self, command: Command) -> None:
        two, one = self.accu2, self.accu1
        self.result = {
            Code.EQUAL: two == one,
            Code.UNEQUAL: two != one,
            Code.NOT_LESS: two >= one,
            Code.GREATER: two > one,
            Code.NOT_GREATER: two <= one,
            Code.LESS: two < one,
        }[command.code]
        self.fresh = False

    def _write(self, command: Command) -> None:
        if command.code is not Code.ASSIGN and not self.result:
            return
        memory, byte = self.state.memory, command.byte
        if self.result and command.code is not Code.RESET:
            memory[byte] |= command.mask
        else:
            memory[byte] &= ~command.mask & 0xFF
        self._wrote(byte, command.mask)

    def _wrote(self, byte: int, mask: int) -> None:
        at = byte - self.state.layout.outputs
        if 0 <= at < self.state.layout.area:
            self.state.written[at] |= mask

    def _load(self, command: Command) -> None:
        memory, byte, self.accu2 = self.state.memory, command.byte, self.accu1
        if command.code is Code.LOAD:
            self.accu1 = command.number
        elif command.code is Code.LOAD_BYTE:
            self.accu1 = memory[byte]
        else:
            self.accu1 = int.from_bytes(memory[byte : byte + 4], "little", signed=True)

    def _store(self, command: Command) -> None:
        size = 1 if command.code is Code.STORE_BYTE else 4
        data = (self.accu1 & (1 << 8 * size) - 1).to_bytes(size, "little")
        self.state.memory[command.byte : command.byte + size] = data
        for at in range(size):
            self._wrote(command.byte + at, 0xFF)

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

    def _arithmetic(self, command: Command) -> None:
        """What reads the accumulators alone and leaves its result in the first."""
        self.accu1 = ARITHMETIC[command.code](self.accu1, self.accu2, command.number)

    def _taken(self, code: Code) -> bool:
        if code in (Code.JUMP, Code.CALL):
            return True
        return self.result == (code in (Code.JUMP_IF, Code.CALL_IF))

    def _jump(self, command: Command) -> None:
        if not self._taken(command.code):
            return
        frame = self._frames[-1]
        target = self._labels[frame.routine.name][command.name]
        if target < frame.at:
            self._allow(frame.routine.name, command.line)
        frame.at = target

    def _call(self, command: Command) -> None:
        if self._taken(command.code):
            self._allow(self._frames[-1].routine.name, command.line)
            self._frames.append(Frame(self.program.routines[command.name]))

    def _allow(self, routine: str, line: int) -> None:
        if self.allowance < 0:
            self.allowance += self.more(routine, line)
