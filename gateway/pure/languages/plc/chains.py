"""Chains of links as Python expressions, each written before the first command that needs its result."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from gateway.pure.languages.plc.commands import (
    COMPARES,
    ENDS_CHAIN,
    LOGIC,
    OPENERS,
    Code,
    Command,
    Operand,
    Routine,
)

LONGEST = 12  # links in one expression, levels of brackets in it likewise
Fresh = bool | None  # None: known when the program runs, in `f`


def operand_of(command: Command) -> str:
    """Return the expression that reads a bit; Python uses it as true or false."""
    if command.operand is Operand.BIT:
        return f"m[{command.byte}] & {command.mask}"
    return f"{command.operand.value}({command.cell})"


def linked(code: Code, before: str, value: str) -> str:
    """Two expressions linked."""
    if code in (Code.AND, Code.AND_NOT, Code.OPEN_AND):
        return f"({before} and {value})"
    if code in (Code.OR, Code.OR_NOT, Code.OPEN_OR):
        return f"({before} or {value})"
    return f"((not {before}) != (not {value}))"


def plain_until_close(commands: Sequence[Command], at: int) -> bool:
    """Whether the bracket opened at a place holds few links and brackets alone, so that its outside may be worked out later."""
    depth = 0
    for number, command in enumerate(commands[at : at + LONGEST]):
        depth += (command.code in OPENERS) - (command.code is Code.CLOSE)
        if not depth:
            return number > 1
        if command.code not in LOGIC and command.code not in OPENERS and command.code is not Code.CLOSE:
            return False
        if number and command.code in OPENERS:
            return False
    return False


@dataclass(slots=True)
class Outside:
    """The part before an open bracket: its expression, or the number of the variables that keep it."""

    code: Code
    before: str
    fresh: Fresh
    links: int


@dataclass(slots=True)
class Chain:
    """The chain at the writer's present place.  `expression` is `v` where nothing is left to evaluate."""

    expression: str = "v"
    fresh: Fresh = True
    links: int = 0
    reads_accumulators: bool = False
    _outside: list[Outside] = field(default_factory=list)

    def begin(self) -> None:
        """The next link begins a chain."""
        self.fresh = True

    def load(self, expression: str) -> None:
        """The result is this expression whatever was before."""
        self.expression, self.fresh, self.links, self.reads_accumulators = expression, False, 1, True

    def settle(self) -> list[str]:
        """Works the expression out."""
        if self.expression == "v":
            return []
        line = f"v = {self.expression}"
        self.expression, self.links, self.reads_accumulators = "v", 0, False
        return [line]

    def link(self, command: Command) -> list[str]:
        """One more link."""
        inverted = command.code in (Code.AND_NOT, Code.OR_NOT, Code.XOR_NOT)
        value = f"(not {operand_of(command)})" if inverted else f"({operand_of(command)})"
        return self._joined(command.code, self.expression, self.fresh, value, "f")

    def _joined(self, code: Code, before: str, fresh: Fresh, value: str, flag: str) -> list[str]:
        lines: list[str] = []
        if fresh is None:
            self.expression = f"({value} if {flag} else {linked(code, before, value)})"
        elif fresh:
            self.expression, self.links = value, 0
        else:
            self.expression = linked(code, before, value)
        self.fresh = False
        self.links += 1
        if self.links >= LONGEST:
            lines = self.settle()
        return lines

    def open(self, commands: Sequence[Command], at: int) -> list[str]:
        """A bracket; the part before it is kept in variables of its level unless it can wait."""
        code, level = commands[at].code, len(self._outside)
        if self.fresh is not None and plain_until_close(commands, at):
            self._outside.append(Outside(code, self.expression, self.fresh, self.links))
            self.expression, self.links, self.fresh = "v", 0, True
            return []
        lines = [*self.settle(), f"b{level} = v"]
        if self.fresh is None:
            lines.append(f"g{level} = f")
        self._outside.append(Outside(code, f"b{level}", self.fresh, 0))
        self.fresh = True
        return lines

    def close(self) -> list[str]:
        """The end of a bracket."""
        outside = self._outside.pop()
        lines: list[str] = []
        if outside.fresh is None or outside.before.startswith("b"):
            lines = self.settle()
        value, self.links = self.expression, outside.links
        return [*lines, *self._joined(outside.code, outside.before, outside.fresh, value, f"g{len(self._outside)}")]


def states_of(routine: Routine, targets: set[str]) -> set[str]:
    """Return labels at which a chain may continue or begin, depending on the path of the program."""
    unsure: set[str] = set()
    fresh = True
    for command in routine.commands:
        code = command.code
        if code is Code.LABEL and command.name in targets and not fresh:
            unsure.add(command.name)
        elif code in OPENERS:
            fresh = True
        elif code in LOGIC or code in COMPARES or code is Code.CLOSE:
            fresh = False
        elif code in ENDS_CHAIN or code is Code.BEGIN:
            fresh = True
    return unsure
