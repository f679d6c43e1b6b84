"""Programs and robot of a cell, found and checked before a run starts, for planner, dispatcher and checks.

Only this module and the planner process read the files.  The motion core is imported inside: code that only needs the plain data (the
services) must not load it.
"""

import functools
import operator
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import TYPE_CHECKING

from gateway.files.find import ConfigNotFound, beside, read_octets, read_text
from gateway.pure.cell.belts import Measuring
from gateway.pure.cell.cell import Cell, Robot
from gateway.pure.image.records.planner import MeasuringFacts, ProgramFacts

LARGEST = 8_000_000  # bytes of a BNR file; a larger one has more points than a block accepts

if TYPE_CHECKING:
    from motion.errors import MotionError
    from motion.geometry.limits import AxisLimits
    from motion.kinematics.base import PathKinematics
    from motion.planner.robot import Machine
    from motion.planner.team import Team
    from motion.program.blocks import Block
    from motion.program.team import Kinematic


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
    made = {}
    for each in cell.program:
        path = beside(cell.file, each.file, "programs")
        made[each.number] = ProgramPlan(each.name, str(path), mask_of(cell, robots_of(cell, read_text(path), each.kinematics)))
    return made


def read_bnr(program: str, name: str) -> bytes:
    """Read a file of set points (MOVE_FILE): next to the program, else from configs/programs; MotionError."""
    from motion.errors import MotionError

    try:
        return read_octets(beside(program, name, "programs"), LARGEST)
    except (ConfigNotFound, OSError) as error:
        raise MotionError(f"{name}: {error}") from error


def bnr_files(program: str, blocks: "Sequence[Block]") -> "dict[str, bytes | MotionError]":
    """Every file its blocks name, or why it cannot be read."""
    from motion.errors import MotionError

    found: dict[str, bytes | MotionError] = {}
    for block in blocks:
        if block.file is not None and block.file.name not in found:
            try:
                found[block.file.name] = read_bnr(program, block.file.name)
            except MotionError as error:
                found[block.file.name] = error
    return found


def robots_of(cell: Cell, text: str, kinematics: str = "") -> "Machine | Team":
    """Robots moved by a program; kinematics: those named by its [[program]].  MotionError."""
    from motion.program.text.reader import read
    from motion.program.text.team import read_team, several

    if several(text):
        return team_meant(cell, read_team(text).kinematics)
    return robot_meant(cell, read(text).robot if len(cell.robot) > 1 else "", kinematics)


def written_for(named: str, model: str) -> bool:
    """Whether a program that names this robot is for the cell's model; one that names none is for any."""
    return not named or pathlib.PurePath(named).stem == pathlib.PurePath(model).stem


def numbers_of(cell: Cell, names: Sequence[str]) -> tuple[int, ...]:
    """Numbers, from 1, of the robots a table of a checked cell is about; none named: the only one."""
    return tuple(n for n, robot in enumerate(cell.robot, 1) if not names or robot.name in names) or (1,)


def measured_mask(cell: Cell, measuring: Measuring) -> int:
    """Axes (bit n-1 = axis n of the cell) on the board of a measuring input; none named: all of its robots."""
    mask = sum(1 << n for n, axis in enumerate(cell.axis) if not measuring.axes or axis.name in measuring.axes)
    if len(cell.robot) < 2:
        return mask
    machines = machines_of_cell(cell)
    own = (mask_of(cell, machines[number - 1]) for number in numbers_of(cell, measuring.robot))
    return mask & functools.reduce(operator.or_, own)


def probe_of(cell: Cell, axis: str) -> Measuring | None:
    """The measuring input that this axis' drive captures itself; a checked cell has at most one."""
    return next((each for each in cell.measuring if axis in each.drives), None)


def measuring_facts(cell: Cell) -> dict[int, MeasuringFacts]:
    """Every measuring input by its number, for the planner."""
    return {each.channel: _facts(cell, each) for each in cell.measuring}


def _facts(cell: Cell, measuring: Measuring) -> MeasuringFacts:
    drives = sum(1 << n for n, axis in enumerate(cell.axis) if axis.name in measuring.drives)
    return MeasuringFacts(measuring.input, measured_mask(cell, measuring), drives, measuring.latch)


def machine_of_cell(cell: Cell) -> "Machine":
    """The only robot of a cell, or the one on its first axes; MotionError names the mismatch."""
    return machines_of_cell(cell)[0]


def machines_of_cell(cell: Cell) -> "tuple[Machine, ...]":
    """Robots on the axes of the cell, with their limits; the axes of each follow those of the one before; MotionError (AX-564)."""
    from motion.errors import MotionError

    if not cell.robot or not all(robot.model for robot in cell.robot):
        raise MotionError("the cell has no [robot] with a model: programs need its kinematics")
    machines: list[Machine] = []
    for robot in cell.robot:
        machines.append(_machine(cell, robot, sum(machine.axes for machine in machines)))
    return tuple(machines)


