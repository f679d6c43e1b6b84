"""[alter] in the form the cycle reads.  The motion core is imported inside: cells without a correction do not load it."""

from typing import TYPE_CHECKING

from gateway.assembly.limits import limits_of
from gateway.assembly.programs import numbers_of, robots_placed
from gateway.pure.cell.alter import Alter
from gateway.pure.cell.cell import Cell

if TYPE_CHECKING:
    from gateway.pure.cycle.alter import AlterFacts, CoreAlter


def alter_of_cell(cell: Cell, p5_ms: int) -> "CoreAlter | None":
    """For the cycle; None: the cell has no correction."""
    if cell.alter is None:
        return None
    from gateway.pure.cycle.alter import CoreAlter

    robots, numbers = robots_placed(cell), altered(cell)
    own = {number: robot for number, robot in robots.items() if number in numbers}
    return CoreAlter(_facts(cell.alter), own, [limits_of(axis) for axis in cell.axis], p5_ms / 1000.0)


def altered(cell: Cell) -> tuple[int, ...]:
    """Numbers of the robots that a correction moves."""
    return numbers_of(cell, cell.alter.robot) if cell.alter is not None else ()


def _facts(table: Alter) -> "AlterFacts":
    from gateway.pure.cycle.alter import AlterFacts

    return AlterFacts(
        table.input >> 3,
        table.type == "REAL",
        table.length,
        table.angle,
        -1 if table.life is None else table.life >> 3,
        table.silence_ms * 1_000_000,
        table.every_ms / 1000.0,
        -1 if table.status is None else table.status >> 3,
    )
