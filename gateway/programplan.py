"""Programs and robot of a cell, found and looked at before a run starts; what planner, office and checks need of them.

Files are read here and in the planner process alone.  Imports of the motion core stand inside: whoever only wants the plain data (the
services) must not load it.
"""

import pathlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from gateway.cell import Cell
from gateway.cell_belts import Measuring
from gateway.files import beside
from gateway.pure.plannerrecords import MeasuringFacts, ProgramFacts

if TYPE_CHECKING:
    from motion.planner.robot import Machine


@dataclass(frozen=True, slots=True)
class ProgramPlan:
    """One [[program]]: name in words, path of its file, axes it moves."""

    name: str
    path: str
    mask: int

    @property
    def facts(self) -> ProgramFacts:
        return ProgramFacts(self.name, self.mask)


def plan_programs(cell: Cell) -> Mapping[int, ProgramPlan]:
    """Number -> plan of every program; a checked cell's files are there."""
    if not cell.program:
        return {}
    mask = (1 << machine_of_cell(cell).axes) - 1
    return {each.number: ProgramPlan(each.name, str(beside(cell.file, each.file, "programs")), mask) for each in cell.program}


def written_for(named: str, model: str) -> bool:
    """Whether a program that names this robot is for the cell's model; one that names none is for any."""
    return not named or pathlib.PurePath(named).stem == pathlib.PurePath(model).stem


def measured_mask(cell: Cell, measuring: Measuring) -> int:
    """Axes (bit n-1 = axis n of the cell) on the board of a measuring input; none named: all."""
    return sum(1 << n for n, axis in enumerate(cell.axis) if not measuring.axes or axis.name in measuring.axes)


def probe_of(cell: Cell, axis: str) -> Measuring | None:
    """The measuring input that this axis' drive catches by itself; a checked cell has one at most."""
    return next((each for each in cell.measuring if axis in each.drives), None)


def measuring_facts(cell: Cell) -> dict[int, MeasuringFacts]:
    """Every measuring input by its number, for the planner."""
    return {each.channel: _facts(cell, each) for each in cell.measuring}


def _facts(cell: Cell, measuring: Measuring) -> MeasuringFacts:
    drives = sum(1 << n for n, axis in enumerate(cell.axis) if axis.name in measuring.drives)
    return MeasuringFacts(measuring.input, measured_mask(cell, measuring), drives)


def machine_of_cell(cell: Cell) -> "Machine":
    """The cell's robot on its first axes, with their limits; MotionError tells what does not fit."""
    from gateway.axes import limits_of
    from gateway.files import ConfigNotFound
    from gateway.robotfile import RobotFaults, load_robot
    from motion.errors import MotionError
    from motion.planner.robot import machine_of
    from motion.timing.limiter import TooFast

    if cell.robot is None or not cell.robot.model:
        raise MotionError("the cell has no [robot] with a model: programs need its kinematics")
    name = cell.robot.model
    try:
        robot = machine_of(load_robot(str(beside(cell.file, name, "robots"))))
    except (ConfigNotFound, RobotFaults, OSError) as error:
        raise MotionError(f"robot {name!r}: {error}") from error
    own = [limits_of(axis) for axis in cell.axis[: robot.axes]]
    if len(own) < robot.axes:
        raise MotionError(f"robot {name} has {robot.axes} axes, the cell {len(own)}")
    for ours, its in zip(own, robot.limits, strict=True):
        if ours.unit != its.unit:
            raise MotionError(f"axis {ours.name} of the cell is in {ours.unit}, axis {its.name} of robot {name} in {its.unit}")
    if cell.belt and robot.carried:
        names = ", ".join(axis.name for axis in own[robot.arm :])
        raise MotionError(f"additional axes {names} carry the robot or the workpiece; no belt can be in the same cell (AX-565)")
    return replace(robot, limits=tuple(own), too_fast=TooFast(cell.robot.too_fast))
