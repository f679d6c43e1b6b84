"""Any robot out of a URDF text, numerically: forward and Jacobian by pinocchio, inverse by damped least squares.

For robots that have no closed form here.  The inverse starts at `near` and, where that does not lead there, at a fixed row of
well spread joints (Halton), so the same question always gets the same answer; joints stay inside their limits at every step.
It finds a way, not all ways: `branches` gives what the search found.
"""

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.geometry.frames import Pose
from motion.geometry.limits import AxisLimits
from motion.kinematics.base import FREE, Branch, Configuration, Joints, OutOfLimits, Unreachable, WrongConfiguration

Array = NDArray[np.float64]
CLOSE = 1e-10  # m and rad: error of a pose that counts as reached
ROUNDS = 60  # steps from one start
STARTS = 60  # other starts after `near`
PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89)
ASSUMED_ACCEL = 5.0  # 1/s: a URDF names no acceleration; the speed limit is reached in 0.2 s (AX-356)
ASSUMED_JERK = 10.0  # 1/s: and the acceleration in 0.1 s
AT_LIMIT = 2e-3  # m or rad: an axis so near to the end of its travel is what a path cannot go on for
SAME = 1e-6  # m or rad: two results of the search that are one


class Urdf:
    """One chain of single-axis joints up to `frame`; limits: of the joints in their order, or those of the URDF."""

    searches = True  # its inverse does, from many places

    def __init__(self, text: str, frame: str, limits: Sequence[AxisLimits] | None = None) -> None:
        try:
            self._model = pin.buildModelFromXML(text)
        except (ValueError, RuntimeError) as error:
            raise MotionError(f"no robot can be made of this URDF: {error}") from error
        joints = list(self._model.joints)[1:]
        if not joints or len(joints) > len(PRIMES) or any(joint.nv != 1 for joint in joints):
            raise MotionError(f"a URDF of 1 .. {len(PRIMES)} joints with one axis each is needed, this has {len(joints)}")
        if not self._model.existFrame(frame):
            raise MotionError(f"the URDF has no link or joint {frame!r}")
        self.axes: int = self._model.nv
        self._frame = self._model.getFrameId(frame)
        self._data = self._model.createData()
        self._places = tuple((int(joint.idx_q), int(joint.nq)) for joint in joints)
        self.limits = tuple(limits) if limits is not None else self._own_limits()
        if len(self.limits) != self.axes:
            raise MotionError(f"{len(self.limits)} limits for {self.axes} joints")
        self._lower = np.array([axis.lower for axis in self.limits])
        self._upper = np.array([axis.upper for axis in self.limits])
        width = self._upper - self._lower  # Halton points in the limits
        spread = [[_radical(n, base) for base in PRIMES[: self.axes]] for n in range(1, STARTS + 1)]
        self._starts = [self._lower + width * np.array(shares) for shares in spread]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the joints, in the order of q."""
        return tuple(str(name) for name in list(self._model.names)[1:])

    def forward(self, q: Sequence[float]) -> Pose:
        """(axes,) rad or m -> the frame in the base."""
        pin.framesForwardKinematics(self._model, self._data, self._full(q))
        place = self._data.oMf[self._frame]
        x, y, z = (float(value) for value in place.translation)
        a, b, c, d, e, f, g, h, i = (float(value) for value in place.rotation.ravel())
        return Pose((x, y, z), (a, b, c, d, e, f, g, h, i))

    def jacobian(self, q: Sequence[float]) -> Array:
        """(6, axes); the forward pass comes first, since the frame's Jacobian does not refresh the places of the joints."""
        full = self._full(q)
        pin.framesForwardKinematics(self._model, self._data, full)
        found: Array = np.array(
            pin.computeFrameJacobian(self._model, self._data, full, self._frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        )
        return found

    def inverse(self, pose: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """A way inside the limits, from `near` if that leads there; configurations are not known here: 533 when one is demanded."""
        if configuration is not None and configuration != FREE:
            raise WrongConfiguration("this robot's configurations have no names")
        if not all(map(math.isfinite, (*pose.position, *pose.rotation, *near))):
            raise Unreachable("the pose holds a value that is no finite number")
        for start in (np.array(near, dtype=float), *self._starts):
            joints = self._search(pose, start)
            if joints is not None:
                return joints
        raise Unreachable(f"{STARTS + 1} searches did not converge")

    def follow(self, pose: Pose, near: Sequence[float]) -> Joints:
        """From `near` alone: a path does not jump."""
        joints = self._search(pose, np.array(near, dtype=float))
        if joints is None:
            for axis, value in zip(self.limits, near, strict=True):
                if min(value - axis.lower, axis.upper - value) < AT_LIMIT:
                    raise OutOfLimits(f"axis {axis.name} would leave its travel", axis=axis.name)
            raise Unreachable("the search from the joints before did not converge")
        return joints

    def branches(self, pose: Pose) -> list[Branch]:
        """What the search finds from all its starts, each once."""
        found: list[Joints] = []
        for start in self._starts:
            joints = self._search(pose, start)
            if joints is not None and all(max(abs(a - b) for a, b in zip(joints, one, strict=True)) > SAME for one in found):
                found.append(joints)
        return [(joints, FREE) for joints in found]

    def configuration(self, q: Sequence[float]) -> Configuration:
        """None with a name."""
        return FREE

    def _search(self, pose: Pose, start: Array) -> Joints | None:
        """Damped least squares; the damping falls with the error and rises where a step did not help."""
        goal = pin.SE3(np.array(pose.rotation).reshape(3, 3), np.array(pose.position))
        q: Array = np.clip(start, self._lower, self._upper)
        error, size = self._miss(goal, q)
        damping = 1e-3
        for _ in range(ROUNDS):
            if size < CLOSE:
                return tuple(float(value) for value in q)
            jacobian = self._error_jacobian(goal, q)
            trial: Array = np.clip(q - _damped(jacobian, error, damping * min(1.0, size)), self._lower, self._upper)
            missed, left = self._miss(goal, trial)
            if left < size:
                q, error, size, damping = trial, missed, left, max(damping * 0.3, 1e-9)
            else:
                damping *= 8.0
                if damping > 1e6:
                    return None
        return None

    def _miss(self, goal: "pin.SE3", q: Array) -> tuple[Array, float]:
        """(twist from the goal to where q is, its length)."""
        pin.framesForwardKinematics(self._model, self._data, self._full(q))
        error: Array = pin.log6(goal.actInv(self._data.oMf[self._frame])).vector
        return error, float(np.linalg.norm(error))

    def _error_jacobian(self, goal: "pin.SE3", q: Array) -> Array:
        """Change of the error by the joints; _miss has just placed the frames."""
        full = self._full(q)
        pin.framesForwardKinematics(self._model, self._data, full)
        local = pin.computeFrameJacobian(self._model, self._data, full, self._frame, pin.ReferenceFrame.LOCAL)
        found: Array = pin.Jlog6(goal.actInv(self._data.oMf[self._frame])) @ local
        return found

    def _full(self, q: Sequence[float] | Array) -> Array:
        """Joints -> pinocchio's q, which holds cosine and sine of joints that turn without end."""
        full: Array = np.zeros(self._model.nq)
        for value, (place, size) in zip(q, self._places, strict=True):
            if size == 1:
                full[place] = value
            else:
                full[place], full[place + 1] = math.cos(value), math.sin(value)
        return full

    def _own_limits(self) -> tuple[AxisLimits, ...]:
        """Travel and speed of the URDF; acceleration and jerk are assumed."""
        limits = []
        for number, (name, (place, size)) in enumerate(zip(self.names, self._places, strict=True)):
            speed = float(self._model.velocityLimit[number])
            speed = speed if 0.0 < speed < math.inf else 1.0
            lower, upper = (
                (-math.pi, math.pi)
                if size == 2
                else (float(self._model.lowerPositionLimit[place]), float(self._model.upperPositionLimit[place]))
            )
            unit = "m" if self._model.joints[number + 1].shortname().startswith("JointModelP") else "rad"
            limits.append(AxisLimits(name, lower, upper, speed, ASSUMED_ACCEL * speed, ASSUMED_ACCEL * ASSUMED_JERK * speed, unit))
        return tuple(limits)


def _damped(jacobian: Array, error: Array, damping: float) -> Array:
    """The step of damped least squares.  Of more axes than the pose has numbers the shortest one, by the smaller of both systems: the other
    one is singular but for its damping."""
    rows, columns = jacobian.shape
    wide = columns > rows
    normal = (jacobian @ jacobian.T if wide else jacobian.T @ jacobian) + damping * np.eye(min(rows, columns))
    try:
        found = np.linalg.solve(normal, error if wide else jacobian.T @ error)
    except np.linalg.LinAlgError:  # a pole, and hardly any damping left
        found = np.linalg.lstsq(normal, error if wide else jacobian.T @ error, rcond=None)[0]
    return np.asarray(jacobian.T @ found if wide else found, dtype=np.float64)


def _radical(number: int, base: int) -> float:
    """Digits of `number` in `base`, mirrored behind the point."""
    value, part = 0.0, 1.0
    while number:
        part /= base
        number, digit = divmod(number, base)
        value += digit * part
    return value
