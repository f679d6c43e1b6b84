"""No transformation (rho 3: RTYP 0): points are positions of the axes, whatever these are.

There is no tool centre point.  A pose shows the first three linear axes as x, y, z, so that lines and displays still work.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.geometry.frames import NO_ROTATION, Pose
from motion.geometry.limits import AxisLimits
from motion.geometry.units import Kind, kind_of
from motion.kinematics.base import FREE, Branch, Configuration, Joints, Unreachable
from motion.kinematics.choice import Chooser

MOST = 24
STRAY = 1e-9  # m or 1: tolerance for a coordinate without an axis


class Identity:
    """1 .. 24 axes of any kind; q: (axes,) m or rad."""

    def __init__(self, limits: Sequence[AxisLimits]) -> None:
        if not 1 <= len(limits) <= MOST:
            raise MotionError(f"{len(limits)} axes, 1 .. {MOST} are possible")
        self.limits, self.axes = tuple(limits), len(limits)
        self.cartesian = tuple(n for n, axis in enumerate(limits) if kind_of(axis.unit) is Kind.LINEAR)[:3]
        self._chooser = Chooser(limits)

    def forward(self, q: Sequence[float]) -> Pose:
        """(axes,) -> x, y, z of the first three linear axes."""
        x, y, z, *_ = *(q[n] for n in self.cartesian), 0.0, 0.0, 0.0
        return Pose((x, y, z), NO_ROTATION)

    def inverse(self, pose: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """Assign x, y, z to the linear axes; all others stay as in `near`."""
        values = list(near)
        for n, value in zip(self.cartesian, pose.position, strict=False):
            values[n] = value
        if any(not abs(value) <= STRAY for value in pose.position[len(self.cartesian) :]):
            raise Unreachable("no axis for that direction", number=532)
        return self._chooser.choose([(tuple(values), FREE)], near, configuration, FREE)

    def follow(self, pose: Pose, near: Sequence[float]) -> Joints:
        """As inverse: there is only one way."""
        return self.inverse(pose, near)

    def branches(self, pose: Pose) -> list[Branch]:
        """One, with the axes that the pose does not name at 0."""
        if not all(map(math.isfinite, pose.position)):
            return []
        values = [0.0] * self.axes
        for n, value in zip(self.cartesian, pose.position, strict=False):
            values[n] = value
        return [(tuple(values), FREE)]

    def jacobian(self, q: Sequence[float]) -> NDArray[np.float64]:
        """(6, axes): ones where an axis is x, y or z."""
        columns = np.zeros((6, self.axes))
        for row, n in enumerate(self.cartesian):
            columns[row, n] = 1.0
        return columns

    def configuration(self, q: Sequence[float]) -> Configuration:
        """None."""
        return FREE
