"""Portals: the linear axes are the coordinates, so lines and corners between lines along which the tool does not turn need no inverse at
all, and the axes of the wrist are at rest."""

import math
from operator import mul

from motion.geometry.frames import Pose
from motion.kinematics.base import Joints, Kinematics
from motion.kinematics.portal import Portal
from motion.paths.base import Curve
from motion.paths.corner import Corner
from motion.paths.joints import JointPath, joint_path
from motion.paths.polynomial import Polynomial, Row, slopes, whole
from motion.paths.tool_path import FINEST, Rate, divided
from motion.planner.additional_axes import about

STILL = 1e-9  # rad: smaller motion of a wrist axis counts as rest


def exact_path(curve: Curve, kinematics: Kinematics, near: Joints, tool: Pose) -> JointPath | None:
    """The axes along a line or a symmetric corner of lines without turning; None where the general way has to be gone."""
    if not isinstance(kinematics, Portal):
        return None
    base, start, end = whole(curve)
    if isinstance(base, Corner) and base.leave == base.reach:
        rows, scale = base.quintic.rows, 0.5 / base.leave  # of the quintic's own parameter by s
    elif isinstance(base, Polynomial) and all(len(row) <= 2 for row in base.rows):
        rows, scale = base.rows, 1.0
    else:
        return None
    if any(any(row[1:]) for row in rows[3:]) or (scale != 1.0 and (start, end) != (0.0, base.length)):
        return None
    flange = tool.inverse()
    q = kinematics.inverse(curve.at(0.0) @ flange, near)
    last = kinematics.inverse(curve.at(curve.length) @ flange, q)  # within reach and limits at both ends, so all along
    columns: list[Row] = []
    powers = [scale**k for k in range(6)]
    for letter, value, there in zip(kinematics.letters, q, last, strict=True):
        if letter in "xyz":
            row = rows["xyz".index(letter)]
            columns.append((value, *map(mul, row[1:], powers[1:])) if any(row[1:]) else (value,))
        elif abs(there - value) <= STILL:
            columns.append((value,))
        else:
            return None
    if scale == 1.0:
        slope = math.sqrt(sum(row[1] ** 2 for row in columns if len(row) > 1))
        return joint_path([0.0, curve.length], [[*columns, (0.0, slope), (0.0,)]])
    return _divided(columns, curve.length)


def _divided(columns: list[Row], length: float) -> JointPath:
    """The same polynomials in as many parts as the way of the tool needs to be true."""

    moving = [row for row in columns if len(row) > 1]  # what adds no way to the tool's is left out

    def rate(s: float) -> Rate:
        square = bend = 0.0
        for row in moving:
            first, second = slopes(row, s)
            square += first * first
            bend += first * second
        slope = math.sqrt(square)
        return Rate(slope, 0.0, bend / slope if slope > 0.0 else 0.0)

    knots, rows = [0.0], []
    for there, way, turn in divided(rate, 0.0, length, (0.0, 0.0), FINEST * length):
        here = [tuple(about(row, knots[-1])) if len(row) > 1 else row for row in columns] if knots[-1] else columns
        rows.append([*here, way, turn])
        knots.append(there)
    return joint_path(knots, rows)
