"""Settings of a cell for the core of its cycle, in SI."""

from gateway.assembly.alter import alter_of_cell
from gateway.assembly.axis_signals import assumed_permits, rc_numbers
from gateway.assembly.cycle_belts import belts_of
from gateway.assembly.path_outputs import functions_of
from gateway.assembly.shared_outputs import shared_of_cell
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.core_settings import CoreParts, CoreRules


def core_rules(cell: Cell) -> CoreRules:
    """RC numbers, assumed permits, reaction to lost services, step of the override."""
    finish = cell.cell.on_services_loss == "finish_move"
    return CoreRules(rc_numbers(cell), assumed_permits(cell), finish, cell.cell.override_step)


def core_parts(cell: Cell, p5_ms: int) -> CoreParts:
    """Belts, outputs of the path, correction, shared outputs, where the cell has them; imported only then."""
    belts = belts_of(cell, p5_ms) if cell.belt else None
    return CoreParts(belts, functions_of(cell, p5_ms), alter_of_cell(cell, p5_ms), shared_of_cell(cell, p5_ms))
