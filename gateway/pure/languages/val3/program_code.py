"""A translated program and the steps it is made of."""

from dataclasses import dataclass, field

CALL, WAIT, END = -2, -3, -1  # what a step returns instead of the next one


@dataclass(slots=True)
class Instruction:
    """One step: `body` in Python; or only a way on to a label."""

    line: int
    body: list[str] = field(default_factory=list)
    waits: bool = False
    alias: int | None = None  # label


@dataclass(slots=True)
class Block:
    """An open if, while, do, for or switch."""

    kind: str
    line: int
    end: int  # label after it
    again: int = 0  # label of the loop's head, or of the next branch
    step: str = ""
    column: int = 1
    default: int = 0  # label of the default branch of a switch
    branches: bool = False  # a line of a switch was read
    spare: bool = False  # opened by `else if` or by a misspelt word, or around one: whether it has its own end is unknown


@dataclass(slots=True)
class Code:
    """A translated program.  pcs: line -> first step at or after it."""

    text: str
    steps: int
    lines: list[int]  # of each step
    entry: int
    targets: list[int]  # step -> step after ways on were followed
    slots: int
    temps: int
    last_line: int
