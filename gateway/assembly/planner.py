"""The planner's inside as a cell sets it up."""

from collections.abc import Callable, Sequence

from gateway.assembly.alter import altered
from gateway.assembly.axis_scaling import window_of
from gateway.assembly.axis_signals import rc_numbers
from gateway.assembly.belts import belt_facts
from gateway.assembly.lanes import lane_masks
from gateway.assembly.path_outputs import output_places
from gateway.assembly.programs import machines_of_cell, mask_of, measuring_facts, numbers_by_axis
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.enabling_inputs import free_outputs
from gateway.pure.planning.cell_programs import CellPrograms
from gateway.pure.planning.lanes import LanePrograms
from motion.planner.robot import Machine
from motion.planner.team import Team
from motion.program.team import Kinematic


def lane_programs_of(
    cell: Cell,
    machine_of: Callable[[str, int], Machine],
    text_of: Callable[[int], str],
    team_of: Callable[[Sequence[Kinematic], int], Team],
    moved_by: Callable[[int], int],
) -> LanePrograms:
    """Programs of a checked cell, one job per lane; moved_by: axes of a program by its number."""
    masks = lane_masks(cell)
    by_robot = [mask_of(cell, machine) for machine in machines_of_cell(cell)] if len(masks) > 1 else []
    return LanePrograms(
        cell_programs(cell, machine_of, text_of, team_of),
        masks,
        lambda number: moved_by(number) if number > 0 else by_robot[-number - 1],
        [robot.name or robot.kinematics for robot in cell.robot] if len(masks) > 1 else (),
    )


def cell_programs(
    cell: Cell,
    machine_of: Callable[[str, int], Machine],
    text_of: Callable[[int], str],
    team_of: Callable[[Sequence[Kinematic], int], Team],
) -> CellPrograms:
    """The planner's part of a checked cell; for the callables see CellPrograms."""
    numbers = numbers_by_axis(cell)
    return CellPrograms(
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
