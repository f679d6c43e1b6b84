"""[[path_output]] in the form planner and cycle read.  The motion core is imported inside: cells without such functions do not load it."""

from typing import TYPE_CHECKING

from gateway.assembly.programs import numbers_of, robots_placed
from gateway.pure.cell.cell import Cell

if TYPE_CHECKING:
    from gateway.pure.cycle.path_outputs import CoreOutputs, Places


def output_places(cell: Cell) -> "Places":
    """Functions of a checked cell."""
    from gateway.pure.cycle.path_outputs import OutputPlace
    from motion.outputs.rho3 import Kind

    found = {}
    for each in cell.path_output:
        kind = Kind.PPO if each.kind == "ppo" else Kind.IOL
        (kinematic, *_) = numbers_of(cell, each.robot)
        found[kind, each.function] = OutputPlace(each.output, each.bits if kind is Kind.PPO else 1, each.rated, each.volts, kinematic)
    return found


def functions_of(cell: Cell, p5_ms: int) -> "CoreOutputs | None":
    """For the cycle; None: the cell has no such functions."""
    if not cell.path_output:
        return None
    from gateway.pure.cycle.path_outputs import CoreOutputs

    return CoreOutputs(output_places(cell), robots_placed(cell), p5_ms / 1000.0)
