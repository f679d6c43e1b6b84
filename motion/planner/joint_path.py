"""TCP curve + kinematics -> path of the axes: quintic Hermite pieces, halved until they follow the inverse to a tolerance.

Values come from the inverse, slopes from the Jacobian (q' = J^-1 x'), bends from its change along q' (q'' = J^-1 (x'' - J' q')).
The branch is kept by continuity: every inverse starts from the joints before it, and an interval counts only when its quintics follow
the curve, so a path never jumps from one arm configuration to another (VAL 3 L5547-5554: a change of configuration cannot be forced on
a line).  Near a wrist pole the intervals become as short as the swing of the axes; through the pole itself, where the inverse does not
determine axes 4 and 6, the quintics are judged by the tool's position (AX-660).

Additional axes that carry the robot or the workpiece have their own given course e(s); the arm makes the remainder of the twist: J q' = x'
- J_e e', and one order on J q'' = x'' - J' (q', e') - J_e e'' (AX-565).
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motion.geometry.frames import IDENTITY, Pose
from motion.geometry.orientation import angle_between
from motion.kinematics.base import Joints, Kinematics, KinematicsError, SingularPose, along_path
from motion.paths.base import Curve
from motion.paths.corner import hermite
from motion.paths.joints import JointPath, joint_path
from motion.paths.mounted import Mounted
from motion.paths.polynomial import Chain, Row, whole
from motion.paths.tool_path import FINEST, Rate, rate_of, tool_rows
from motion.planner.additional_axes import states

TOLERANCE = 2e-9  # m or rad between path and inverse (1e-6 is owed): parts cut out of it still fit each other
PROBES = (0.15, 0.35, 0.5, 0.65, 0.85)
SHORTEST = 1e-12  # of the curve: an interval that has to be halved further does not follow the inverse at all
BORDER = 1e-4  # of the curve: so near to where it leaves the reach a place is reported
LARGEST = 0.5  # m or rad between neighbouring knots
AT_POLE = 5e-8  # m or rad of the tool: a curve that misses a pole by no more is led straight through it
HERE = 1e-8  # m or rad of the tool: nearer axes are at the beginning of the curve
SINGULAR = 1e-3  # smallest singular value of the Jacobian: less, and the axes lose digits of the pose
RANK = 1e-9  # of the largest: a singular value that is smaller counts as none
POLE = 1e-9  # below this the Jacobian does not determine how the axes continue
# places around a pole that determine it instead; of the curve
STENCIL, STENCIL_STEP = (-8, -7, -6, -5, -4, -3, -2, -1, 1, 2, 3, 4, 5, 6, 7, 8), 5e-3
ENOUGH = 8  # of them
BESIDE = 1e-5  # m or rad: allowed start distance of the axes from their place on a pole
EPSILON = 1e-5  # rad or m, step for the change of the Jacobian

Array = NDArray[np.float64]
State = tuple[tuple[float, float, float], ...]  # per column: value, slope, bend


class _Knot(NamedTuple):
    s: float
    q: Joints
    state: State
    tool: Rate
    least: float  # singular value of the Jacobian of the arm


def joint_path_of(
    curve: Curve,
    kinematics: Kinematics,
    near: Joints,
    *,
    frame: Pose = IDENTITY,
    tool: Pose = IDENTITY,
    tolerance: float = TOLERANCE,
    course: Sequence[Row] = (),
) -> JointPath:
    """Axes along the curve.  near: where they are at its start (chooses the branch).  course: of the additional axes by s, the last
    ones of the kinematics.

    Raises what the inverse raises (Unreachable 530, OutOfLimits 531 ..) and SingularPose (540) where the joints would have to
    jump.
    """
    flange = Mounted(curve, frame, tool)
    knots = [_knot(curve, flange, kinematics, course, 0.0, near, at_start=True)]
    edges = _edges(curve)
    rows: list[list[tuple[float, ...]]] = []
    for edge in edges[1:]:
        _follow(curve, flange, kinematics, course, knots, rows, edge, tolerance)
    return joint_path([knot.s for knot in knots], rows)


def _edges(curve: Curve) -> list[float]:
    """0, where curves of a chain meet, length."""
    base, start, end = whole(curve)
    inner = [s - start for s in base.starts if start < s < end] if isinstance(base, Chain) else []
    return [0.0, *inner, curve.length]


def _follow(
    curve: Curve,
    flange: Mounted,
    kinematics: Kinematics,
    course: Sequence[Row],
    knots: list[_Knot],
    rows: list[list[tuple[float, ...]]],
    edge: float,
    tolerance: float,
) -> None:
    """Intervals up to `edge`, each half as long as the one that failed, and half as long again tried after each that fits."""
    step = edge - knots[-1].s
    made = _made(rows[-1], knots[-1].s - knots[-2].s) if rows else (0.0, 0.0)
    while knots[-1].s < edge:
        here = knots[-1]
        step = min(step, edge - here.s)
        target = edge if edge - here.s - step < 1e-9 * curve.length else here.s + step
        try:
            there = _target(curve, flange, kinematics, course, target, here, edge)
            columns = [hermite(there.s - here.s, a, b) for a, b in zip(here.state, there.state, strict=True)]
            tool = None
            if _fits(flange, kinematics, here, there, columns, tolerance):
                tool = tool_rows(
                    lambda s: rate_of(curve.derivatives(s)), here.s, there.s, (here.tool, there.tool), made, step <= FINEST * curve.length
                )
        except KinematicsError as error:  # beyond here, but how far?
            if step <= BORDER * curve.length:
                error.at, error.joints = target, here.q
                raise
            tool = None
        if tool is not None:
            rows.append([*columns, *tool])
            knots.append(there)
            made = _made(rows[-1], there.s - here.s)
            step *= 1.5
        elif step > SHORTEST * curve.length:
            step *= 0.5
        else:
            jump = SingularPose(f"the axes jump at {here.s:.6g} of {curve.length:.6g} on the path", at=target)
            jump.joints = here.q
            raise jump


def _target(curve: Curve, flange: Mounted, kinematics: Kinematics, course: Sequence[Row], target: float, here: _Knot, edge: float) -> _Knot:
    """The next knot: not on a pole, unless the curve ends there."""
    there = _knot(curve, flange, kinematics, course, target, here.q)
    if target == edge or there.least > POLE:
        return there
    return _knot(curve, flange, kinematics, course, here.s + 0.83 * (target - here.s), here.q)


def _fits(flange: Mounted, kinematics: Kinematics, here: _Knot, there: _Knot, columns: list[tuple[float, ...]], tolerance: float) -> bool:
    """Whether the pieces follow the inverse at the probes, or at a pole the curve itself."""
    if max(abs(a - b) for a, b in zip(here.q, there.q, strict=True)) > LARGEST:
        return False
    h = there.s - here.s
    at_pole = min(here.least, there.least) < SINGULAR or kinematics.configuration(here.q) != kinematics.configuration(there.q)
    inverse = along_path(kinematics)
    for probe in PROBES:
        u = probe * h
        guess = tuple(_value(row, u) for row in columns)
        pose = flange.at(here.s + u)
        if at_pole and _apart(kinematics.forward(guess), pose) <= AT_POLE:
            continue
        exact = inverse(pose, guess)
        if max(abs(a - b) for a, b in zip(guess, exact, strict=True)) > tolerance:
            return False
    return True


def _apart(one: Pose, two: Pose) -> float:
    """m or rad."""
    return max(math.dist(one.position, two.position), angle_between(one.rotation, two.rotation))


def _made(columns: list[tuple[float, ...]], u: float) -> tuple[float, float]:
    """Way and turning."""
    return _value(columns[-2], u), _value(columns[-1], u)


def _value(row: tuple[float, ...], u: float) -> float:
    value = 0.0
    for coefficient in reversed(row):
        value = value * u + coefficient
    return value


def _knot(
    curve: Curve, flange: Mounted, kinematics: Kinematics, course: Sequence[Row], s: float, near: Joints, *, at_start: bool = False
) -> _Knot:
    """stands: the axes are at `near` already if that puts the tool there."""
    arm, extra = kinematics.axes - len(course), states(tuple(course), s)
    near, pose = (*near[:arm], *(value for value, _, _ in extra)), flange.at(s)
    q = (
        near
        if at_start and _apart(kinematics.forward(near), pose) <= HERE
        else (kinematics.inverse if at_start else along_path(kinematics))(pose, near)
    )
    by_s = flange.derivatives(s)
    first: Array = np.array([*by_s.p1, *by_s.w])
    second: Array = np.array([*by_s.p2, *by_s.w1])
    jacobian = kinematics.jacobian(q)
    solved, least = _solver(jacobian[:, :arm])
    e1: Array = np.array([slope for _, slope, _ in extra])
    e2: Array = np.array([bend for _, _, bend in extra])
    q1 = np.concatenate([solved(first - jacobian[:, arm:] @ e1), e1])
    largest = float(np.max(np.abs(q1)))
    if largest > 0.0:
        e = EPSILON / largest
        ahead, behind = (kinematics.jacobian([a + k * e * float(b) for a, b in zip(q, q1, strict=True)]) for k in (1, -1))
        second = second - (ahead - behind) @ q1 / (2 * e)
    q2 = np.concatenate([solved(second - jacobian[:, arm:] @ e2), e2])
    state = tuple((a, float(b), float(c)) for a, b, c in zip(q, q1, q2, strict=True))
    tool = rate_of(curve.derivatives(s))
    if least < POLE and (found := _at_pole(curve.length, flange, kinematics, course, s, q if at_start else near)) is not None:
        if not at_start:
            q, state = tuple(value for value, _, _ in found), found
        elif max(abs(a - b) for a, (b, _, _) in zip(q, found, strict=True)) < BESIDE:
            state = tuple((a, slope, bend) for a, (_, slope, bend) in zip(q, found, strict=True))
    return _Knot(s, tuple(q), state, tool, least)


def _at_pole(length: float, flange: Mounted, kinematics: Kinematics, course: Sequence[Row], s: float, near: Joints) -> State | None:
    """Return the axes on a pole, from a polynomial through those of the curve near it; None where they cannot be there."""
    arm, step = kinematics.axes - len(course), STENCIL_STEP * length
    places = sorted(sorted((k for k in STENCIL if 0.0 <= s + k * step <= length), key=abs)[:ENOUGH])
    rows: list[Joints] = []
    inverse = along_path(kinematics)
    try:
        for k in places:
            at = s + k * step
            near = inverse(flange.at(at), (*near[:arm], *(value for value, _, _ in states(tuple(course), at))))
            rows.append(near)
    except KinematicsError:
        return None
    made = np.linalg.solve(np.vander(places, increasing=True).astype(np.float64), np.array(rows))
    return tuple((float(a), float(b) / step, 2.0 * float(c) / step**2) for a, b, c in made[:3].T)


def _solver(jacobian: Array) -> tuple[Callable[[Array], Array], float]:
    """Return joint rates for a twist, and the smallest singular value; least squares where the robot has other than six axes or a singular
    pose.
    """
    left, sizes, right = np.linalg.svd(jacobian, full_matrices=False)
    counts = sizes > RANK * sizes[0]
    inverse = (right[counts].T / sizes[counts]) @ left[:, counts].T

    def solved(twist: Array) -> Array:
        if jacobian.shape[1] == 6:
            try:
                solution = np.asarray(np.linalg.solve(jacobian, twist), dtype=np.float64)
            except np.linalg.LinAlgError:
                solution = np.full(6, np.inf)
            if np.all(np.isfinite(solution)) and float(np.max(np.abs(solution))) < 1e6:
                return solution
        return np.asarray(inverse @ twist, dtype=np.float64)

    return solved, float(sizes[-1])
