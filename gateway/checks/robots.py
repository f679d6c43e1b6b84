"""[[robot]]: several robots of one cell have names and axes one behind the other; tables that are about robots name theirs."""

from collections.abc import Sequence
from itertools import accumulate

from gateway.checks.context import Context, twice
from gateway.pure.records import MOST_AXES


def robots(check: Context) -> None:
    """What one robot alone cannot know (AX-564)."""
    cell = check.cell
    count = len(cell.robot)
    _named(check)
    if count < 2:
        return
    from motion.program.textwords import Fault, name
    from motion.robot import MOST_KINEMATICS

    if count > MOST_KINEMATICS:
        check.fault("robot", count, "robots of one cell", f"1..{MOST_KINEMATICS}")
    for called, _, _ in twice((robot.name, str(n)) for n, robot in enumerate(cell.robot)):
        check.fault("robot.name", called, "another robot has this name: programs tell them apart by it")
    for robot in cell.robot:
        try:
            name("robot", robot.name)
        except Fault as fault:
            check.fault("robot.name", robot.name, f"programs name each of several robots: {fault.what}")
    counts = _counts(check)
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
            check.fault(f"{key}.axes", axis, f"is no axis of {' or '.join(names)}", there)


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
            check.fault(f"{key}.robot", "", "whose is it? this cell has several robots", known)
        for name in [name for name in names if name not in there]:
            check.fault(f"{key}.robot", name, f"no [[robot]] has this name; this cell has {known}")
        for name in sorted({name for name in names if names.count(name) > 1}):
            check.fault(f"{key}.robot", name, "stands twice")


def _counts(check: Context) -> list[int]:
    """Axes of each robot; 0 for a file that is not there, which is told where programs are looked at."""
    from gateway.files import ConfigNotFound, beside
    from gateway.robotfile import RobotFaults, load_robot
    from motion.errors import MotionError

    found = []
    for robot in check.cell.robot:
        try:
            found.append(len(load_robot(str(beside(check.cell.file, robot.model, "robots"))).axes))
        except (ConfigNotFound, RobotFaults, OSError, MotionError):
            found.append(0)
    return found


CHECKS = (robots,)
