"""Cross checks of a cell: keys that do not fit each other, reported like field faults; and notes on valid but doubtful settings."""

from collections.abc import Callable, Mapping

from gateway.checks.context import Context
from gateway.pure.cell.cell import Cell, Notice
from gateway.pure.cell.faults import Fault
from gateway.pure.image.signals import SignalList
from gateway.registry import CELL_CHECKS

__all__ = ["cross_faults", "notices"]


def cross_faults(cell: Cell, known: Mapping[str, frozenset[str]], signals: SignalList, line_of: Callable[[str], int | None]) -> list[Fault]:
    """All cross faults of the valid parts.  `known` has the names of all parts, also of those left out; `line_of` finds a key's line."""
    context = Context(cell, known, signals, line_of)
    for row in CELL_CHECKS.values():
        for check in getattr(row.module(), "CHECKS", ()):
            check(context)
    return context.faults


def notices(cell: Cell) -> list[Notice]:
    """Warnings and notes of a cell without faults, in the order of a reader's questions."""
    rows = sorted((row for row in CELL_CHECKS.values() if row.notes), key=lambda row: row.notes)
    return [notice for row in rows for note in row.module().NOTES for notice in note(cell)]
