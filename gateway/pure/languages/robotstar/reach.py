"""Whether a robot reaches a position: its axes' travel, its kinematics, the tool in force."""

import math
from collections.abc import Callable

from gateway.pure.languages.robotstar.path import Target
from gateway.pure.languages.robotstar.values import Structure
from motion.errors import MotionError
from motion.geometry.frames import IDENTITY, Pose
from motion.robot import Robot, kinematics_of


def reach_of(robot: Robot) -> Callable[[Target, Structure | None], str]:
    """A function that returns why a position is not reached; "" where it is.  Positions in a frame above 0 are not looked at."""
    kinematics = kinematics_of(robot)

    def reaches(target: Target, tool: Structure | None) -> str:
        travel = _outside(robot, target)
        if travel or not target.pose or target.frame:
            return travel
        try:
            flange = _pose(robot, target.pose) @ _tool(robot, tool).inverse()
            found = kinematics.branches(robot.base.inverse() @ flange)
        except MotionError as error:
            return str(error)
        return "" if found else f"robot {robot.name} does not reach the position"

    return reaches


def _outside(robot: Robot, target: Target) -> str:
    for name, value in target.axes.items():
        number = int(name[1:])
        if number > len(robot.axes):
            return f"{name}: robot {robot.name} has {len(robot.axes)} axes"
        limits = robot.axes[number - 1].limits
        si = value / 1000 if limits.unit == "mm" else math.radians(value)
        if not limits.lower <= si <= limits.upper:
            return f"{name} {value:g} is outside the travel of the axis"
    return ""


def _pose(robot: Robot, values: tuple[float, ...]) -> Pose:
    return robot.convention.pose(values)


def _tool(robot: Robot, tool: Structure | None) -> Pose:
    if tool is None:
        return IDENTITY
    return _pose(robot, tuple(tool.number(name) for name in ("X", "Y", "Z", "RX", "RY", "RZ")))
