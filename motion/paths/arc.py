"""Circles and helices with the orientation rules of the three controls.

CIRCULAR of the rho 3 (never passed), ZIRK_MIN_ORI and ZIRK_BAHN_ORI of the Reis (L302-338, weights L1928-1942), movec of VAL 3
(L5380, L5493-5527, errors 550..553).  Rotation at s: R = about the axis (moving orientation only) x start x exp(rho(s)).
"""

import math
from dataclasses import dataclass

from motion.geometry.frames import Pose, Rotation, Vector, product, rotate, transposed
from motion.geometry.orientation import is_half_turn, rotation_by, rotation_vector
from motion.paths.base import Derivatives, PathError, add, cross, dot, norm, scale, sub, unit
from motion.paths.polynomial import Row, values
from motion.paths.turning import rate, rate_change

NEAR_M = 1e-5  # closer points are the same point (Reis RS_POS_EPS 0.01 mm, L2019-2025)
FLAT = 1e-6  # sine of the angle at the via point below which three points lie on a straight line
Rows = tuple[Row, Row, Row]


@dataclass(frozen=True, slots=True)
class Arc:
    """Centre and the two unit vectors of the plane (towards the start, along the motion); m and rad."""

    centre: Vector
    towards: Vector
    along: Vector
    radius: float
    angle: float  # > 0; more than 2 pi: a helix of several turns
    rise: float  # m along the axis over the entire arc
    start: Rotation
    moving: bool  # orientation fixed to the contour
    rho: Rows  # residual rotation, by s
    length: float

    @property
    def axis(self) -> Vector:
        """Unit vector of the axis, right-handed to the motion."""
        return cross(self.towards, self.along)

    def at(self, s: float) -> Pose:
        """The pose at s."""
        u = min(max(s, 0.0), self.length)
        angle = self.angle * u / self.length
        ring = add(scale(self.towards, self.radius * math.cos(angle)), scale(self.along, self.radius * math.sin(angle)))
        place = add(add(self.centre, ring), scale(self.axis, self.rise * u / self.length))
        return Pose(place, product(self._carried(angle), rotation_by(self._rho(u, 0))))

    def derivatives(self, s: float) -> Derivatives:
        """At s, in the outside frame."""
        u, k = min(max(s, 0.0), self.length), self.angle / self.length
        angle = k * u
        out = add(scale(self.towards, math.cos(angle)), scale(self.along, math.sin(angle)))
        onward = sub(scale(self.along, math.cos(angle)), scale(self.towards, math.sin(angle)))
        p1 = add(scale(onward, k * self.radius), scale(self.axis, self.rise / self.length))
        frame = self._carried(angle)
        rho, rho1, rho2 = (self._rho(u, order) for order in range(3))
        own, change = rotate(frame, rate(rho, rho1)), rotate(frame, rate_change(rho, rho1, rho2))
        if self.moving:
            turn = scale(self.axis, k)
            own, change = add(own, turn), add(change, cross(turn, own))
        return Derivatives(p1, scale(out, -k * k * self.radius), scale(onward, -(k**3) * self.radius), own, change)

    def _carried(self, angle: float) -> Rotation:
        return product(rotation_by(scale(self.axis, angle)), self.start) if self.moving else self.start

    def _rho(self, u: float, order: int) -> Vector:
        a, b, c = (values(row, u)[order] for row in self.rho)
        return a, b, c


def arc(start: Pose, via: Pose, end: Pose, *, moving: bool = False, via_weight: float = 1.0, halves: bool = False) -> Arc:
    """From start through via to end.

    moving: orientation fixed to the contour (ZIRK_BAHN_ORI); via_weight: how far the orientation of via counts (_IORI_CIRCHP,
    1 as for VAL 3, 0: only start and end); halves: VAL 3's rule that neither half may exceed 180 deg.  PathError 550..553.
    """
    _check_distances(start, via, end)
    _check_turns(start, via, end)
    centre, towards, along, radius = _circle(start.position, via.position, end.position)
    to_via, to_end = (_angle(centre, towards, along, pose.position) for pose in (via, end))
    if halves:
        _check_halves(to_via, to_end - to_via)
    rho = _residual(start, via, end, (cross(towards, along), to_via, to_end, radius * to_end), moving, via_weight)
    return Arc(centre, towards, along, radius, to_end, 0.0, start.rotation, moving, rho, radius * to_end)


def full_circle(start: Pose, second: Pose, third: Pose, *, moving: bool = False) -> Arc:
    """Return the full circle through three points; it ends in its initial orientation (moving: after one full turn)."""
    return around(start, second, third, 2 * math.pi, moving=moving)


