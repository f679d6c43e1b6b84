"""The hand-held unit of an old controller as tools show it: size of the display, keys, what types them.  Pure."""

from collections.abc import Mapping
from dataclasses import dataclass, field

LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


@dataclass(frozen=True, slots=True)
class HandUnit:
    """columns, lines: of the display; keypad: names of the keys row by row, "" is a gap; typed: key of a keyboard -> name; more: further
    names; held: keys that act for as long as they are held."""

    title: str
    columns: int
    lines: int
    keypad: tuple[tuple[str, ...], ...]
    typed: Mapping[str, str]
    more: tuple[str, ...] = tuple(LETTERS)
    held: tuple[str, ...] = ()
    faces: Mapping[str, str] = field(default_factory=dict)  # name -> label printed on the key, where it differs

    @property
    def names(self) -> frozenset[str]:
        """Every key."""
        return frozenset(name for row in self.keypad for name in row if name) | frozenset(self.more)

    def facts(self) -> dict[str, object]:
        """For the answer to a tool."""
        return {
            "title": self.title, "columns": self.columns, "lines": self.lines, "keypad": [list(row) for row in self.keypad],
            "typed": dict(self.typed), "more": list(self.more), "held": list(self.held), "faces": dict(self.faces),
        }  # fmt: skip
