"""Any robot out of a URDF text, numerically: forward and Jacobian by pinocchio, inverse by damped least squares.

For robots that have no closed form here.  The inverse starts at `near` and, where that does not lead there, at a fixed row of
well spread joints (Halton), so the same question always gets the same answer; joints stay inside their limits at every step.
The search need not find all solutions: `branches` returns those that it found.
"""

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.geometry.frames import Pose
from motion.geometry.limits import AxisLimits
from motion.geometry.units import Kind, kind_of
from motion.kinematics.base import FREE, Branch, Configuration, Joints, OutOfLimits, Unreachable, WrongConfiguration
from motion.kinematics.urdf_chain import Chain, ChainJoint, chain_of

Array = NDArray[np.float64]
CLOSE = 1e-10  # m and rad: error of a pose that counts as reached
ROUNDS = 60  # steps from one start
STARTS = 60  # other starts after `near`
PRIMES = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89)
ASSUMED_ACCEL = 5.0  # 1/s: a URDF names no acceleration; the speed limit is reached in 0.2 s (AX-356)
ASSUMED_JERK = 10.0  # 1/s: and the acceleration in 0.1 s
AT_LIMIT = 2e-3  # m or rad: an axis this near to the end of its travel is blamed when a path cannot continue
SAME = 1e-6  # m or rad: two results of the search that are one


class Urdf:
    """One chain of single-axis joints up to `frame`; limits: of the joints in their order, or those of the URDF."""

    searches = True  # its inverse does, from many places

    def __init__(self, text: str, frame: str, limits: Sequence[AxisLimits] | None = None) -> None:
        chain = chain_of(text, frame)
        axes = chain.axes
        if not axes or len(axes) > len(PRIMES):
            raise MotionError(f"a URDF of 1 .. {len(PRIMES)} axes up to {frame!r} is needed, this has {len(axes)}")
        self.axes: int = len(axes)
        self.names = tuple(joint.name for joint in axes)
        self.limits = tuple(limits) if limits is not None else tuple(map(_own_limits, axes))
        _check_limits(axes, self.limits)
        self._model, self._frame = _model(chain)
        self._data = self._model.createData()
        self._by_axes = np.zeros((len(chain.moving), self.axes))  # change of each joint by the axes
        for number, joint in enumerate(chain.moving):
            self._by_axes[number, joint.follows] = joint.factor
        self._shift = np.array([joint.offset for joint in chain.moving])
        self._coupled = len(chain.moving) > self.axes
        self._lower = np.array([axis.lower for axis in self.limits])
        self._upper = np.array([axis.upper for axis in self.limits])
        width = self._upper - self._lower  # Halton points in the limits
        spread = [[_radical(n, base) for base in PRIMES[: self.axes]] for n in range(1, STARTS + 1)]
        self._starts = [self._lower + width * np.array(shares) for shares in spread]

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
        return self._of_axes(found)

    def inverse(self, pose: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """A way inside the limits, from `near` if that leads there; configurations are not known here: 533 when one is demanded."""
        if configuration is not None and configuration != FREE:
            raise WrongConfiguration("this robot's configurations have no names")
        if not all(map(math.isfinite, (*pose.position, *pose.rotation, *near))):
            raise Unreachable("the pose holds a value that is not a finite number")
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
        return self._of_axes(pin.Jlog6(goal.actInv(self._data.oMf[self._frame])) @ local)

    def _of_axes(self, jacobian: Array) -> Array:
        """Reduce the Jacobian of all moving joints to the axes; pinocchio drops the second dimension for a single joint."""
        columns = jacobian.reshape(6, -1)
        return columns @ self._by_axes if self._coupled else columns

    def _full(self, q: Sequence[float] | Array) -> Array:
        """Axes -> all moving joints, those that follow one, too."""
        axes = np.asarray(q, dtype=np.float64)
        if axes.shape != (self.axes,):
            raise MotionError(f"{axes.size} positions for {self.axes} axes")
        return self._by_axes @ axes + self._shift if self._coupled else axes


def _model(chain: Chain) -> tuple["pin.Model", int]:
    """The chain for pinocchio, and the number of its frame.  Joints that turn do so without end: their travel is that of the axes."""
    model = pin.Model()
    joint, place = 0, pin.SE3.Identity()
    for each in chain.joints:
        place = place * pin.SE3(pin.rpy.rpyToMatrix(np.array(each.rpy)), np.array(each.xyz))
        if each.follows is not None:
            moves = pin.JointModelPrismaticUnaligned if each.slides else pin.JointModelRevoluteUnaligned
            joint, place = model.addJoint(joint, moves(np.array(each.axis)), place, each.name), pin.SE3.Identity()
    return model, int(model.addFrame(pin.Frame("end of the chain", joint, place, pin.FrameType.OP_FRAME)))


def _check_limits(joints: Sequence[ChainJoint], limits: Sequence[AxisLimits]) -> None:
    """As many axes as the chain has, each in the unit of its joint."""
    if len(limits) != len(joints):
        raise MotionError(f"{len(limits)} axes for {len(joints)} joints of the URDF: {', '.join(joint.name for joint in joints)}")
    for axis, joint in zip(limits, joints, strict=True):
        if joint.slides is not (kind_of(axis.unit) is Kind.LINEAR):
            moves, unit = ("slides", "mm") if joint.slides else ("turns", "deg")
            raise MotionError(f"axis {axis.name}: joint {joint.name!r} of the URDF {moves}, so its unit is {unit}, not {axis.unit}")


def _own_limits(joint: ChainJoint) -> AxisLimits:
    """Travel and speed of the URDF; acceleration and jerk are assumed."""
    if joint.travel is None and joint.slides:
        raise MotionError(f"joint {joint.name!r} of the URDF has no travel")
    lower, upper, speed = joint.travel or (-math.pi, math.pi, 1.0)
    speed = speed if 0.0 < speed < math.inf else 1.0
    unit = "m" if joint.slides else "rad"
    return AxisLimits(joint.name, lower, upper, speed, ASSUMED_ACCEL * speed, ASSUMED_ACCEL * ASSUMED_JERK * speed, unit)


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
    """Return the digits of `number` in `base`, mirrored at the radix point."""
    value, part = 0.0, 1.0
    while number:
        part /= base
        number, digit = divmod(number, base)
        value += digit * part
    return value