def around(start: Pose, second: Pose, third: Pose, angle: float, rise: float = 0.0, *, moving: bool = False) -> Arc:
    """On the circle through three points, from the first one towards the second and on: angle in rad, > 0, more than 2 pi makes several
    turns; rise in m along the axis (right-handed to the motion) over the full angle.  The orientation is that of the start, fixed or
    moving with the contour."""
    _check_distances(start, second, third)
    if not 0.0 < angle < math.inf:
        raise PathError(f"an arc of {math.degrees(angle):.6g} deg has no length", 552)
    centre, towards, along, _ = _circle(start.position, second.position, third.position)
    if _angle(centre, towards, along, second.position) > _angle(centre, towards, along, third.position):
        along = scale(along, -1.0)
    return helix(start, centre, cross(towards, along), angle, rise, moving=moving)


def helix(start: Pose, centre: Vector, axis: Vector, angle: float, rise: float, *, moving: bool = False) -> Arc:
    """About a known axis: angle in rad (negative: left-handed), rise in m along the axis; PathError when start lies on the axis."""
    along_axis = unit(axis)
    foot = add(centre, scale(along_axis, dot(sub(start.position, centre), along_axis)))
    radius = norm(sub(start.position, foot))
    if radius < NEAR_M or not math.isfinite(angle) or angle == 0.0:
        raise PathError("the start lies on the axis of the circle, or the angle is 0 or not a number", 552)
    towards = scale(sub(start.position, foot), 1 / radius)
    turn = math.copysign(1.0, angle)
    along = scale(cross(along_axis, towards), turn)
    length = math.hypot(radius * angle, rise)
    none: Rows = ((0.0,), (0.0,), (0.0,))
    return Arc(foot, towards, along, radius, abs(angle), rise * turn, start.rotation, moving, none, length)


def _check_distances(start: Pose, via: Pose, end: Pose) -> None:
    for a, b, names in ((start, via, "start and via"), (via, end, "via and end"), (start, end, "start and end")):
        if not norm(sub(a.position, b.position)) >= NEAR_M:  # a NaN fails here too
            raise PathError(f"{names} point of the circle are too close", 552)


def _check_turns(start: Pose, via: Pose, end: Pose) -> None:
    for a, b, names in ((start, via, "start and via"), (via, end, "via and end")):
        if is_half_turn(a.rotation, b.rotation):
            raise PathError(f"the orientation changes by exactly 180 deg between {names} point: its direction is not defined", 553)


def _check_halves(first: float, second: float) -> None:
    for angle, number, name in ((first, 550, "start and via"), (second, 551, "via and end")):
        if angle > math.pi + 1e-9:
            raise PathError(f"{math.degrees(angle):.3f} deg between {name} point of the circle, 180 deg allowed", number)


def _circle(a: Vector, b: Vector, c: Vector) -> tuple[Vector, Vector, Vector, float]:
    """Centre, unit vector to a, unit vector of motion at a, radius."""
    ab, ac = sub(b, a), sub(c, a)
    normal = cross(ab, ac)
    if norm(normal) < FLAT * norm(ab) * norm(ac):
        raise PathError("the three points of the circle lie on a straight line", 552)
    square = dot(normal, normal)
    from_a = scale(add(scale(cross(ac, normal), -dot(ab, ab)), scale(cross(ab, normal), dot(ac, ac))), -1 / (2 * square))
    radius = norm(from_a)
    towards = scale(from_a, -1 / radius)
    return add(a, from_a), towards, cross(unit(normal), towards), radius


def _angle(centre: Vector, towards: Vector, along: Vector, point: Vector) -> float:
    """0 .. 2 pi from the start."""
    out = sub(point, centre)
    angle = math.atan2(dot(out, along), dot(out, towards))
    return angle if angle > 0 else angle + 2 * math.pi


def _residual(start: Pose, via: Pose, end: Pose, ring: tuple[Vector, float, float, float], moving: bool, weight: float) -> Rows:
    """rho(s): 0 at the start, as via (weighted) and end demand; a parabola, so the rate of turning has no step at via."""
    axis, to_via, to_end, length = ring
    at_via, at_end = (
        rotation_vector(product(transposed(product(rotation_by(scale(axis, angle if moving else 0.0)), start.rotation)), pose.rotation))
        for pose, angle in ((via, to_via), (end, to_end))
    )
    part = to_via / to_end
    at_end = _continued(at_end, scale(at_via, 1 / part)) if weight > 0 else at_end
    at_via = add(scale(at_end, part * (1 - weight)), scale(at_via, weight))
    rows = []
    for v, e in zip(at_via, at_end, strict=True):
        bend = (v - e * part) / (part * part - part)
        rows.append((0.0, (e - bend) / length, bend / length**2))
    return rows[0], rows[1], rows[2]


def _continued(vector: Vector, wanted: Vector) -> Vector:
    """Return the rotation vector of the same rotation that is nearest to `wanted`, so that rotations beyond half a turn continue."""
    angle = norm(vector)
    if angle < 1e-9:
        return vector
    return min((scale(vector, (angle + 2 * math.pi * k) / angle) for k in (-1, 0, 1)), key=lambda v: norm(sub(v, wanted)))
