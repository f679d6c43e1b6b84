"""[[robot]]: several robots of one cell have names and consecutive axes; tables about a robot name it."""

from collections.abc import Sequence
from itertools import accumulate
from typing import TYPE_CHECKING

from gateway.checks.context import Context, twice
from gateway.pure.cell.cell import Axis
from gateway.pure.cell.rho3 import COMPONENTS
from gateway.pure.image.records.cell import MOST_AXES

if TYPE_CHECKING:
    from motion.robot import Robot


def robots(check: Context) -> None:
    """Checks beyond a single robot (AX-564)."""
    cell = check.cell
    count = len(cell.robot)
    _named(check)
    if count < 2:
        return
    from motion.program.text.words import Fault, name
    from motion.robot import MOST_KINEMATICS

    if count > MOST_KINEMATICS:
        check.fault("robot", count, "robots of one cell", f"1..{MOST_KINEMATICS}")
    for called, _, _ in twice((robot.name, str(n)) for n, robot in enumerate(cell.robot)):
        check.fault("robot.name", called, "another robot has this name: programs address robots by name")
    for robot in cell.robot:
        try:
            name("robot", robot.name)
        except Fault as fault:
            check.fault("robot.name", robot.name, f"programs name each of several robots: {fault.what}")
    counts = [0 if robot is None else len(robot.axes) for robot in _files(check)]
    if sum(counts) > MOST_AXES:
        check.fault("robot", sum(counts), "axes of all robots of one cell", f"1..{MOST_AXES}")
    if all(counts):
        _own_axes(check, counts)


def _own_axes(check: Context, counts: Sequence[int]) -> None:
    """Axes that a table names are those of its robots.  counts: axes of each robot."""
    cell, ends = check.cell, list(accumulate(counts))
    own = {
        robot.name: {axis.name for axis in cell.axis[end - count : end]} for robot, count, end in zip(cell.robot, counts, ends, strict=True)
    }
    tables = [(f"measuring.{each.channel}", each.robot, (*each.axes, *each.drives)) for each in cell.measuring]
    tables += [(f"shared_output.{each.name}", each.robot, each.axes) for each in cell.shared_output]
    for key, names, axes in tables:
        theirs = set().union(*(own.get(name, set()) for name in names))
        for axis in [axis for axis in axes if theirs and axis not in theirs]:
            there = ", ".join(each.name for each in cell.axis if each.name in theirs)
            check.fault(f"{key}.axes", axis, f"is not an axis of {' or '.join(names)}", there)


def _named(check: Context) -> None:
    """Whom a belt, a correction, a measuring input and outputs of programs are for (AX-552)."""
    cell = check.cell
    tables = [(f"belt.{each.name}", each.robot) for each in cell.belt]
    tables += [("alter", cell.alter.robot)] if cell.alter is not None else []
    tables += [(f"measuring.{each.channel}", each.robot) for each in cell.measuring]
    tables += [(f"path_output.{each.kind} {each.function}", each.robot) for each in cell.path_output]
    tables += [(f"shared_output.{each.name}", each.robot) for each in cell.shared_output]
    there = [robot.name for robot in cell.robot if robot.name]
    known = ", ".join(there) or "none with a name"
    for key, names in tables:
        if not names and len(cell.robot) > 1:
            check.fault(f"{key}.robot", "", "name its robot; this cell has several robots", known)
        for name in [name for name in names if name not in there]:
            check.fault(f"{key}.robot", name, f"no [[robot]] has this name; this cell has {known}")
        for name in sorted({name for name in names if names.count(name) > 1}):
            check.fault(f"{key}.robot", name, "is listed twice")


def masters(check: Context) -> None:
    """The master of axes without transformation is the first axis of its robot (rho 3, L5614)."""
    axes, first = check.cell.axis, 0
    if not any(axis.manual for axis in axes) or {axis.name for axis in axes} != check.known["axis"]:
        return  # an axis was left out for a fault of its own: the owners of the others are unknown
    from motion.robot import Kind

    for robot in _files(check):
        if robot is None:
            return
        own = axes[first : first + len(robot.axes)]
        first += len(robot.axes)
        if robot.kind is Kind.IDENTITY and own and own[0].manual:
            _no_master(check, robot.name, own)


def _no_master(check: Context, robot: str, own: Sequence[Axis]) -> None:
    """Reported where it was written: in the axis or in P303."""
    mains = ", ".join(axis.name for axis in own if not axis.manual) or "none of the others"
    hint = f"axis {own[0].name} is the first of robot {robot}, which has no transformation: the first is its master and no manual axis; "
    hint += f"main axes are {mains}: put one of them first, or make this one a main axis"
    key = f"axis.{own[0].name}.manual"
    source = check.cell.sources.get(key)
    if source is None:
        check.fault(key, "true", hint, "false")
    else:
        check.fault(source.text, 4 if own[0].modulo else 1, hint, "0 or 3")


def components(check: Context) -> None:
    """P313 numbers components of world points: those of the robot's axes, then those of its belts (L8917-8937).  AX-586."""
    assigned = check.cell.rho3.P313 if check.cell.rho3 is not None else ()
    for place, (robot, row) in enumerate(zip(_files(check) if assigned else (), assigned, strict=False), 1):
        belts = [number for number in row if robot is not None and len(robot.axes) < number <= len(COMPONENTS)]
        if robot is not None and belts:
            hint = f"component {belts[0]} is a belt's, robot {robot.name} has {len(robot.axes)} axes: values of belts (belt=, at=) are not"
            hint += " corrected; 0 leaves the component as it is, and programs correct their belt values themselves"
            check.fault(f"rho3.P313[{place}]", list(row), hint, f"0..{len(robot.axes)}")


def _files(check: Context) -> "list[Robot | None]":
    """The file of each robot; None for one that is not there or is wrong, which is reported where programs are looked at."""
    from gateway.files.find import ConfigNotFound, beside
    from gateway.files.robots import RobotFaults, load_robot
    from motion.errors import MotionError

    found: list[Robot | None] = []
    for robot in check.cell.robot:
        try:
            found.append(load_robot(str(beside(check.cell.file, robot.model, "robots"))))
        except (ConfigNotFound, RobotFaults, OSError, MotionError):
            found.append(None)
    return found


CHECKS = (robots, masters, components)
