"""Additional axes: a robot with axes 7 .. 24 that move with it, carry it, or turn the workpiece.

Reis counts up to 24 axes in one position (L4008-4038); rho 3 has the fifth axis of a portal or a belt in the same way.  An
additional axis follows its own target in time with the path; the inverse leaves it where `near` has it, so a planner that
knows its course passes that in `near`.  `Group` sees the flange from the world, which carriers leave where it is; `OnTable` sees it
from the workpiece, which tables turn away below it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.geometry.frames import IDENTITY, Pose, Vector, compose, rotate
from motion.geometry.limits import AxisLimits
from motion.geometry.orientation import rotation_by
from motion.geometry.units import Kind, kind_of
from motion.kinematics.base import Branch, Configuration, Joints, Kinematics, OutOfLimits, PathKinematics
from motion.kinematics.choice import inside
from motion.kinematics.placed import Placed, first_of

MOST = 24


class Role(Enum):
    """What an additional axis does to the geometry."""

    FREE = "free"  # nothing: a gripper's spindle, a feeder
    CARRIER = "carrier"  # carries the robot's base: a track, a column
    TABLE = "table"  # carries the workpiece: a rotary table


@dataclass(frozen=True, slots=True)
class Additional:
    """One axis: its limits, its role, and for carriers and tables the line it moves along or about (unit vector, from the origin)."""

    limits: AxisLimits
    role: Role = Role.FREE
    direction: Vector = (0.0, 0.0, 1.0)
    origin: Pose = IDENTITY  # pose of the axis on its carrier

    def __post_init__(self) -> None:
        if not abs(math.hypot(*self.direction) - 1.0) < 1e-9:
            raise MotionError(f"axis {self.limits.name}: direction {self.direction} has not the length 1")

    def motion(self, value: float) -> Pose:
        """Frame of what the axis carries; value: m or rad."""
        x, y, z = (value * part for part in self.direction)
        if kind_of(self.limits.unit) is Kind.LINEAR:
            return compose(self.origin, Pose((x, y, z), IDENTITY.rotation))
        return compose(self.origin, Pose((0.0, 0.0, 0.0), rotation_by((x, y, z))))


class Group:
    """A robot and its additional axes; q: the robot's joints, then the additional ones."""

    def __init__(self, main: Kinematics, extra: Sequence[Additional]) -> None:
        self.main, self.extra, self.axes = main, tuple(extra), main.axes + len(extra)
        if self.axes > MOST:
            raise MotionError(f"{self.axes} axes in one group, at most {MOST}")
        self.carriers = any(axis.role is Role.CARRIER for axis in extra)

    def base(self, q: Sequence[float]) -> Pose:
        """Where the carriers have brought the robot's base."""
        return self._carried(q, Role.CARRIER)

    def table(self, q: Sequence[float]) -> Pose:
        """Where the tables have brought the workpiece."""
        return self._carried(q, Role.TABLE)

    def forward(self, q: Sequence[float]) -> Pose:
        """Flange in the world of the group."""
        pose = self.main.forward(q[: self.main.axes])
        return compose(self.base(q), pose) if self.carriers else pose

    def inverse(self, pose: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """The robot reaches the pose with the additional axes where `near` has them."""
        rest = self._rest(near)
        return (*self.main.inverse(self._seen(pose, near), near[: self.main.axes], configuration), *rest)

    def follow(self, pose: Pose, near: Sequence[float]) -> Joints:
        """As the robot's own."""
        rest = self._rest(near)
        return (*self.main.follow(self._seen(pose, near), near[: self.main.axes]), *rest)

    def branches(self, pose: Pose) -> list[Branch]:
        """With all additional axes at 0."""
        zeros = (0.0,) * len(self.extra)
        return [((*joints, *zeros), flags) for joints, flags in self.main.branches(self._seen(pose, (0.0,) * self.axes))]

    def configuration(self, q: Sequence[float]) -> Configuration:
        """The robot's."""
        return self.main.configuration(q[: self.main.axes])

    def jacobian(self, q: Sequence[float]) -> NDArray[np.float64]:
        """(6, axes); the columns of carriers move the entire robot, those of tables and free axes are 0."""
        columns = np.zeros((6, self.axes))
        base = self.base(q)
        tip = compose(base, self.main.forward(q[: self.main.axes])).position
        turn = np.array(base.rotation).reshape(3, 3)
        own = self.main.jacobian(q[: self.main.axes])
        columns[:, : self.main.axes] = np.vstack((turn @ own[:3], turn @ own[3:]))
        self._put(columns, q, tip, Role.CARRIER)
        return columns

    def _put(self, columns: NDArray[np.float64], q: Sequence[float], tip: Vector, role: Role) -> None:
        """Write into the columns of a role's axes how they move a carried point that is at `tip` in the world."""
        below = IDENTITY
        for number, axis in enumerate(self.extra, self.main.axes):
            if axis.role is not role:
                continue
            place = compose(below, axis.origin)
            x, y, z = rotate(place.rotation, axis.direction)
            if kind_of(axis.limits.unit) is Kind.LINEAR:
                columns[:3, number] = (x, y, z)
            else:
                u, v, w = (a - b for a, b in zip(tip, place.position, strict=True))
                columns[:, number] = (y * w - z * v, z * u - x * w, x * v - y * u, x, y, z)
            below = compose(below, axis.motion(q[number]))

    def _carried(self, q: Sequence[float], role: Role) -> Pose:
        pose = IDENTITY
        for axis, value in zip(self.extra, q[self.main.axes :], strict=True):
            if axis.role is role:
                pose = compose(pose, axis.motion(value))
        return pose

    def _seen(self, pose: Pose, near: Sequence[float]) -> Pose:
        """The pose as the robot's base sees it."""
        return compose(self.base(near).inverse(), pose) if self.carriers else pose

    def _rest(self, near: Sequence[float]) -> tuple[float, ...]:
        if len(near) != self.axes:
            raise MotionError(f"{len(near)} joints given as near, {self.axes} axes")
        rest = tuple(near[self.main.axes :])
        for axis, value in zip(self.extra, rest, strict=True):
            if inside(value, axis.limits.lower, axis.limits.upper) is None:
                raise OutOfLimits(f"axis {axis.limits.name} would leave its travel", axis=axis.limits.name)
        return rest


class OnTable(Group):
    """A group as the workpiece on its tables sees it: poses are those of the flange in a frame that lies on the last table, and is the
    world where all tables are at 0 (AX-565)."""

    def __init__(self, main: Kinematics, extra: Sequence[Additional]) -> None:
        super().__init__(main, extra)
        self._zero = self.table((0.0,) * self.axes).inverse()

    def workpiece(self, q: Sequence[float]) -> Pose:
        """Where the tables have brought the frame, in the world."""
        return compose(self.table(q), self._zero)

    def forward(self, q: Sequence[float]) -> Pose:
        """Flange, seen from the workpiece."""
        return compose(self.workpiece(q).inverse(), super().forward(q))

    def jacobian(self, q: Sequence[float]) -> NDArray[np.float64]:
        """(6, axes): a table moves the workpiece away below the flange, so the flange goes the other way."""
        columns = super().jacobian(q)
        below = np.zeros_like(columns)
        self._put(below, q, super().forward(q).position, Role.TABLE)
        columns -= below
        turn = np.array(self.workpiece(q).rotation).reshape(3, 3).T
        return np.vstack((turn @ columns[:3], turn @ columns[3:]))

    def _seen(self, pose: Pose, near: Sequence[float]) -> Pose:
        return super()._seen(compose(self.workpiece(near), pose), near)


def on_course(kinematics: PathKinematics, near: Sequence[float], course: Sequence[float]) -> Joints:
    """Joints near which to look for others: those of the arm from `near`, additional axes and those of robots before it where their course
    has them; both (axes,) or longer, as the axes of a cell are."""
    first, robot = first_of(kinematics), kinematics.own if isinstance(kinematics, Placed) else kinematics
    arm = first + (robot.main.axes if isinstance(robot, Group) else robot.axes)
    return (*course[:first], *near[first:arm], *course[arm : kinematics.axes])
