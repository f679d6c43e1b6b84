"""Runs the compiled form as generated Python functions.  Nothing of a program's text enters the generated text but numbers."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import cast

from gateway.pure.languages.plc import arithmetic as sums
from gateway.pure.languages.plc.chains import Chain, states_of
from gateway.pure.languages.plc.commands import (
    CALLS,
    CELL_CODES,
    COMPARES,
    JUMPS,
    LOGIC,
    OPENERS,
    Code,
    Command,
    Program,
    Routine,
)
from gateway.pure.languages.plc.interpreter import More, labels_of
from gateway.pure.languages.plc.state import State

Step = Callable[[object, int, int, int], tuple[object, int, int, int]]
FAN = 8  # blocks, or groups of blocks, that one test of the jump target leads to
WRAP = "(({0}) + 2147483648 & 4294967295) - 2147483648"
RELATIONS = {
    Code.EQUAL: "==",
    Code.UNEQUAL: "!=",
    Code.NOT_LESS: ">=",
    Code.GREATER: ">",
    Code.NOT_GREATER: "<=",
    Code.LESS: "<",
}
ARITHMETIC = {
    Code.ACCU_AND: "a &= b",
    Code.ACCU_OR: "a |= b",
    Code.ACCU_XOR: "a ^= b",
    Code.SHIFT_RIGHT: "a = shift_right(a, {n})",
    Code.SHIFT_LEFT: "a = shift_left(a, {n})",
    Code.ROTATE_RIGHT: "a = rotate_right(a, {n})",
    Code.ROTATE_LEFT: "a = rotate_left(a, {n})",
    Code.PLUS: "a = " + WRAP.format("a + b"),
    Code.MINUS: "a = " + WRAP.format("b - a"),
    Code.ADD_NUMBER: "a = " + WRAP.format("a + {n}"),
    Code.ONES: "a = ~a",
    Code.TWOS: "a = wrap(-a)",
    Code.TO_BCD: "a = to_bcd(a)",
    Code.FROM_BCD: "a = from_bcd(a)",
    Code.EXCHANGE: "a, b = b, a",
    Code.LOAD: "b = a; a = {n}",
    Code.LOAD_BYTE: "b = a; a = m[{i}]",
    Code.LOAD_LONG: "b = a; a = number(m[{i}:{i} + 4], 'little', signed=True)",
}
CELLS = {
    Code.COUNT_UP: "count({c}, v, 1)",
    Code.COUNT_DOWN: "count({c}, v, -1)",
    Code.COUNTER_SET: "preset({c}, v, a)",
    Code.CELL_RESET: "reset({c}, v)",
}


@dataclass(slots=True)
class Writer:
    """Writes one routine: lines of one block after the other."""

    routine: Routine
    number: int
    numbers: dict[str, int]
    state: State
    places: list[tuple[str, int]]
    chain: Chain = field(default_factory=Chain)
    lines: list[str] = field(default_factory=list)
    counted: int = 0
    blocks: dict[str, int] = field(default_factory=dict)
    labels: dict[str, int] = field(default_factory=dict)
    unsure: set[str] = field(default_factory=set)

    def text(self) -> str:
        """The function of the routine."""
        targets = {command.name for command in self.routine.commands if command.code in JUMPS}
        labels = [command.name for command in self.routine.commands if command.code is Code.LABEL and command.name in targets]
        self.blocks = {name: number + 1 for number, name in enumerate(labels)}
        self.labels = labels_of(self.routine)
        self.unsure = states_of(self.routine, targets)
        blocks = self._blocks()
        head = f"def r{self.number}(v, a, b, n, m=m, w=w):\n"
        if len(blocks) == 1:
            return head + "".join(f" {line}\n" for line in blocks[0])
        return head + " at = 0\n f = True\n while True:\n" + "\n".join(_tree(blocks, 0, "  ")) + "\n"

    def _blocks(self) -> list[list[str]]:
        found: list[list[str]] = []
        commands = self.routine.commands
        for at, command in enumerate(commands):
            if command.code is Code.LABEL and command.name in self.blocks:
                self._finish_block(command)
                found.append(self.lines)
                self.lines, self.counted = [], 1
            else:
                self.counted += 1
                self._command(command, at)
        self.lines += [*self.chain.settle(), *self._count(), "return v, a, b, n"]
        return [*found, self.lines]

    def _finish_block(self, label: Command) -> None:
        self.lines += self.chain.settle()
        if label.name in self.unsure:
            if self.chain.fresh is not None:
                self.lines.append(f"f = {self.chain.fresh}")
            self.chain.fresh = None
        self.lines += [*self._count(), f"at = {self.blocks[label.name]}"]

    def _count(self) -> Iterator[str]:
        if self.counted:
            yield f"n -= {self.counted}"
        self.counted = 0

    def _command(self, command: Command, at: int) -> None:
        code = command.code
        if code in LOGIC:
            self.lines += self.chain.link(command)
        elif code in OPENERS:
            self.lines += self.chain.open(self.routine.commands, at)
        elif code is Code.CLOSE:
            self.lines += self.chain.close()
        elif code in COMPARES:
            self.chain.load(f"(b {RELATIONS[code]} a)")
        elif code in ARITHMETIC:
            self.lines += self._accumulators(command)
        elif code is Code.BEGIN:
            self.lines.append("v = True")
            self.chain.begin()
        elif code in (Code.TIMES, Code.DIVIDE):
            self._dangerous(command)
        elif code is not Code.LABEL:
            self._effect(command, at)

    def _accumulators(self, command: Command) -> list[str]:
        """A comparison that was not yet worked out reads the accumulators as they were."""
        before = self.chain.settle() if self.chain.reads_accumulators else []
        return [*before, ARITHMETIC[command.code].format(n=command.number, i=command.byte)]

    def _dangerous(self, command: Command) -> None:
        byte, mask = self.state.layout.error
        self.lines += self.chain.settle()
        if command.code is Code.TIMES:
            self.lines += ["a = a * b", "if a != wrap(a):", f" m[{byte}] |= {mask}", " a = wrap(a)"]
        else:
            self.lines += ["q = divide(b, a)", f"if q is None: m[{byte}] |= {mask}", "else: a, b = q"]

    def _effect(self, command: Command, at: int) -> None:
        self.lines += self.chain.settle()
        code = command.code
        if code in CELL_CODES:
            self.lines += self._cell(command)
        elif code in JUMPS:
            self._jump(command, at)
        elif code in CALLS:
            self._call(command)
        else:
            self._write(command)
            if code in (Code.STORE_BYTE, Code.STORE_LONG):
                return
        self.chain.begin()

    def _cell(self, command: Command) -> list[str]:
        settled = "v = not not v"
        if command.code is Code.TIMER:
            return [settled, f"start({command.cell}, {command.name!r}, v, a)"]
        return [settled, CELLS[command.code].format(c=command.cell)]

    def _write(self, command: Command) -> None:
        i, k, out = command.byte, command.mask, self._written(command.byte, command.mask)
        match command.code:
            case Code.SET:
                self.lines.append(f"if v: m[{i}] |= {k}{out}")
            case Code.RESET:
                self.lines.append(f"if v: m[{i}] &= {~k & 255}{out}")
            case Code.ASSIGN:
                self.lines += [f"if v: m[{i}] |= {k}", f"else: m[{i}] &= {~k & 255}"]
                self.lines += [out[2:]] if out else []
            case Code.STORE_BYTE:
                self.lines.append(f"m[{i}] = a & 255{self._written(i, 255)}")
            case _:
                rest = "".join(self._written(i + at, 255) for at in range(4))
                self.lines.append(f"m[{i}:{i} + 4] = (a & 4294967295).to_bytes(4, 'little'){rest}")

    def _written(self, byte: int, mask: int) -> str:
        at = byte - self.state.layout.outputs
        return f"; w[{at}] |= {mask}" if 0 <= at < self.state.layout.area else ""

    def _allow(self, line: int, indent: str) -> str:
        self.places.append((self.routine.name, line))
        return f"{indent}if n < 0: n += more({len(self.places) - 1})"

    def _jump(self, command: Command, at: int) -> None:
        self.lines += self._count()
        indent = " "
        tests = {Code.JUMP: "if True:", Code.JUMP_IF: "if v:", Code.JUMP_IF_NOT: "if not v:"}
        self.lines.append(tests[command.code])
        if self.labels[command.name] <= at:
            self.lines.append(self._allow(command.line, indent))
        if command.name in self.unsure:
            self.lines.append(f"{indent}f = True")
        self.lines += [f"{indent}at = {self.blocks[command.name]}", f"{indent}continue"]

    def _call(self, command: Command) -> None:
        self.lines += self._count()
        tests = {Code.CALL: "if True:", Code.CALL_IF: "if v:", Code.CALL_IF_NOT: "if not v:"}
        call = f" v, a, b, n = r{self.numbers[command.name]}(v, a, b, n)"
        self.lines += [tests[command.code], self._allow(command.line, " "), call]


def _tree(blocks: list[list[str]], first: int, indent: str) -> Iterator[str]:
    """Blocks in their order, in groups, so that a jump passes few tests."""
    if len(blocks) <= FAN:
        for number, block in enumerate(blocks, first):
            yield f"{indent}if at == {number}:"
            yield from (f"{indent} {line}" for line in block)
        return
    size = FAN
    while size * FAN < len(blocks):
        size *= FAN
    for at in range(0, len(blocks), size):
        part = blocks[at : at + size]
        yield f"{indent}if at < {first + at + len(part)}:"
        yield from _tree(part, first + at, f"{indent} ")


class Generated:
    """The functions of a program over a state."""

    def __init__(self, program: Program, state: State, more: More) -> None:
        self._more, self._places = more, list[tuple[str, int]]()
        numbers = {name: number for number, name in enumerate(program.routines)}
        self.text = "\n".join(
            Writer(routine, numbers[name], numbers, state, self._places).text() for name, routine in program.routines.items()
        )
        cells = state.cells
        names: dict[str, object] = {
            "m": state.memory,
            "w": state.written,
            "more": self._ask,
            "number": int.from_bytes,
            **{name: getattr(sums, name) for name in ("wrap", "divide", "to_bcd", "from_bcd")},
            **{name: getattr(sums, name) for name in ("shift_right", "shift_left", "rotate_right", "rotate_left")},
            **{name: getattr(cells, name) for name in ("timer", "counter", "start", "count", "preset", "reset")},
        }
        exec(compile(self.text, "<plc>", "exec"), names)
        self._step = cast(Step, names[f"r{numbers[program.start]}"])

    def scan(self, allowance: int) -> tuple[bool, int, int, int]:
        """Run one scan; return result, accumulators and the remaining allowance.  Raise TimeError when it is used up."""
        result, accu1, accu2, left = self._step(True, 0, 0, allowance)
        return bool(result), accu1, accu2, left

    def _ask(self, place: int) -> int:
        return self._more(*self._places[place])
