"""A robot of a cell as the cycle sees it: its axes follow those of the robots before it."""

from collections.abc import Sequence
from dataclasses import dataclass

from motion.geometry.frames import Pose
from motion.kinematics.base import Joints, PathKinematics


@dataclass(frozen=True)
class Placed:
    """own: kinematics of the robot alone; first: number of axes before it, which stay where they are.  q and near: (axes,) the axes before
    it and its own.
    """

    own: PathKinematics
    first: int

    @property
    def axes(self) -> int:
        """Those before it, and its own."""
        return self.first + self.own.axes

    def forward(self, q: Sequence[float]) -> Pose:
        """Its flange in its own base."""
        return self.own.forward(q[self.first :])

    def follow(self, pose: Pose, near: Sequence[float]) -> Joints:
        """Follow as the robot alone does."""
        return (*near[: self.first], *self.own.follow(pose, near[self.first :]))


def behind(own: PathKinematics, first: int) -> PathKinematics:
    """own: on the axes of its cell from `first` on."""
    return Placed(own, first) if first else own


def first_of(robot: PathKinematics) -> int:
    """The place of its first axis in the cell."""
    return robot.first if isinstance(robot, Placed) else 0
