"""A source in an editor: its faults, its names with their places, and the words of its language."""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Protocol

from gateway.pure.languages.base.faults import SourceFault

Texts = Mapping[Path, str]  # files as the editor holds them, changed and not saved yet
NAME = re.compile(r"[@#]?[^\W\d]\w*")


@dataclass(frozen=True, slots=True)
class Symbol:
    """One name.  `kind`: module, routine, variable, constant, channel, point, type, label.  Lines and columns count from 1.

    `inside`: the routine that declares it, "" for the complete program; `end`: last line of a routine's text.
    """

    name: str
    kind: str
    path: Path
    line: int
    column: int = 1
    detail: str = ""
    inside: str = ""
    end: int = 0


@dataclass(frozen=True, slots=True)
class PlacedFault:
    """A fault at a line of a real file."""

    path: Path
    line: int
    column: int
    fault: SourceFault


@dataclass(frozen=True)
class Look:
    """The present state of a source.  `names` and `others` are read when a symbol is requested: faults come with each key."""

    faults: tuple[PlacedFault, ...] = ()
    names: Callable[[], Iterable[Symbol]] = tuple
    others: Callable[[], Iterable[Symbol]] = tuple
    words: Mapping[str, str] = field(default_factory=dict)  # text of a word in upper case -> its kind

    @cached_property
    def symbols(self) -> tuple[Symbol, ...]:
        """Symbols of this file, in its order."""
        return tuple(self.names())

    @cached_property
    def elsewhere(self) -> tuple[Symbol, ...]:
        """Symbols of other files of the memory that this one may use."""
        return tuple(self.others())

    def named(self, name: str, line: int) -> Symbol | None:
        """The symbol a name means on a line: of the routine around it first, then of the file, then of the others."""
        wanted = name.upper()
        around = {each.name for each in self.symbols if each.kind == "routine" and each.line <= line <= each.end}
        found = [each for each in self.symbols if each.name.upper() == wanted]
        found = found or [each for each in self.elsewhere if each.name.upper() == wanted]
        found.sort(key=lambda each: (each.inside not in around, each.inside != ""))
        return found[0] if found else None

    def hover(self, name: str, line: int) -> str:
        """Hover text for a name; "" if it is unknown."""
        symbol = self.named(name, line)
        if symbol is not None:
            return f"**{symbol.name}** {symbol.kind}" + (f": {symbol.detail}" if symbol.detail else "")
        return self.words.get(name.upper(), "")


class EditedLanguage(Protocol):
    """A language for the editor."""

    name: str
    suffixes: tuple[str, ...]

    def look(self, path: Path, texts: Texts, root: Path) -> Look:
        """Reads `path` with all that belongs to it.  `root`: folder that the editor has open.  OSError: it cannot be read."""
        ...


def name_at(text: str, line: int, column: int) -> str:
    """The name at a place, "" for none; a place just after it counts."""
    rows = text.splitlines()
    row = rows[line - 1] if 0 < line <= len(rows) else ""
    return next((found[0] for found in NAME.finditer(row) if found.start() <= column - 1 <= found.end()), "")


def column_of(text: str, line: int, name: str) -> int:
    """Column of a name in its line, 1 where it is not there."""
    rows = text.splitlines()
    row = rows[line - 1] if 0 < line <= len(rows) else ""
    return next((found.start() + 1 for found in NAME.finditer(row) if found[0].upper() == name.upper()), 1)


def decorated(rows: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Words of a language as hover texts: (text, kind)."""
    return {text.upper(): f"**{text}** {what}" for text, what in rows}
