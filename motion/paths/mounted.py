"""A TCP curve given in a user frame, as the curve of the flange in the base of the robot."""

from dataclasses import dataclass

from motion.geometry.frames import IDENTITY, Pose, rotate
from motion.paths.base import Curve, Derivatives, add, cross, sub


@dataclass(frozen=True, slots=True)
class Mounted:
    """frame: base -> user frame; tool: flange -> TCP."""

    curve: Curve
    frame: Pose = IDENTITY
    tool: Pose = IDENTITY

    @property
    def length(self) -> float:
        """As of the curve itself."""
        return self.curve.length

    def at(self, s: float) -> Pose:
        """Flange in the base."""
        return self.frame @ self.curve.at(s) @ self.tool.inverse()

    def derivatives(self, s: float) -> Derivatives:
        """Of the flange, in the base; the third derivative of the position is that of the TCP."""
        tcp, base = self.curve.derivatives(s), self.frame.rotation
        p1, p2, p3, w, w1 = (rotate(base, v) for v in tcp)
        arm = sub(self.at(s).position, self.frame.apply(self.curve.at(s).position))
        first = cross(w, arm)
        return Derivatives(add(p1, first), add(p2, add(cross(w1, arm), cross(w, first))), p3, w, w1)
