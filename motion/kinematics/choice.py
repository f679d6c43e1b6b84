"""Of all ways to reach a pose: the one inside the limits that lies nearest and has the configuration that is demanded.

VAL 3, pointToJoint (L5177-5190): fields FREE demand nothing, SAME means as the joints one comes from, and an axis that can
turn more than once takes the turn nearest to where it is.
"""

import math
from collections.abc import Sequence

from motion.errors import MotionError
from motion.kinematics.base import Branch, Configuration, Joints, KinematicsError, OutOfLimits, Unreachable, WrongConfiguration
from motion.limits import TOUCH, AxisLimits
from motion.units import Kind, kind_of

TURN = 2.0 * math.pi


def wrapped(angle: float) -> float:
    """The same direction in -pi .. pi; NaN for what is no finite angle."""
    if -math.pi <= angle <= math.pi:
        return angle
    return math.remainder(angle, TURN) if math.isfinite(angle) else math.nan


def nearest_turn(angle: float, near: float, lower: float, upper: float) -> float | None:
    """`angle` plus whole turns, inside the limits, nearest to `near` (all rad); None where no turn fits."""
    if not math.isfinite(near - angle):
        return None
    angle += TURN * round((near - angle) / TURN)
    if lower - TOUCH <= angle <= upper + TOUCH:
        return angle
    angle += TURN * (math.ceil((lower - TOUCH - angle) / TURN) if angle < lower else -math.ceil((angle - upper - TOUCH) / TURN))
    return angle if lower - TOUCH <= angle <= upper + TOUCH else None


class Chooser:
    """Chooses among branches for a robot with these limits."""

    __slots__ = ("_limits", "_rows")

    def __init__(self, limits: Sequence[AxisLimits]) -> None:
        self._limits = tuple(limits)
        self._rows = tuple((axis.lower, axis.upper, 1.0 / axis.speed, kind_of(axis.unit) is Kind.ROTARY) for axis in limits)

    def fit(self, joints: Joints, near: Sequence[float], least: float = math.inf) -> tuple[Joints, float] | int:
        """The turns of `joints` nearest to `near` and how far that is (seconds at full speed, squared), or the axis that cannot.

        Where it is farther than `least` the rest is not looked at.
        """
        fitted: list[float] = []
        far = 0.0
        for value, here, (lower, upper, pace, rotary) in zip(joints, near, self._rows, strict=True):
            step = value - here
            if not lower <= value <= upper or (rotary and not -3.0 < step < 3.0):
                turned = nearest_turn(value, here, lower, upper) if rotary else inside(value, lower, upper)
                if turned is None:
                    return len(fitted)
                value = turned
                step = value - here
            fitted.append(value)
            step *= pace
            far += step * step
            if far > least:
                break
        return tuple(fitted), far

    def choose(self, branches: Sequence[Branch], near: Sequence[float], wanted: Configuration | None, now: Configuration) -> Joints:
        """The nearest branch that meets `wanted` (SAME: as `now`); raises Unreachable, OutOfLimits or WrongConfiguration."""
        if len(near) != len(self._rows):
            raise MotionError(f"{len(near)} joints given as near, {len(self._rows)} axes")
        best: Joints | None = None
        least = math.inf
        for joints, found in branches:
            if wanted is None or wanted.admits(found, now):
                fit = self.fit(joints, near, least)
                if not isinstance(fit, int) and fit[1] < least:
                    best, least = fit
        if best is None:
            raise self._complaint(branches, near, wanted)
        return best

    def _complaint(self, branches: Sequence[Branch], near: Sequence[float], wanted: Configuration | None) -> KinematicsError:
        """Why none of them will do."""
        if not branches:
            return Unreachable("out of reach")
        if not all(map(math.isfinite, (*near, *branches[0][0]))):
            return Unreachable("the pose, or the joints to start from, hold a value that is no finite number")
        fits = [self.fit(joints, near) for joints, _ in branches]
        blamed = [fit for fit in fits if isinstance(fit, int)]
        if len(blamed) < len(fits) and wanted is not None:
            words = f"{wanted.shoulder.value} {wanted.elbow.value} {wanted.wrist.value}"
            return WrongConfiguration(f"not in the configuration {words}, though in another one")
        axis = self._limits[blamed[0]]
        return OutOfLimits(f"axis {axis.name} would leave its travel", axis=axis.name)


def inside(value: float, lower: float, upper: float) -> float | None:
    """The value when it lies inside but for rounding, else None."""
    return value if lower - TOUCH <= value <= upper + TOUCH else None
