"""Choice of a branch: the nearest solution inside the limits that has the demanded configuration.

VAL 3, pointToJoint (L5177-5190): fields FREE demand nothing, SAME keeps the configuration of the start joints, and an axis with a travel
of several turns uses the turn nearest to its position.
"""

import math
from collections.abc import Sequence

from motion.errors import MotionError
from motion.geometry.limits import TOUCH, AxisLimits
from motion.geometry.units import Kind, kind_of
from motion.kinematics.base import Branch, Configuration, Joints, KinematicsError, OutOfLimits, Unreachable, WrongConfiguration

TURN = 2.0 * math.pi
BESIDE = 3.0  # rad: nearer than that no other turn is nearer
ROUNDING = 1e-9  # of a way: smaller differences count as equal


def wrapped(angle: float) -> float:
    """Return the same direction in -pi .. pi; NaN for an angle that is not finite."""
    if -math.pi <= angle <= math.pi:
        return angle
    return math.remainder(angle, TURN) if math.isfinite(angle) else math.nan


def nearest_turn(angle: float, near: float, lower: float, upper: float) -> float | None:
    """Return `angle` plus full turns, inside the limits, nearest to `near` (all rad); None where no turn fits."""
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
        kinds = (kind_of(axis.unit) for axis in limits)
        self._rows = tuple(
            (k, axis.lower, axis.upper, 1.0 / axis.speed, BESIDE if kind is Kind.ROTARY else math.inf)
            for k, (axis, kind) in enumerate(zip(limits, kinds, strict=True))
        )

    def fit(self, joints: Joints, near: Sequence[float], least: float = math.inf) -> tuple[Joints, float]:
        """The turns of `joints` nearest to `near` and how far that is (seconds at full speed, squared); inf where an axis cannot.

        Where it is farther than `least` the rest is not looked at.
        """
        fitted: list[float] = []  # empty: they are what they were
        far = 0.0
        for axis, lower, upper, pace, beside in self._rows:  # no zip: creating one costs as much as three axes
            value, here = joints[axis], near[axis]
            step = value - here
            if not (lower <= value <= upper and -beside < step < beside):
                if beside == math.inf:
                    turned = inside(value, lower, upper)
                elif least < math.inf and (math.remainder(step, TURN) * pace) ** 2 > least * (1.0 + ROUNDING):
                    return joints, math.inf
                else:
                    turned = nearest_turn(value, here, lower, upper)
                if turned is None:
                    return joints, math.inf
                fitted = fitted or list(joints)
                fitted[axis] = turned
                step = turned - here
            step *= pace
            far += step * step
            if far > least:
                break
        return tuple(fitted) if fitted else joints, far

    def choose(self, branches: Sequence[Branch], near: Sequence[float], wanted: Configuration | None, now: Configuration) -> Joints:
        """The nearest branch that meets `wanted` (SAME: as `now`), of equals the first; raises Unreachable, OutOfLimits or
        WrongConfiguration.

        One in the configuration of `near` is looked at before the others: nearly always it is the nearest, and little of the others
        is looked at then.
        """
        if len(near) != len(self._rows):
            raise MotionError(f"{len(near)} joints given as near, {len(self._rows)} axes")
        best: Joints | None = None
        least = math.inf
        like: Joints | None = None
        for joints, found in branches:
            if found is now:
                like, fit = joints, self.fit(joints, near)
                if wanted is None or wanted.admits(found, now):
                    least = math.nextafter(fit[1], math.inf)  # an equal one that is before it is taken still
                break
        for joints, found in branches:
            if wanted is None or wanted.admits(found, now):
                fitted, far = fit if joints is like else self.fit(joints, near, least)
                if far < least:
                    best, least = fitted, far
        if best is None:
            raise self._complaint(branches, near, wanted)
        return best

    def _complaint(self, branches: Sequence[Branch], near: Sequence[float], wanted: Configuration | None) -> KinematicsError:
        """Why none of them will do."""
        if not branches:
            return Unreachable("out of reach")
        if not all(map(math.isfinite, (*near, *branches[0][0]))):
            return Unreachable("the pose, or the joints to start from, hold a value that is not a finite number")
        blamed = [self._blamed(joints, near) for joints, _ in branches]
        if None in blamed and wanted is not None:
            words = f"{wanted.shoulder.value} {wanted.elbow.value} {wanted.wrist.value}"
            return WrongConfiguration(f"not in the configuration {words}, though in another one")
        axis = self._limits[next((axis for axis in blamed if axis is not None), 0)]
        return OutOfLimits(f"axis {axis.name} would leave its travel", axis=axis.name)

    def _blamed(self, joints: Joints, near: Sequence[float]) -> int | None:
        """The first axis that cannot; None: all can."""
        for axis, lower, upper, _, beside in self._rows:
            turned = inside(joints[axis], lower, upper) if beside == math.inf else nearest_turn(joints[axis], near[axis], lower, upper)
            if turned is None:
                return axis
        return None


def inside(value: float, lower: float, upper: float) -> float | None:
    """The value when it lies inside but for rounding, else None."""
    return value if lower - TOUCH <= value <= upper + TOUCH else None
