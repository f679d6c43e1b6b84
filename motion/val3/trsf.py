"""Type trsf: six numbers, mm and degrees, and what the language does with them.  Source: VAL 3 reference 9.3, L4688-4801.

The numbers mean Trans(x, y, z) Rx(rx) Ry(ry) Rz(rz) (`motion.geometry.conventions`, doubt D12).  Errors: 70 where a number is out of its
range, 550..553 where an arc is none, as movec has them (the instruction itself prints no number: AX-357).
"""

import math
from dataclasses import replace
from typing import NamedTuple

from motion.geometry.conventions import VAL3
from motion.geometry.frames import Pose, compose, product
from motion.geometry.orientation import interpolated, is_half_turn, rotation_by
from motion.paths.arc import arc
from motion.paths.base import PathError, cross, dot, norm, scale
from motion.val3.errors import RuntimeFault


class Trsf(NamedTuple):
    """x, y, z mm; rx, ry, rz deg."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    rx: float = 0.0
    ry: float = 0.0
    rz: float = 0.0

    @property
    def pose(self) -> Pose:
        """m and a matrix."""
        return VAL3.pose(self)


def trsf_of(pose: Pose) -> Trsf:
    """The numbers of a pose; angles within +-180 degrees, ry within +-90."""
    return Trsf(*VAL3.values(pose))


def times(first: Trsf, second: Trsf) -> Trsf:
    """tr1 * tr2."""
    return trsf_of(compose(first.pose, second.pose))


def inverted(trsf: Trsf) -> Trsf:
    """!tr."""
    return trsf_of(trsf.pose.inverse())


def distance(first: Trsf, second: Trsf) -> float:
    """mm; both in one frame, or the number means nothing."""
    return math.dist(first[:3], second[:3])


def interpolate_l(start: Trsf, end: Trsf, position: float) -> Trsf:
    """interpolateL: the line from start (0) to end (1); beyond them it continues, inside ]-1, 2[ (L4769), else error 70."""
    if not -1.0 < position < 2.0:
        raise RuntimeFault(70, f"interpolateL: nPosition {position:g} is not inside ]-1, 2[")
    if is_half_turn(start.pose.rotation, end.pose.rotation):
        raise RuntimeFault(553, "interpolateL: the direction of the rotation is not defined")
    return trsf_of(interpolated(start.pose, end.pose, position))


def interpolate_c(start: Trsf, intermediate: Trsf, end: Trsf, position: float) -> Trsf:
    """interpolateC: the arc of movec from start (0) to end (1); 0.5 = half of the arc; beyond them the circle continues."""
    if not math.isfinite(position):
        raise RuntimeFault(70, f"interpolateC: nPosition {position:g}")
    try:
        whole = arc(start.pose, intermediate.pose, end.pose, halves=True)
    except PathError as error:
        raise RuntimeFault(error.number or 552, f"interpolateC: {error}") from error
    if 0.0 <= position <= 1.0:
        return trsf_of(whole.at(position * whole.length))
    if position > 1.0:
        part = replace(whole, angle=whole.angle * position, length=whole.length * position)
    else:  # backwards: the same circle, gone the other way round, its residual rotation by -s
        backwards = tuple(tuple(c * (-1.0) ** n for n, c in enumerate(row)) for row in whole.rho)
        rho = (backwards[0], backwards[1], backwards[2])
        part = replace(whole, along=scale(whole.along, -1.0), rho=rho, angle=-whole.angle * position, length=-whole.length * position)
    return trsf_of(part.at(part.length))


def align(trsf: Trsf, reference: Trsf) -> Trsf:
    """Turned by the least rotation so that its z lies along the nearest axis, + or -, of the reference (doubt D13); x, y, z stay."""
    r, own = reference.pose.rotation, trsf.pose
    z = own.rotation[2::3]
    axes = [scale(r[column::3], sign) for column in range(3) for sign in (1.0, -1.0)]
    best = max(axes, key=lambda axis: dot(axis, z))
    turn = cross(z, best)
    angle = math.atan2(norm(turn), dot(z, best))
    if norm(turn) == 0.0:
        return trsf_of(own)
    return trsf_of(Pose(own.position, product(rotation_by(scale(turn, angle / norm(turn))), own.rotation)))
