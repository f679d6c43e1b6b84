"""A robot as the planner needs it: kinematics of the arm, limits of every axis, limits of the tool."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

from motion.errors import MotionError
from motion.geometry.frames import Pose
from motion.geometry.limits import AxisLimits
from motion.kinematics.base import Configuration, Joints, Kinematics
from motion.kinematics.group import Group, OnTable, Role
from motion.program.blocks import MAX_JOINTS, Shape
from motion.robot import Kind, Robot, kinematics_of
from motion.timing.limiter import TooFast, too_fast


@dataclass(frozen=True)
class Machine:
    """limits: first those of the arm, then those of the additional axes.  kinematics: of the arm, or of all axes where additional ones
    carry the robot or the workpiece; its poses are those of the flange in the frame that counts (AX-565).  Tool limits in m, rad and s;
    inf: none."""

    kinematics: Kinematics
    limits: tuple[AxisLimits, ...]
    path_speed: float = inf
    path_accel: float = inf
    turn_speed: float = inf
    turn_accel: float = inf
    too_fast: TooFast = TooFast.SLOW
    shape: Shape = Shape.JERK  # of blocks without a shape of their own
    corrects: str = "xyzabc"  # components of a world point that a workpiece system corrects (P313)
    shares: tuple[float, float] = (1.0, 1.0)  # shares of the axes' acceleration and jerk in `limits`: pieces carry the full values

    def __post_init__(self) -> None:
        if not self.arm <= len(self.limits) <= MAX_JOINTS:
            raise MotionError(f"{len(self.limits)} limits for an arm of {self.arm} axes, {MAX_JOINTS} axes at most")

    @property
    def arm(self) -> int:
        """Number of arm axes; the axes after them are additional."""
        return self.kinematics.main.axes if isinstance(self.kinematics, Group) else self.kinematics.axes

    @property
    def carried(self) -> bool:
        """Additional axes carry the robot or the workpiece: where the flange is depends on them."""
        return isinstance(self.kinematics, Group)

    @property
    def axes(self) -> int:
        """All axes."""
        return len(self.limits)

    def name(self, axis: int) -> str:
        """Of axis 0.."""
        return self.limits[axis].name

    def forward(self, q: Sequence[float]) -> Pose:
        """The flange where the axes (all of them) are at q."""
        return self.kinematics.forward(q[: self.kinematics.axes])

    def inverse(self, flange: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """All axes, near those given; additional axes stay where `near` has them.  Raises KinematicsError."""
        count = self.kinematics.axes
        return (*self.kinematics.inverse(flange, tuple(near[:count]), configuration), *near[count:])


def machine_of(robot: Robot) -> Machine:
    """A robot of configs/robots.  MotionError: axes that carry a robot which has no geometry."""
    moving = [axis.limits.name for axis in robot.axes if axis.role not in (None, Role.FREE)]
    if not moving:
        alone = replace(robot, axes=tuple(axis for axis in robot.axes if axis.role is None))
        return Machine(kinematics_of(alone), robot.limits, too_fast=too_fast(robot.too_fast), shape=Shape(robot.shape))
    group = kinematics_of(robot)
    if robot.kind is Kind.IDENTITY or not isinstance(group, Group):
        raise MotionError(f"robot {robot.name}: axes {', '.join(moving)} carry a robot that has no geometry (kind identity)")
    turned = any(axis.role is Role.TABLE for axis in robot.axes)
    kinematics = OnTable(group.main, group.extra) if turned else group
    return Machine(kinematics, robot.limits, too_fast=too_fast(robot.too_fast), shape=Shape(robot.shape))
