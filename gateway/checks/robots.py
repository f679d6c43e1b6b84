"""[[robot]]: several robots of one cell have names, axes one behind the other, and nothing that belongs to one alone."""

from gateway.checks.context import Context, twice
from gateway.pure.records import AXES

ALONE = ("belt", "alter", "measuring", "path_output", "shared_output")


def robots(check: Context) -> None:
    """What one robot alone cannot know (AX-564)."""
    cell = check.cell
    count = len(cell.robot)
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
    axes = _axes(check)
    if axes > AXES:
        check.fault("robot", axes, "axes of all robots of one cell", f"1..{AXES}")
    for key in ALONE:
        if getattr(cell, key):
            check.fault(key, "", f"belongs to a robot that has its cell for itself; this cell has {count} robots (AX-564)")


def _axes(check: Context) -> int:
    """Of all robot files that are there; those that are not are told where programs are looked at."""
    from gateway.files import ConfigNotFound, beside
    from gateway.robotfile import RobotFaults, load_robot
    from motion.errors import MotionError

    found = 0
    for robot in check.cell.robot:
        try:
            found += len(load_robot(str(beside(check.cell.file, robot.model, "robots"))).axes)
        except (ConfigNotFound, RobotFaults, OSError, MotionError):
            continue
    return found


CHECKS = (robots,)
