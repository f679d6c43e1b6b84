"""Context of every cross check: the cell, the existing names, the signals, and a list for faults."""

import difflib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import Fault
from gateway.pure.image.signals import SignalList


@dataclass
class Context:
    """Passed from check to check."""

    cell: Cell
    known: Mapping[str, frozenset[str]]
    signals: SignalList
    line_of: Callable[[str], int | None]
    faults: list[Fault] = field(default_factory=list)

    def fault(self, key: str, value: object = "", hint: str = "", range_: str = "", unit: str = "", at: str = "") -> None:
        """Notes one fault at a key of the file; `at` is the place whose line it has, where the key does not find it."""
        self.faults.append(Fault(self.cell.file, key, str(value), range_, unit, hint, self.line_of(at or key), "cross"))

    def unknown(self, key: str, value: str, kind: str) -> bool:
        """True (and a fault) when no part of that kind has this name."""
        if value in self.known[kind]:
            return False
        there = ", ".join(sorted(self.known[kind])) or "none"
        self.fault(key, value, f"no such {kind}; {near(value, self.known[kind]) or f'there is {there}'}")
        return True


def program_lines(cell: Cell) -> set[str]:
    """Lines that belong to programs: they are not command sources."""
    return {line.name for line in cell.line if line.program}


def near(word: str, known: Iterable[str], most: int = 1) -> str:
    """A hint with at most so many of the closest spellings, or nothing."""
    found = difflib.get_close_matches(word, list(known), n=most, cutoff=0.6)
    return f"did you mean {' or '.join(found)}?" if found else ""


def twice(pairs: Iterable[tuple[object, str]]) -> list[tuple[object, str, str]]:
    """(value, first place, this place) for every value used a second time."""
    seen: dict[object, str] = {}
    return [(value, seen[value], place) for value, place in pairs if seen.setdefault(value, place) != place]


def number(value: float) -> str:
    """A number without needless digits."""
    return f"{value:.6g}"
