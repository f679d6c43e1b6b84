"""[[shared_output]] in the form the cycle reads."""

from typing import TYPE_CHECKING

from gateway.assembly.limits import limits_of
from gateway.pure.cell.cell import Cell

if TYPE_CHECKING:
    from gateway.pure.cycle.shared_output import CoreShared


def shared_of_cell(cell: Cell, p5_ms: int) -> "CoreShared | None":
    """For the cycle; None: every axis has an output of its own."""
    if not cell.shared_output:
        return None
    from gateway.pure.cycle.shared_output import CoreShared, SharedFacts

    places = {axis.name: n for n, axis in enumerate(cell.axis)}
    facts = []
    for table in cell.shared_output:
        axes = tuple(places[name] for name in table.axes)
        correction = (table.correction_ms / 1000.0,) * len(axes)
        rated = tuple(limits_of(cell.axis[n]).speed for n in axes)
        select = -1 if table.select is None else table.select
        facts.append(SharedFacts(axes, correction, rated, table.output >> 3, select, table.gain, table.keep_last))
    return CoreShared(facts, p5_ms / 1000.0)
