"""The planner's inside as a cell sets it up."""

from collections.abc import Callable, Sequence

from gateway.assembly.alter import altered
from gateway.assembly.axis_scaling import window_of
from gateway.assembly.axis_signals import rc_numbers
from gateway.assembly.belts import belt_facts
from gateway.assembly.path_outputs import output_places
from gateway.assembly.programs import mask_of, measuring_facts, numbers_by_axis
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.enabling_inputs import free_outputs
from gateway.pure.planning.planner import CellPrograms, Programs
from motion.planner.robot import Machine
from motion.planner.team import Team
from motion.program.team import Kinematic


def programs_of(
    cell: Cell,
    machine_of: Callable[[str, int], Machine],
    text_of: Callable[[int], str],
    team_of: Callable[[Sequence[Kinematic], int], Team],
) -> Programs:
    """Of a checked cell; the callables as Programs has them."""
    numbers = numbers_by_axis(cell)
    return Programs(
        CellPrograms(
            machine_of,
            lambda robots: mask_of(cell, robots),
            text_of,
            free_outputs(rc_numbers(cell), len(cell.axis)),
            belts=belt_facts(cell),
            functions=output_places(cell),
            kinematic_of=lambda machine: numbers.get(machine.limits[0].name, 1),
            altered=altered(cell),
            channels=measuring_facts(cell),
            windows=[window_of(axis) for axis in cell.axis],
            team_of=team_of,
        )
    )
