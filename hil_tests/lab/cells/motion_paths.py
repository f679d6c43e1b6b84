"""Canonical motions for tests and figures: the U cycle of a portal and of a six-axis arm, the 200-point contour, the line past the
wrist singularity; and what set values at 1 ms say about limits."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motion.geometry.frames import NO_ROTATION, Pose, Rotation
from motion.geometry.limits import AxisLimits, limits_from
from motion.kinematics.arm6 import Arm6, ArmGeometry
from motion.kinematics.base import Joints, Kinematics
from motion.paths.base import Curve
from motion.paths.corner import corner, hermite
from motion.paths.joints import JointPath, joint_path
from motion.paths.line import line
from motion.paths.polynomial import Chain
from motion.planner.joint_path import joint_path_of
from motion.timing.choice import Rounded
from motion.timing.limits import LawLimits, law_limits

Array = NDArray[np.float64]
MS = 1e-3
POINTING_DOWN: Rotation = (1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)
NOMINAL = ((-180, 180, 435), (-127.5, 127.5, 410), (-142.5, 142.5, 540), (-270, 270, 995), (-122.5, 132.5, 1065), (-270, 270, 1445))


def arm() -> tuple[Arm6, list[AxisLimits]]:
    """TX60-like, acceleration 10 x and jerk 500 x speed (motion.md C.5)."""
    limits = [
        limits_from(f"J{n}", "deg", lower=low, upper=high, speed=v, accel=10.0 * v, jerk=500.0 * v)
        for n, (low, high, v) in enumerate(NOMINAL, 1)
    ]
    return Arm6(ArmGeometry(height=0.375, arm=0.29, forearm=0.31, flange=0.07, side=0.02), limits), limits


def portal_limits(speed: float = 2.0, accel: float = 20.0, jerk: float = 1000.0) -> list[AxisLimits]:
    """x, y, z in m."""
    return [AxisLimits(name, -10.0, 10.0, speed, accel, jerk, "m") for name in "xyz"]


def point(x: float, y: float, z: float, rotation: Rotation = NO_ROTATION) -> Pose:
    return Pose((x, y, z), rotation)


def portal_path(curve: Curve, pieces: int = 1) -> JointPath:
    """x, y, z of a curve as axes; a quintic for each piece (exact for lines and for the quintic corners with leave = reach)."""
    knots = np.linspace(0.0, curve.length, pieces + 1).tolist()
    rows: list[list[tuple[float, ...]]] = []
    for a, b in pairwise(knots):
        left, right = curve.derivatives(a), curve.derivatives(b)
        p, q = curve.at(a).position, curve.at(b).position
        rows.append(
            [hermite(b - a, (p[k], left.p1[k], left.p2[k]), (q[k], right.p1[k], right.p2[k])) for k in range(3)] + [(a, 1.0), (0.0,)]
        )
    return joint_path(knots, rows)


def chain_path(chain: Chain) -> JointPath:
    """x, y, z of a spline, interval by interval, exact."""
    rows = []
    for start, curve in zip(chain.starts, chain.curves, strict=True):
        columns = portal_path(curve).coefficients[0].T.tolist()
        columns[3] = [start, 1.0]
        rows.append(columns)
    return joint_path([*chain.starts, chain.length], rows)


def u_points(rotation: Rotation = NO_ROTATION, at: tuple[float, float, float] = (0.0, 0.0, 0.0), along: int = 0) -> list[Pose]:
    """25 mm up, 300 mm across, 25 mm down."""
    x, y, z = at
    if along == 0:
        places = [(x, y, z), (x, y, z + 0.025), (x + 0.3, y, z + 0.025), (x + 0.3, y, z)]
    else:
        places = [(x, y - 0.15, z), (x, y - 0.15, z + 0.025), (x, y + 0.15, z + 0.025), (x, y + 0.15, z)]
    return [Pose(place, rotation) for place in places]


def u_portal(radius: float) -> tuple[list[JointPath], list[Rounded | None]]:
    """Legs and corners of the U of a portal."""
    lines = [line(a, b) for a, b in pairwise(u_points())]
    corners: list[Rounded | None] = [Rounded(radius, radius, portal_path(corner(a, b, radius, radius))) for a, b in pairwise(lines)]
    return [portal_path(curve) for curve in lines], corners


def u_arm(radius: float, place: tuple[float, float, float] = (0.35, 0.0, 0.3)) -> tuple[list[JointPath], list[Rounded | None], LawLimits]:
    """Legs and corners of the U of the six-axis arm, all LIN; and its limits."""
    robot, limits = arm()
    lines = [line(a, b) for a, b in pairwise(u_points(POINTING_DOWN, place, along=1))]
    near: Joints = robot.inverse(lines[0].at(0.0), (math.atan2(-0.15, place[0]), 0.5, 1.2, 0.0, 1.0, 0.0))
    legs = paths_of(lines, robot, near)
    corners: list[Rounded | None] = []
    for k, (a, b) in enumerate(pairwise(lines)):
        round_ = corner(a, b, radius, radius)
        corners.append(Rounded(radius, radius, joint_path_of(round_, robot, legs[k].q(legs[k].length - radius))))
    return legs, corners, law_limits(limits)


def paths_of(curves: Sequence[Curve], kinematics: Kinematics, near: Joints) -> list[JointPath]:
    paths = []
    for curve in curves:
        paths.append(joint_path_of(curve, kinematics, near))
        near = paths[-1].q(paths[-1].length)
    return paths


def contour_points(count: int = 200) -> list[Pose]:
    """r = 100 + 20 sin 5t mm, closed."""
    angles = np.linspace(0.0, 2 * math.pi, count + 1)
    return [point(contour_radius(float(t)) * math.cos(t), contour_radius(float(t)) * math.sin(t), 0.0) for t in angles]


def contour_radius(t: float) -> float:
    return 0.1 + 0.02 * math.sin(5 * t)


def past_singularity(degrees: float) -> tuple[Curve, Joints, Arm6, LawLimits]:
    """300 mm straight, |q5| = `degrees` in the middle; 500 mm/s, 5 m/s2, 200 m/s3 along the path."""
    robot, limits = arm()
    q = (0.3, 0.5, 1.1, 0.0, math.radians(degrees), 0.4)
    middle = robot.forward(q)
    u = np.array([-0.29, 0.95, 0.0])
    a, b = (np.array(middle.position) + k * 0.15 * u / np.linalg.norm(u) for k in (-1, 1))
    start, end = (Pose((float(p[0]), float(p[1]), float(p[2])), middle.rotation) for p in (a, b))
    return line(start, end), robot.inverse(start, q), robot, law_limits(limits, way=(0.5, 5.0, 200.0))


def worst_shares(q: Array, limits: Sequence[AxisLimits], period_s: float = MS) -> tuple[float, float, float]:
    """(n, axes) set values -> largest speed, acceleration, jerk as shares of the limits; at rest before and after."""
    padded = np.concatenate([np.repeat(q[:1], 3, axis=0), q, np.repeat(q[-1:], 3, axis=0)])
    bounds = [np.array([getattr(axis, name) for axis in limits]) for name in ("speed", "accel", "jerk")]
    v, a, j = (float(np.max(np.abs(np.diff(padded, k, axis=0)) / period_s**k / bounds[k - 1])) for k in (1, 2, 3))
    return v, a, j
