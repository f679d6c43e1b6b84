"""Python text under construction, and what the parts of the translation share of it."""

from dataclasses import dataclass, field
from typing import Protocol

from gateway.pure.languages.baps2.flow import Path
from gateway.pure.languages.baps2.scope import Names
from gateway.pure.languages.baps2.tree import Expression
from gateway.pure.languages.baps2.typed import Typed
from gateway.pure.languages.baps2.types import Type
from gateway.pure.languages.baps2.typing import Typing

LONG_ROW, MOST_BRACKETS = 1_000, 190  # Python allows 200 brackets


@dataclass(slots=True)
class Lines:
    """Python text under construction."""

    indent: int = 0
    rows: list[str] = field(default_factory=list)
    too_deep: bool = False  # a row since the last look has more brackets one in the other than Python takes

    def add(self, text: str) -> None:
        """One line."""
        self.rows.append("    " * self.indent + text)
        if len(text) > LONG_ROW and brackets(text) > MOST_BRACKETS:
            self.too_deep = True


def brackets(row: str) -> int:
    """How many brackets are open one in the other."""
    deepest = depth = 0
    for sign in row:
        if sign == "(":
            depth += 1
            deepest = max(deepest, depth)
        elif sign == ")":
            depth -= 1
    return deepest


@dataclass(slots=True)
class Function:
    """What belongs to one Python function: its labels, parts and loops."""

    labels: dict[str, Path]
    apart: bool  # labels are inside: the body is a row of parts
    numbers: dict[str, int] = field(default_factory=dict)
    parts: int = 0
    path: list[int] = field(default_factory=list)
    exclusives: list[tuple[int, str]] = field(default_factory=list)
    count: int = 0  # statements so far
    counted: dict[str, int] = field(default_factory=dict)
    line: int = 0  # as the text last set it

    def part(self) -> int:
        """A new part."""
        self.parts += 1
        return self.parts


class Writer(Protocol):
    """The translation of statements, as its parts see it."""

    names: Names
    typing: Typing
    way: str
    out: Lines
    function: Function
    before_move: bool  # a movement follows the statement directly

    def new(self, letter: str) -> str:
        """A Python name that nothing else has."""

    def turn(self, statements: int) -> None:
        """Count statements and yield the processor when the budget is used up."""

    def target(self, tree: Expression) -> Typed:
        """What is set; the value is not read, so nothing is asked."""

    def store(self, tree: Expression, kind: Type, value: Typed) -> None:
        """Sets a variable of a type to a value, if it fits."""
