"""A program as the memory holds it: head, steps, parameters.  Source: robotstar 1.1, 1.2, 2.1."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from gateway.pure.languages.robotstar.operands import Operand

KINDS = ("MPR", "SPR", "MAC", "PAL", "PLC")
HEADS = frozenset((*KINDS, "DIR"))
DEFINITIONS = frozenset(("VAR", "LOC_VAR", "CONST", "LOC_CONST"))


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter; `descriptor` is the word of the table, "" where none was written."""

    operand: Operand
    descriptor: str = ""
    column: int = 1
    text: str = ""  # as written


@dataclass(frozen=True, slots=True)
class Step:
    """One step.  `number` counts from 1 (the head); `line` is the line of the file."""

    number: int
    word: str  # of the table; of a macro call its name
    parameters: tuple[Parameter, ...] = ()
    line: int = 0
    valid: bool = True
    macro: bool = False
    text: str = ""  # as written, without number and backslash
    slots: Mapping[str, Operand] = field(default_factory=dict)  # the parameters by their place in the command

    def given(self, parameters: tuple[Parameter, ...], slots: Mapping[str, Operand]) -> "Step":
        """The step with its parameters."""
        return Step(self.number, self.word, parameters, self.line, self.valid, self.macro, self.text, slots)


@dataclass(slots=True)
class Program:
    """One program of the memory.  `directory` is its path below the root, "" for the root."""

    name: str
    kind: str
    steps: list[Step] = field(default_factory=list)
    directory: str = ""
    file: str = ""
    labels: dict[str, int] = field(default_factory=dict)  # name -> step number
    locked: str = ""  # letters of its protection
    refused: list[tuple[int, str]] = field(default_factory=list)  # (line, fault) of what keeps it from running
    made: str = ""  # its own file, where a program has made or changed it; `file` and lines are those of the source

    @property
    def key(self) -> str:
        """Path below the root and name, upper case."""
        return f"{self.directory}/{self.name}".upper() if self.directory else self.name.upper()

    @property
    def own_file(self) -> str:
        """Where its text and its values are."""
        return self.made or self.file

    def listing(self) -> str:
        """Its file: a numbered step a line."""
        return "".join(f"{step.number} {'' if step.valid else chr(92)}{step.text}\n" for step in self.steps)


def definition_late(began: int) -> str:
    """Return the fault of a definition after the step that began the program (L803)."""
    return f"definitions belong at the beginning, before step {began}"
