"""Tool, user frame and base around a kinematics: where the tool centre point is, and which joints bring it somewhere."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from motion.geometry.frames import IDENTITY, Pose, compose
from motion.kinematics.base import Configuration, Joints, Kinematics


@dataclass(frozen=True, slots=True)
class Workspace:
    """base: the robot in the cell; frame: the user's frame in the cell; tool: the TCP on the flange."""

    kinematics: Kinematics
    base: Pose = IDENTITY
    frame: Pose = IDENTITY
    tool: Pose = IDENTITY

    def flange(self, tcp: Pose) -> Pose:
        """A TCP in the user's frame -> flange in the robot's base."""
        return compose(compose(compose(self.base.inverse(), self.frame), tcp), self.tool.inverse())

    def tcp(self, q: Sequence[float]) -> Pose:
        """Where the TCP is in the user's frame; q: joints (m, rad)."""
        return compose(compose(self.frame.inverse(), compose(self.base, self.kinematics.forward(q))), self.tool)

    def joints(self, tcp: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """Joints for a TCP in the user's frame; raises what the kinematics raises."""
        return self.kinematics.inverse(self.flange(tcp), near, configuration)

    def with_tool(self, tool: Pose) -> "Workspace":
        """After a tool change: the same joints, another TCP."""
        return replace(self, tool=tool)

    def with_frame(self, frame: Pose) -> "Workspace":
        """In another user frame: the same joints, other coordinates."""
        return replace(self, frame=frame)
