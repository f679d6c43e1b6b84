"""Portals without rotary axes: the axes are the coordinates, so lines and corners between lines need no inverse at all."""

import math

from motion.frames import Pose
from motion.kinematics.base import Joints, Kinematics
from motion.kinematics.portal import Portal
from motion.paths.base import Curve
from motion.paths.corner import Corner, hermite
from motion.paths.joints import JointPath, joint_path
from motion.paths.polynomial import Polynomial, Row, whole

_GAUSS = ((0.046910077030668, 0.118463442528095), (0.230765344947158, 0.239314335249683), (0.5, 0.284444444444444),
          (0.769234655052842, 0.239314335249683), (0.953089922969332, 0.118463442528095))  # fmt: skip


def exact_path(curve: Curve, kinematics: Kinematics, near: Joints, tool: Pose) -> JointPath | None:
    """The axes along a line or a symmetric corner of lines without turning; None where the general way has to be gone."""
    if not isinstance(kinematics, Portal) or set(kinematics.letters) - set("xyz"):
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
    q = kinematics.inverse(curve.at(0.0) @ tool.inverse(), near)
    kinematics.inverse(curve.at(curve.length) @ tool.inverse(), q)  # within reach and limits at both ends, so all along
    columns: list[Row] = []
    for letter, value in zip(kinematics.letters, q, strict=True):
        row = rows["xyz".index(letter)]
        columns.append((value, *(c * scale**k for k, c in enumerate(row[1:], 1))))
    slope = math.sqrt(sum(row[1] ** 2 for row in columns if len(row) > 1))
    if scale == 1.0:
        columns += [(0.0, slope), (0.0,)]
    else:
        columns += [hermite(curve.length, (0.0, 1.0, 0.0), (_way(columns, curve.length), 1.0, 0.0)), (0.0,)]
    return joint_path([0.0, curve.length], [columns])


def _way(columns: list[Row], length: float) -> float:
    total = 0.0
    for share, weight in _GAUSS:
        u, square = share * length, 0.0
        for row in columns:
            slope = 0.0
            for k in range(len(row) - 1, 0, -1):
                slope = slope * u + k * row[k]
            square += slope * slope
        total += weight * math.sqrt(square)
    return total * length
