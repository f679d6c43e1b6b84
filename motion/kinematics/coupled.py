"""Coupled axes: each drive moves a combination of joints (wrists through hollow shafts, parallelograms, screws of a SCARA).

joints = matrix @ axes, both in rad or m.  Programs, limits and displays of this kinematics speak of the axes (the drives'
positions); the geometry inside speaks of joints.  A parallelogram's "j2 + j3 within ..." is the travel of its coupled axis.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.geometry.frames import Pose
from motion.geometry.limits import AxisLimits
from motion.kinematics.base import Branch, Configuration, Joints, Kinematics, OutOfLimits
from motion.kinematics.choice import inside

Row = tuple[float, ...]


class Coupled:
    """limits: those of the axes, in their order."""

    def __init__(self, inner: Kinematics, matrix: Sequence[Sequence[float]], limits: Sequence[AxisLimits]) -> None:
        table = np.array(matrix, dtype=float)
        if table.shape != (inner.axes, inner.axes) or not np.all(np.isfinite(table)) or abs(np.linalg.det(table)) < 1e-9:
            raise MotionError(f"the couplings of {inner.axes} axes are {inner.axes} rows of {inner.axes} numbers that can be inverted")
        if len(limits) != inner.axes:
            raise MotionError(f"{len(limits)} limits for {inner.axes} axes")
        self.inner, self.limits, self.axes = inner, tuple(limits), inner.axes
        self._table = table
        self._rows = _rows(table)
        self._back = _rows(np.linalg.inv(table))

    def joints(self, axes: Sequence[float]) -> Joints:
        """Positions of the axes -> joints of the geometry."""
        return _times(self._rows, axes)

    def positions(self, joints: Sequence[float]) -> Joints:
        """Joints of the geometry -> positions of the axes."""
        return _times(self._back, joints)

    def forward(self, q: Sequence[float]) -> Pose:
        """Flange."""
        return self.inner.forward(self.joints(q))

    def inverse(self, pose: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """The geometry's nearest joints, as axes; OutOfLimits when an axis would leave its travel."""
        return self._checked(self.inner.inverse(pose, self.joints(near), configuration))

    def follow(self, pose: Pose, near: Sequence[float]) -> Joints:
        """As the geometry's own."""
        return self._checked(self.inner.follow(pose, self.joints(near)))

    def branches(self, pose: Pose) -> list[Branch]:
        """The geometry's ways, as axes."""
        return [(self.positions(joints), flags) for joints, flags in self.inner.branches(pose)]

    def configuration(self, q: Sequence[float]) -> Configuration:
        """The geometry's."""
        return self.inner.configuration(self.joints(q))

    def jacobian(self, q: Sequence[float]) -> NDArray[np.float64]:
        """(6, axes)."""
        result: NDArray[np.float64] = self.inner.jacobian(self.joints(q)) @ self._table
        return result

    def _checked(self, joints: Joints) -> Joints:
        axes = self.positions(joints)
        for axis, value in zip(self.limits, axes, strict=True):
            if inside(value, axis.lower, axis.upper) is None:
                raise OutOfLimits(f"axis {axis.name} would leave its travel", axis=axis.name)
        return axes


def _rows(table: NDArray[np.float64]) -> tuple[Row, ...]:
    return tuple(tuple(float(value) for value in row) for row in table)


def _times(rows: tuple[Row, ...], vector: Sequence[float]) -> Joints:
    return tuple([sum([a * b for a, b in zip(row, vector, strict=True)]) for row in rows])
