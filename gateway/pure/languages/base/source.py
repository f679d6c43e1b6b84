"""Positions in source texts, and the texts themselves.  Lines and columns count from 1."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple


class Position(NamedTuple):
    """A place in a source file; `included_from` is the place of the instruction that included the file.

    A tuple, because a reader makes one for each token.
    """

    file: str
    line: int
    column: int = 1
    included_from: "Position | None" = None

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"

    def stack(self) -> Iterator["Position"]:
        """This position, then the places it was included from, innermost first."""
        place: Position | None = self
        while place is not None:
            yield place
            place = place.included_from


@dataclass(frozen=True, slots=True)
class SourceFile:
    """One source text under the name its faults are reported with."""

    name: str
    text: str
    included_from: Position | None = None

    def at(self, line: int, column: int = 1) -> Position:
        """A position in this file."""
        return Position(self.name, line, column, self.included_from)

    def depth(self) -> int:
        """How many files include this one, one in the other."""
        return sum(1 for _ in self.included_from.stack()) if self.included_from else 0

    def includes_itself(self, name: str) -> bool:
        """Whether including `name` here would never end."""
        above = self.included_from.stack() if self.included_from else ()
        return base_name(name) in (base_name(self.name), *(base_name(place.file) for place in above))


def base_name(file: str) -> str:
    """The name of a file without its folder, as names are compared."""
    return file.replace("\\", "/").rpartition("/")[2].upper()
