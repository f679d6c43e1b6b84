"""Lines of the DAT files: `number = value ; comment`, faults by line.  Source: rho 3 Releases; rho3 3.4, AX-533."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

from gateway.pure.controllers.rho3.functions.messages import Text

V = TypeVar("V")
MOST_CHARACTERS = 80  # of a text (L843, L913)
_QUOTED = re.compile(r"'([^']*)'")


@dataclass(frozen=True, slots=True)
class Fault:
    """A line that is not used; `line` counts from 1, 0 is the entire file."""

    file: str
    line: int
    why: Text

    def __str__(self) -> str:
        return self.text("en")

    def text(self, language: str) -> str:
        """`TEXT.DAT:3: ...` in German or English."""
        return f"{self.file}:{self.line}: {self.why.text(language)}"


class LineError(Exception):
    """What is wrong with a line; the reader of the file adds name and number."""

    def __init__(self, key: str, *values: str) -> None:
        super().__init__(key, *values)
        self.why = Text(key, values)


@dataclass(frozen=True, slots=True)
class Table(Generic[V]):
    """Contents of a file: entries of the good lines, faults of the others."""

    file: str
    entries: Mapping[int, V]
    faults: tuple[Fault, ...] = ()


def parse(file: str, text: str, entry: Callable[[str], tuple[int, V]]) -> Table[V]:
    """All lines through `entry`; blank and comment lines are skipped.  A number given twice: the first one counts (AX-533)."""
    entries: dict[int, V] = {}
    faults: list[Fault] = []
    for count, line in enumerate(text.removesuffix("\x1a").split("\n"), 1):  # 1Ah ended files of the old editors
        line = line.removesuffix("\r")
        if not line.strip(" \t") or line.lstrip(" \t").startswith(";"):
            continue
        try:
            number, value = entry(line)
            if number in entries:
                raise LineError("twice", head_of(line))
            entries[number] = value
        except LineError as error:
            faults.append(Fault(file, count, error.why))
    return Table(file, entries, tuple(faults))


def head_of(line: str) -> str:
    """The part before the equals sign, without blanks around."""
    head, equals, _ = line.partition("=")
    if not equals:
        raise LineError("no_equals")
    return head.strip(" \t")


def tail_of(line: str) -> str:
    """The part after the equals sign, without blanks before it."""
    return line.partition("=")[2].lstrip(" \t")


def quoted(tail: str) -> str:
    """Return a text in single quotes, followed by blanks and a comment only."""
    found = _QUOTED.match(tail)
    if found is None:
        raise LineError("quotes")
    text = found[1]
    if any(character < " " or character == "\x7f" for character in text):
        raise LineError("control")
    if len(text) > MOST_CHARACTERS:
        raise LineError("long", str(len(text)))
    only_comment(tail[found.end() :])
    return text


def only_comment(rest: str) -> None:
    """Raises LineError for more than blanks and a comment."""
    rest = rest.strip(" \t")
    if rest and not rest.startswith(";"):
        raise LineError("behind", rest)
