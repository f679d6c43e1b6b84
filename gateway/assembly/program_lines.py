"""Serial units of BAPS2 programs: [[line.program]] of a cell as a rho 3 assigns them in mode 9.1 (AX-1021)."""

from gateway.pure.cell.cell import Cell, Line
from gateway.pure.cell.lines import ProgramUnit
from gateway.pure.controllers.rho3.serial.setup import Assignment, Function, Procedure, Setup

PROCEDURES = {"3964R": Procedure.LINK_3964R, "text": Procedure.NO_ECHO, "echo": Procedure.ECHO}
LOW_PRIORITY = -1  # output time-out of a 3964R unit that yields


def serial_setup(cell: Cell) -> Setup | None:
    """None: no unit of a program is on a line."""
    lines = tuple(line.name for line in cell.line if line.program)
    assigned = tuple(_assignment(line, unit) for line in cell.line for unit in line.program)
    return Setup(assigned, lines, panel=None) if assigned else None


def _assignment(line: Line, unit: ProgramUnit) -> Assignment:
    procedure = PROCEDURES[unit.procedure]
    timeout = unit.output_timeout_ms
    if procedure is Procedure.LINK_3964R:
        timeout = LOW_PRIORITY if line.priority == "low" else 0
    return Assignment(Function(unit.device), line.name, procedure, unit.format or line.format, timeout, unit.input_timeout_ms)
