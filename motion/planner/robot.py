"""A robot as the planner needs it: kinematics of the arm, limits of every axis, limits of the tool."""

from dataclasses import dataclass, replace
from math import inf

from motion.errors import MotionError
from motion.kinematics.base import Kinematics
from motion.kinematics.group import Role
from motion.limits import AxisLimits
from motion.program.blocks import MAX_JOINTS
from motion.robot import Robot, kinematics_of
from motion.timing.limiter import TooFast


@dataclass(frozen=True)
class Machine:
    """limits: first those of the arm, then those of the additional axes.  Tool limits in m, rad and s; inf: none."""

    kinematics: Kinematics
    limits: tuple[AxisLimits, ...]
    path_speed: float = inf
    path_accel: float = inf
    turn_speed: float = inf
    turn_accel: float = inf
    too_fast: TooFast = TooFast.SLOW

    def __post_init__(self) -> None:
        if not self.arm <= len(self.limits) <= MAX_JOINTS:
            raise MotionError(f"{len(self.limits)} limits for an arm of {self.arm} axes, {MAX_JOINTS} axes at most")

    @property
    def arm(self) -> int:
        """Axes of the arm; the ones behind them are additional."""
        return self.kinematics.axes

    @property
    def axes(self) -> int:
        """All axes."""
        return len(self.limits)

    def name(self, axis: int) -> str:
        """Of axis 0.."""
        return self.limits[axis].name


def machine_of(robot: Robot) -> Machine:
    """A robot of configs/robots.  Additional axes that carry the robot or the workpiece are not planned yet: MotionError (AX-419)."""
    moving = [axis.limits.name for axis in robot.axes if axis.role not in (None, Role.FREE)]
    if moving:
        raise MotionError(f"robot {robot.name}: axes {', '.join(moving)} carry the robot or the workpiece; programs cannot move those yet")
    alone = replace(robot, axes=tuple(axis for axis in robot.axes if axis.role is None))
    return Machine(kinematics_of(alone), robot.limits)