def _machine(cell: Cell, table: Robot, first: int) -> "Machine":
    from gateway.assembly.limits import limits_of
    from gateway.files.robots import RobotFaults, load_robot
    from motion.errors import MotionError
    from motion.planner.robot import machine_of
    from motion.program.blocks import Shape
    from motion.robot import with_limits
    from motion.timing.limiter import too_fast

    name = table.model
    try:
        written = load_robot(str(beside(cell.file, name, "robots")))
    except (ConfigNotFound, RobotFaults, OSError) as error:
        raise MotionError(f"robot {name!r}: {error}") from error
    count = len(written.axes)
    own = [limits_of(axis) for axis in cell.axis[first : first + count]]
    if len(own) < count:
        left = f"{len(own)} are left after those of the robots before it" if first else f"the cell {len(own)}"
        raise MotionError(f"robot {name} has {count} axes, {left}")
    for ours, its in zip(own, written.limits, strict=True):
        if ours.unit != its.unit:
            raise MotionError(f"axis {ours.name} of the cell is in {ours.unit}, axis {its.name} of robot {name} in {its.unit}")
    robot = machine_of(with_limits(written, own))
    number = cell.robot.index(table) + 1
    if robot.carried and any(number in numbers_of(cell, belt.robot) for belt in cell.belt):
        names = ", ".join(axis.name for axis in own[robot.arm :])
        raise MotionError(f"additional axes {names} carry the robot or the workpiece; no belt can be one of this robot (AX-565)")
    for belt in cell.belt:
        if belt.axis and number in numbers_of(cell, belt.robot) and belt.axis not in {axis.name for axis in own}:
            whose = f"{table.name} ({name})" if len(cell.robot) > 1 else name
            raise MotionError(
                f"belt {belt.name}: axis {belt.axis} does not belong to robot {whose}, whose axes are {', '.join(a.name for a in own)}"
            )
    _check_endless(name, robot, own)
    shape = robot.shape if table.shape == "robot" else Shape(table.shape)
    fast = robot.too_fast if table.too_fast == "robot" else too_fast(table.too_fast)
    return replace(robot, shape=shape, too_fast=fast, corrects=table.corrects)


def _check_endless(name: str, robot: "Machine", own: "Sequence[AxisLimits]") -> None:
    """Axes that go round have no part in a geometry: MotionError."""
    from motion.errors import MotionError
    from motion.kinematics.identity import Identity

    for n, axis in enumerate(own):
        if not axis.modulo:
            continue
        if robot.carried:
            raise MotionError(f"axis {axis.name} is endless (modulo); in a cell whose additional axes carry robot or workpiece none can be")
        if n < robot.arm and not isinstance(robot.kinematics, Identity):
            what = f"axis {axis.name} is endless (modulo), and the arm of robot {name} has a geometry"
            raise MotionError(f"{what}: only axes of kind identity and additional axes go round (AX-568)")


def robots_placed(cell: Cell) -> "dict[int, PathKinematics]":
    """Kinematics of every robot by its number, from 1, on the axes of the cell, in the form the cycle reads."""
    from motion.kinematics.placed import behind

    machines = machines_of_cell(cell)
    firsts = accumulate((machine.axes for machine in machines), initial=0)
    return {n: behind(machine.kinematics, first) for n, (machine, first) in enumerate(zip(machines, firsts, strict=False), 1)}


def numbers_by_axis(cell: Cell) -> dict[str, int]:
    """Number of each of several robots, from 1, by the name of its first axis."""
    if len(cell.robot) < 2:
        return {}
    return {machine.limits[0].name: n for n, machine in enumerate(machines_of_cell(cell), 1)}


def kinematic_by_axis(cell: Cell) -> list[int]:
    """Number of the robot of each axis, from 1; 0: an axis of none of several."""
    if len(cell.robot) < 2 or not all(robot.model for robot in cell.robot):
        return [1] * len(cell.axis)
    found = [n for n, machine in enumerate(machines_of_cell(cell), 1) for _ in range(machine.axes)]
    return [*found, *[0] * (len(cell.axis) - len(found))]


def called_in(cell: Cell) -> str:
    """The robots of a cell in words."""
    return ", ".join(f"{robot.name} ({robot.model})" if robot.name else robot.model for robot in cell.robot)


def robot_meant(cell: Cell, written: str, kinematics: str = "") -> "Machine":
    """The robot of a program for a single one.  written: the file of robots named in its text, or ""; kinematics: that of its [[program]],
    or "". MotionError: none, or one of several.
    """
    from motion.errors import MotionError

    found = [n for n, robot in enumerate(cell.robot) if not kinematics or kinematics in (robot.name, robot.model)]
    found = [n for n in found if written_for(written, cell.robot[n].model)]
    if cell.robot and not found:
        raise MotionError(f"the program is written for robot {written or kinematics}, this cell's is {called_in(cell)}")
    if len(found) > 1:
        raise MotionError(f'the program moves one of {called_in(cell)}: name it with kinematics = "NAME" in its [[program]]')
    return machines_of_cell(cell)[found[0] if found else 0]


def team_meant(cell: Cell, kinematics: "Sequence[Kinematic]") -> "Team":
    """The robots a program of several kinematics names, in the order of the cell; MotionError."""
    from motion.errors import MotionError
    from motion.planner.team import Team

    names, places = [robot.name for robot in cell.robot], []
    for each in kinematics:
        if each.name not in names:
            raise MotionError(f"kinematic {each.name}: no [[robot]] has this name; this cell has {called_in(cell)}")
        places.append(names.index(each.name))
        if not written_for(each.robot, cell.robot[places[-1]].model):
            raise MotionError(f"kinematic {each.name} is written for robot {each.robot}, this cell's is {cell.robot[places[-1]].model}")
    if places != sorted(places):
        raise MotionError(f"kinematics must be in the order of the cell's [[robot]] tables: {', '.join(names)}")
    machines = machines_of_cell(cell)
    return Team(tuple(each.name for each in kinematics), tuple(machines[n] for n in places))


def mask_of(cell: Cell, robots: "Machine | Team") -> int:
    """Their axes of the cell (bit n-1 = axis n)."""
    own = {axis.name for axis in robots.limits}
    return sum(1 << n for n, axis in enumerate(cell.axis) if axis.name in own)
