"""SCARA with four axes: two parallel arms, a stroke, a rotation.

Joints 0: both arms stretched along x.  Order of the axes: arm, forearm, stroke (m, upwards), rotation; the flange's z points
downwards (`down`, the usual tool direction) or upwards.  Configuration (VAL 3 ch. 9.7.5, L5341): righty <=> sin(j2) > 0,
lefty <=> sin(j2) <= 0.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.geometry.frames import Pose
from motion.geometry.limits import AxisLimits
from motion.geometry.units import Kind, kind_of
from motion.kinematics.base import Branch, Configuration, Joints, Shoulder, Unreachable, beyond
from motion.kinematics.choice import Chooser, wrapped

STRAY = 1e-9  # how far the flange's z may be from the vertical
SHORT = 8e-10  # m: how far rounding may put a point beyond a stretched or folded arm
RIGHTY, LEFTY = Configuration(shoulder=Shoulder.RIGHTY), Configuration(shoulder=Shoulder.LEFTY)
KINDS = (Kind.ROTARY, Kind.ROTARY, Kind.LINEAR, Kind.ROTARY)


class Scara:
    """arm, forearm: m between the axes; height: m of the flange over the base with the stroke at 0."""

    axes = 4

    def __init__(self, arm: float, forearm: float, height: float, limits: Sequence[AxisLimits], *, down: bool = True) -> None:
        if not (0.0 < arm < math.inf and 0.0 < forearm < math.inf and math.isfinite(height)):
            raise MotionError(f"a SCARA needs two arms longer than 0 and a height, not {arm}, {forearm}, {height} m")
        if tuple(kind_of(axis.unit) for axis in limits) != KINDS:
            raise MotionError("a SCARA has the axes arm (deg), forearm (deg), stroke (mm), rotation (deg), in this order")
        self.arm, self.forearm, self.height, self.down, self.limits = arm, forearm, height, down, tuple(limits)
        far, near = arm + forearm, abs(arm - forearm)
        self._fixed = (arm, forearm, height, -1.0 if down else 1.0)
        self._reach = (far * far, near * near, -2.0 * far * SHORT, -2.0 * near * SHORT)
        self._sums = (arm * arm + forearm * forearm, arm * arm - forearm * forearm)
        self._chooser = Chooser(limits)

    def forward(self, q: Sequence[float]) -> Pose:
        """(4,) -> flange in the base."""
        arm, forearm, height, up = self._fixed
        q1, q2, q3, q4 = q
        both = q1 + q2
        s, c = math.sin(both + q4), math.cos(both + q4)
        x, y = arm * math.cos(q1) + forearm * math.cos(both), arm * math.sin(q1) + forearm * math.sin(both)
        return Pose((x, y, height + q3), (c, -s * up, 0.0, s, c * up, 0.0, 0.0, 0.0, up))

    def branches(self, pose: Pose) -> list[Branch]:
        """Righty and lefty; one where the arm is stretched; none out of reach or with a tilted flange."""
        _, _, height, up = self._fixed
        farthest, nearest, out, inn = self._reach
        (x, y, z), (r11, _, r13, r21, _, r23, _, _, r33) = pose
        if not (abs(r13) <= STRAY and abs(r23) <= STRAY and r33 * up > 0.0):
            return []
        square = x * x + y * y
        beyond, within = farthest - square, square - nearest
        if not (beyond >= out and within >= inn):  # a NaN ends here too
            return []
        bend = math.sqrt(beyond * within) if beyond > 0.0 and within > 0.0 else 0.0  # 2 arm forearm sin(j2)
        total, excess = self._sums
        q2, inward = math.atan2(bend, square - total), math.atan2(bend, square + excess)
        turn, away = math.atan2(r21, r11), math.atan2(y, x)
        pi, remainder = math.pi, math.remainder
        lefty: Branch = ((remainder(away + inward, 2.0 * pi), -q2, z - height, remainder(turn - away - inward + q2, 2.0 * pi)), LEFTY)
        if bend == 0.0:
            return [lefty]
        return [((remainder(away - inward, 2.0 * pi), q2, z - height, remainder(turn - away + inward - q2, 2.0 * pi)), RIGHTY), lefty]

    def inverse(self, pose: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """The nearest way inside the limits."""
        found = self.branches(pose)
        if not found:
            raise self._lack(pose)
        return self._chooser.choose(found, near, configuration, self.configuration(near))

    def follow(self, pose: Pose, near: Sequence[float]) -> Joints:
        """The shoulder stays as in `near`; the arm can reach the stretched pose, not pass it."""
        now = self.configuration(near)
        found = self.branches(pose)
        if not found:
            raise self._lack(pose)
        return self._chooser.choose(found, near, now if len(found) == 2 else None, now)

    def configuration(self, q: Sequence[float]) -> Configuration:
        """righty <=> sin(j2) > 0."""
        return RIGHTY if 0.0 < wrapped(q[1]) < math.pi else LEFTY

    def jacobian(self, q: Sequence[float]) -> NDArray[np.float64]:
        """(6, 4)."""
        q1, both = q[0], q[0] + q[1]
        x2, y2 = self.forearm * math.cos(both), self.forearm * math.sin(both)
        x1, y1 = x2 + self.arm * math.cos(q1), y2 + self.arm * math.sin(q1)
        rows = [[-y1, -y2, 0.0, 0.0], [x1, x2, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0] * 4, [0.0] * 4, [1.0, 1.0, 0.0, 1.0]]
        return np.array(rows)

    def _lack(self, pose: Pose) -> Unreachable:
        """Return the error: 534 for a tilted flange, 530 for a point too far or too near."""
        (x, y, _), rotation = pose
        far = math.hypot(x, y)
        if not math.isfinite(far + pose.position[2] + sum(rotation)):
            return Unreachable("the pose holds a value that is not a finite number")
        if abs(rotation[2]) > STRAY or abs(rotation[5]) > STRAY or (rotation[8] > 0.0) is self.down:
            return Unreachable("a SCARA cannot tilt its flange", number=534)
        least, most = abs(self.arm - self.forearm) * 1e3, (self.arm + self.forearm) * 1e3
        return Unreachable(f"{beyond(far * 1e3, least, most)} mm from axis 1, possible are {least:.3f} .. {most:.3f} mm")
