"""Interface of all kinematics, the configurations of an arm, and the errors of an inverse.

Configurations and their words are VAL 3's (chapter 9.7, L5266-5281), because of the three controls only VAL 3 writes them down.
Errors carry the number VAL 3 gives (appendix, L6670-6679) and rho 3's words ("point not reachable", L4768-4844); rho 3 and
Reis print none of their own for them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.geometry.frames import Pose

Joints = tuple[float, ...]  # m or rad, one an axis
RHO3_TEXT = "point not reachable"


def beyond(value: float, least: float, most: float) -> str:
    """A value outside, with as many digits as show that it is: at least three."""
    digits = next((n for n in range(3, 9) if not round(least, 3) <= round(value, n) <= round(most, 3)), 3)
    return f"{value:.{digits}f}"


class Shoulder(Enum):
    RIGHTY, LEFTY, SAME, FREE = "righty", "lefty", "ssame", "sfree"


class Elbow(Enum):
    POSITIVE, NEGATIVE, SAME, FREE = "epositive", "enegative", "esame", "efree"


class Wrist(Enum):
    POSITIVE, NEGATIVE, SAME, FREE = "wpositive", "wnegative", "wsame", "wfree"


@dataclass(frozen=True, slots=True)
class Configuration:
    """The configuration that a point demands, or that of the arm's joints; FREE everywhere = no demand."""

    shoulder: Shoulder = Shoulder.FREE
    elbow: Elbow = Elbow.FREE
    wrist: Wrist = Wrist.FREE

    def admits(self, found: "Configuration", near: "Configuration") -> bool:
        """True when joints of configuration `found` meet this demand; SAME means as in `near` (L5266-5281)."""
        return (
            (self.shoulder is Shoulder.FREE or found.shoulder is (near if self.shoulder is Shoulder.SAME else self).shoulder)
            and (self.elbow is Elbow.FREE or found.elbow is (near if self.elbow is Elbow.SAME else self).elbow)
            and (self.wrist is Wrist.FREE or found.wrist is (near if self.wrist is Wrist.SAME else self).wrist)
        )


FREE = Configuration()
SAME = Configuration(Shoulder.SAME, Elbow.SAME, Wrist.SAME)

Branch = tuple[Joints, Configuration]


class KinematicsError(MotionError):
    """A pose that this robot cannot reach.

    `number` is the VAL 3 run-time error, `axis` the axis at fault if there is one, `at` the place on the curve that leads there if there
    is one, and `joints` the joints before it.
    """

    number = 530

    def __init__(self, message: str, axis: str = "", number: int | None = None, at: float | None = None) -> None:
        self.axis = axis
        self.at = at
        self.joints: Joints = ()
        if number is not None:
            self.number = number
        self.plain = f"{RHO3_TEXT}: {message}"  # for a control that has no such number
        super().__init__(f"{self.plain} (VAL 3 error {self.number})")


class Unreachable(KinematicsError):
    """No joints lead there: 530 out of reach, 532 outside the workspace, 534 orientation impossible with this arm."""

    number = 530


class OutOfLimits(KinematicsError):
    """Joints lead there, all of them beyond a travel limit: 531."""

    number = 531


class WrongConfiguration(KinematicsError):
    """Reachable, but not in the configuration that is demanded: 533."""

    number = 533


class SingularPose(KinematicsError):
    """The robot is in a pose from which it cannot move in every direction: 540."""

    number = 540


class PathKinematics(Protocol):
    """What the cycle needs of a robot that is on its path.  axes: how many joints; q and near: (axes,) m or rad; poses are those of the
    flange in the base of the robot."""

    @property
    def axes(self) -> int: ...

    def forward(self, q: Sequence[float]) -> Pose:
        """Where the flange is."""
        ...

    def follow(self, pose: Pose, near: Sequence[float]) -> Joints:
        """As Kinematics.inverse for a path: shoulder and elbow stay as in `near`, the wrist goes the shorter way.  The fast one."""
        ...


class Kinematics(PathKinematics, Protocol):
    """All that a planner asks of a robot."""

    def inverse(self, pose: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """The joints inside the limits that are nearest to `near` and meet `configuration` (None: any).

        Raises Unreachable, OutOfLimits or WrongConfiguration.
        """
        ...

    def branches(self, pose: Pose) -> list[Branch]:
        """All ways to reach the pose, rotary axes in -pi .. pi, limits not looked at; empty when there is none."""
        ...

    def jacobian(self, q: Sequence[float]) -> NDArray[np.float64]:
        """(6, axes): rows 0-2 m and rows 3-5 rad of the flange, in the base frame, for each m or rad of an axis."""
        ...

    def configuration(self, q: Sequence[float]) -> Configuration:
        """The configuration of these joints; FREE in fields this robot does not have."""
        ...


def along_path(kinematics: Kinematics) -> Callable[[Pose, Joints], Joints]:
    """Return the inverse for the next place of a path.

    A numerically solved arm (Urdf) is searched only from the previous joints: any other start would make it jump, and the search would
    need a minute where the arm cannot continue.
    """
    inner = kinematics
    while (deeper := getattr(inner, "main", None) or getattr(inner, "inner", None)) is not None:
        inner = deeper
    return kinematics.follow if getattr(inner, "searches", False) else kinematics.inverse
