"""What is wrong with a cell file, in words that lead to the cure: file, line, key, value, allowed range, unit, hint."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault.  `kind` is syntax, field (a single key) or cross (keys that do not fit each other)."""

    file: str
    key: str
    value: str = ""
    range: str = ""
    unit: str = ""
    hint: str = ""
    line: int | None = None
    kind: str = "field"

    def __str__(self) -> str:
        place = self.file if self.line is None else f"{self.file}:{self.line}"
        value = f" = {self.value}" if self.value else ""
        unit = f" {self.unit}" if self.unit else ""
        allowed = f": allowed {self.range}{unit}" if self.range else ""
        return f"{place}: {self.key}{value}{allowed}{': ' if self.hint else ''}{self.hint}"


class CellFaults(Exception):
    """The cell file cannot be used; `faults` holds all of them, field faults first."""

    def __init__(self, faults: Sequence[Fault]) -> None:
        super().__init__("\n".join(str(fault) for fault in faults))
        self.faults = tuple(faults)
