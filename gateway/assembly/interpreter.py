"""The interpreter's inside as a cell sets it up: programs of its memory, its robots, its parameters."""

from itertools import accumulate

from gateway.files.program_memory import baps2_words
from gateway.pure.cell.cell import Cell
from gateway.pure.languages.baps2.cell_run import CellRun
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.robots import CellRobot
from gateway.pure.languages.base.hosting import Port
from protocols.base.machine import ms


def robots_of_cell(cell: Cell) -> tuple[CellRobot, ...]:
    """Every robot on its axes; MotionError: a model that does not fit."""
    from gateway.assembly.programs import machines_of_cell

    machines = machines_of_cell(cell)
    firsts = accumulate((machine.axes for machine in machines), initial=0)
    return tuple(CellRobot(number, first, machine) for number, (machine, first) in enumerate(zip(machines, firsts, strict=False), 1))


def passing_of(cell: Cell) -> tuple[float, ...]:
    """P213: distances of R_PTP = 1 for the axes of the first kinematic; none where it is not given."""
    given = cell.rho3.others.get("P213", ()) if cell.rho3 else ()
    row = given[0] if isinstance(given, list | tuple) and given and isinstance(given[0], list | tuple) else given
    return tuple(float(each) for each in row if isinstance(each, int | float)) if isinstance(row, list | tuple) else ()


def language_of(cell: Cell, memory: Memory, port: Port, p5_ms: int) -> CellRun:
    """Programs of a checked cell."""
    return CellRun(Library(baps2_words(), memory), memory, port, robots_of_cell(cell), ms(p5_ms), passing=passing_of(cell))
