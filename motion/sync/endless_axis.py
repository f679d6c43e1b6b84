"""A single axis that follows a belt: the endless axis parallel to a belt.  Source: rho 3 Releases part 1, TO08 section 4.

For motion.sync.join, which puts a belt's frame before a path, it looks like an arm whose pose is the place of this axis alone, as x in m
or rad; the other axes follow the path.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from motion.geometry.frames import Pose, translation
from motion.geometry.limits import TOUCH, AxisLimits
from motion.kinematics.base import Joints, OutOfLimits, PathKinematics
from motion.sync.parallel import Carrier


@dataclass(frozen=True, slots=True)
class AlongAxis:
    """limits: of all axes; axis: the one that goes along, from 0."""

    limits: tuple[AxisLimits, ...]
    axis: int

    @property
    def axes(self) -> int:
        """All of them."""
        return len(self.limits)

    def forward(self, q: Sequence[float]) -> Pose:
        """Where the axis is."""
        return translation(q[self.axis], 0.0, 0.0)

    def follow(self, pose: Pose, near: Sequence[float]) -> Joints:
        """`near` with the axis there; OutOfLimits beyond its rounds."""
        own, place = self.limits[self.axis], pose.position[0]
        if not own.lower - TOUCH <= place <= own.upper + TOUCH:
            raise OutOfLimits(f"axis {own.name} would leave its travel", axis=own.name)
        return (*near[: self.axis], place, *near[self.axis + 1 :])


def bearing(carrier: Carrier, kinematics: PathKinematics, limits: Sequence[AxisLimits], first: int = 0) -> PathKinematics:
    """What a belt moves: the tool of the arm, or one of its axes.  limits: of the axes a path has; first: of those before the robot's."""
    return kinematics if carrier.joint is None else AlongAxis(tuple(limits), first + carrier.joint)
