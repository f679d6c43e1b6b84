"""Faults of a source text: all of one run are collected, none is an exception."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum

from gateway.pure.languages.base.source import Position

MOST_NAMED = 8  # steps in a hint


class Severity(Enum):
    """An error keeps the program from running, a warning does not."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True)
class SourceFault:
    """One fault.  `id` is stable and names the kind of fault; `hint` is the remedy."""

    id: str
    position: Position
    text: str
    severity: Severity = Severity.ERROR
    hint: str = ""

    def __str__(self) -> str:
        hint = f"; {self.hint}" if self.hint else ""
        return f"{self.position}: {self.severity.value}: {self.text}{hint} [{self.id}]"

    def as_row(self) -> dict[str, str | int]:
        """The fault as `check --json` prints it."""
        return {
            "file": self.position.file,
            "line": self.position.line,
            "column": self.position.column,
            "severity": self.severity.value,
            "id": self.id,
            "text": f"{self.text}; {self.hint}" if self.hint else self.text,
        }


@dataclass(slots=True)
class Faults:
    """Collects the faults of one run.  After `most` errors `full` is set and the reader may stop."""

    most: int | None = None
    warnings: bool = True  # False: warnings are dropped
    texts: bool = False  # True: other words at the same place are another fault, of readers that know no columns
    _found: list[SourceFault] = field(default_factory=list)
    _places: set[tuple[str, Position, str]] = field(default_factory=set)
    _spoilt: set[Position] = field(default_factory=set)

    def error(self, id: str, position: Position, text: str, hint: str = "") -> None:
        """An error; the same kind of error at the same place counts once."""
        self.add(SourceFault(id, position, text, Severity.ERROR, hint))

    def apart(self, id: str, position: Position, text: str, hint: str = "") -> None:
        """An error beside which another one at its place counts too."""
        self._found.append(SourceFault(id, position, text, Severity.ERROR, hint))

    def spoilt(self, position: Position) -> None:
        """Mark a token named by an error, which is still read: later faults at its place are consequences."""
        self._spoilt.add(position)

    def warning(self, id: str, position: Position, text: str, hint: str = "") -> None:
        """A warning."""
        if self.warnings:
            self.add(SourceFault(id, position, text, Severity.WARNING, hint))

    def add(self, fault: SourceFault) -> None:
        """A fault that was found elsewhere."""
        key = (fault.id, fault.position, fault.text if self.texts else "")
        if key not in self._places and fault.position not in self._spoilt and not (self.full and fault.severity is Severity.ERROR):
            self._places.add(key)
            self._found.append(fault)

    def alone_in_line(self, id: str) -> None:
        """Drop all other errors from lines that have one of this kind: what follows it there is read wrong."""
        lines = {fault.position[:2] for fault in self._found if fault.id == id}
        if lines:
            self._found = [fault for fault in self._found if fault.id == id or fault.position[:2] not in lines]

    @property
    def errors(self) -> int:
        """How many errors there are."""
        return sum(fault.severity is Severity.ERROR for fault in self._found)

    @property
    def full(self) -> bool:
        """Whether the greatest number of errors is reached."""
        return self.most is not None and self.errors >= self.most

    def __iter__(self) -> Iterator[SourceFault]:
        """In the order of the text, file by file."""
        return iter(sorted(self._found, key=lambda fault: (fault.position.file, fault.position.line, fault.position.column)))

    def __len__(self) -> int:
        return len(self._found)

    def rows(self) -> list[Mapping[str, str | int]]:
        """All faults as `check --json` prints them."""
        return [fault.as_row() for fault in self]


def also_at(steps: Iterable[int]) -> str:
    """The hint that names further steps with the same mistake; "" for none."""
    numbers = [str(step) for step in steps]
    more = " .." if len(numbers) > MOST_NAMED else ""
    return f"also at step{'s' if len(numbers) > 1 else ''} {', '.join(numbers[:MOST_NAMED])}{more}" if numbers else ""


def hints(*parts: str) -> str:
    """Several hints as one."""
    return "; ".join(part for part in parts if part)
