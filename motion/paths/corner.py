"""Rounded corners: a quintic that joins with equal tangent and curvature, with a bound in closed form (motion.md F).

Between straight lines the control points are P - l u1, P - 0.6 l u1, P - 0.2 l u1, P + 0.2 m u2, P + 0.6 m u2, P + m u2 with
leave l and reach m: all inside both lines' stretches, so the curve stays in their plane and, l = m = r, inside the sphere of
radius r (rho 3 R, L1792-1794; Reis BAHN_RADIUS, L1772-1778).  It misses the corner by at most 0.1875 |m u2 - l u1|, and by exactly
that when l = m.  The orientation goes the same way, as a rotation vector about that of the corner.  leave != reach: the parameter
runs through a smooth step, so that |p'| = 1 and p'' = 0 at both ends all the same.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from motion.geometry.frames import Pose, Vector, product, rotate, transposed
from motion.geometry.orientation import rotation_vector
from motion.paths.base import Curve, Derivatives, PathError, add, norm, scale, sub
from motion.paths.polynomial import Polynomial, Row, whole
from motion.paths.turning import vector_change, vector_rate

MISS = 0.1875  # share of |m u2 - l u1|
SHARPEST = 0.02  # |u1 + u2| below which a corner is a way back: nothing rounds it
JOIN_M = 1e-9
MOST_TURN = math.pi - 1e-9  # rad
TURN_LOOKS = 8
BINOMIAL = tuple(tuple(math.comb(k, i) for i in range(k + 1)) for k in range(6))
FIVE = BINOMIAL[5]
STILL: Row = (0.0,) * 6


@dataclass(frozen=True, slots=True)
class Corner:
    """A quintic in t = 0 .. 1 whose parameter s runs with t' = a at the start and b at the end."""

    quintic: Polynomial  # in t; length 1
    leave: float
    reach: float
    length: float
    bound: float  # m: the corner is missed by no more

    def at(self, s: float) -> Pose:
        """The pose at s."""
        return self.quintic.at(self._t(s)[0])

    def derivatives(self, s: float) -> Derivatives:
        """At s."""
        t, t1, t2, t3 = self._t(s)
        p1, p2, p3, w, w1 = self.quintic.derivatives(t)
        return Derivatives(
            scale(p1, t1),
            add(scale(p2, t1 * t1), scale(p1, t2)),
            add(add(scale(p3, t1**3), scale(p2, 3 * t1 * t2)), scale(p1, t3)),
            scale(w, t1),
            add(scale(w1, t1 * t1), scale(w, t2)),
        )

    def _t(self, s: float) -> tuple[float, float, float, float]:
        """t and its derivatives by s: t' = a + (b - a) x^3 (10 - 15 x + 6 x^2), x = s / length."""
        x, a, b, length = min(max(s / self.length, 0.0), 1.0), 0.5 / self.leave, 0.5 / self.reach, self.length
        step = b - a
        return (
            min(length * (a * x + step * x**4 * (2.5 - 3 * x + x * x)), 1.0),
            a + step * x**3 * (10 - 15 * x + 6 * x * x),
            step * 30 * x * x * (1 - x) ** 2 / length,
            step * 60 * x * (1 - x) * (1 - 2 * x) / length**2,
        )


def miss(u1: Sequence[float], u2: Sequence[float], leave: float, reach: float) -> float:
    """How far at most the corner between unit directions u1 and u2 is missed, in the unit of leave and reach."""
    return MISS * math.sqrt(sum((reach * b - leave * a) ** 2 for a, b in zip(u1, u2, strict=True)))


def radius_for(distance: float, u1: Sequence[float], u2: Sequence[float]) -> float:
    """leave = reach for which the corner is missed by exactly `distance` (BAHN_DISTANZ, L1780-1788); inf where there is no corner."""
    bend = math.sqrt(sum((b - a) ** 2 for a, b in zip(u1, u2, strict=True)))
    return distance / (MISS * bend) if bend > 0 else math.inf


def clipped(wanted: float, block: float, share: float) -> float:
    """Return the part of a block of length `block` that one of its corners may use: share 0.5 rho 3 and CODESYS, 0.4 Reis
    (RAPPR_FACT_MAX), 1/3 Beckhoff; more than half where the other end of the block has no corner.
    """
    if not (0.0 < share < 1.0 and wanted >= 0.0):
        raise PathError(f"share {share} is not above 0 and below 1, or the range {wanted} is negative")
    return min(wanted, share * block)


def directions(before: Curve, after: Curve) -> tuple[Vector, Vector]:
    """Unit tangents at the end of `before` and at the start of `after`."""
    return _tangents(before.derivatives(before.length), after.derivatives(0.0))


def _tangents(into: Derivatives, out: Derivatives) -> tuple[Vector, Vector]:
    one, two = norm(into.p1), norm(out.p1)
    if one == 0.0 or two == 0.0:
        raise PathError("a path without way of the tool cannot be rounded off", 621)
    return scale(into.p1, 1 / one), scale(out.p1, 1 / two)


def corner(before: Curve, after: Curve, leave: float, reach: float) -> Corner | Polynomial:
    """Rounds the end of `before` and the start of `after`; it begins at before.length - leave and ends at `reach` on after.

    PathError: the curves do not meet, ranges longer than the curves, a way back on the same line, or 554: the tool turns by 180 deg or more
    in it, and its start and end no longer define the direction of turning (VAL 3 L5475-5481, L6688).
    """
    if not (0.0 < leave <= before.length and 0.0 < reach <= after.length):
        raise PathError(f"leave {leave} and reach {reach} do not fit curves of length {before.length} and {after.length}")
    point = after.at(0.0)
    if norm(sub(before.at(before.length).position, point.position)) > JOIN_M:
        raise PathError("a corner between curves that do not meet")
    into, out = before.derivatives(before.length), after.derivatives(0.0)
    u1, u2 = _tangents(into, out)
    if norm(add(u1, u2)) < SHARPEST:
        raise PathError("the path reverses here: this corner cannot be rounded")
    straight = _straight(before) and _straight(after)
    if straight:
        turned = norm(add(scale(into.w, leave), scale(out.w, reach)))
    else:
        turned = norm(add(_turned(before, before.length - leave, before.length), _turned(after, 0.0, reach)))
    if turned >= MOST_TURN:
        what = f"Cartesian blend: the tool turns by {math.degrees(turned):.6g} deg between leave and reach, less than 180 deg is possible"
        raise PathError(f"{what}: shorter ranges, or a point between", 554)
    if straight:
        return _between_lines(into, out, point, leave, reach)
    return _between_curves(before, after, point, leave, reach)


def _turned(curve: Curve, start: float, end: float) -> Vector:
    """rad by which the tool turns between two places."""
    count = 1 if _straight(curve) else TURN_LOOKS
    turned = (0.0, 0.0, 0.0)
    for k in range(count):
        turned = add(turned, scale(curve.derivatives(start + (k + 0.5) / count * (end - start)).w, (end - start) / count))
    return turned


def _straight(curve: Curve) -> bool:
    base = whole(curve)[0]
    return isinstance(base, Polynomial) and all(len(row) <= 2 for row in base.rows)


def _between_lines(into: Derivatives, out: Derivatives, point: Pose, leave: float, reach: float) -> Corner:
    back = transposed(point.rotation)
    u1, u2 = (*into.p1, *rotate(back, into.w)), (*out.p1, *rotate(back, out.w))
    rows = [
        _bezier([-leave * a, -0.6 * leave * a, -0.2 * leave * a, 0.2 * reach * b, 0.6 * reach * b, reach * b]) if a or b else STILL
        for a, b in zip(u1, u2, strict=True)
    ]
    quintic = Polynomial(point, (rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]), 1.0)
    return Corner(quintic, leave, reach, 4 * leave * reach / (leave + reach), miss(into.p1, out.p1, leave, reach))


def _bezier(values: Sequence[float]) -> Row:
    """Control values of degree 5 -> coefficients: binomial numbers times the differences, written out since every corner needs six."""
    a, b, c, d, e, f = values
    return (
        a,
        5 * (b - a),
        10 * (a - 2 * b + c),
        10 * (-a + 3 * b - 3 * c + d),
        5 * (a - 4 * b + 6 * c - 4 * d + e),
        -a + 5 * b - 10 * c + 10 * d - 5 * e + f,
    )


def hermite(length: float, start: Sequence[float], end: Sequence[float]) -> Row:
    """Quintic over 0 .. length from (value, first, second derivative) at both ends."""
    (a, b, c), (d, e, f) = start, end
    h = length
    gap = d - a - b * h - 0.5 * c * h * h
    slope, bend = (e - b - c * h) * h, (f - c) * h * h
    return (
        a,
        b,
        0.5 * c,
        (10 * gap - 4 * slope + 0.5 * bend) / h**3,
        (-15 * gap + 7 * slope - bend) / h**4,
        (6 * gap - 3 * slope + 0.5 * bend) / h**5,
    )


def pose_state(curve: Curve, s: float, origin: Pose) -> list[tuple[float, float, float]]:
    """(value, first, second derivative) of position and rotation vector against `origin`: six rows."""
    pose, by_s, back = curve.at(s), curve.derivatives(s), transposed(origin.rotation)
    shift = sub(pose.position, origin.position)
    rho = rotation_vector(product(back, pose.rotation))
    rho1 = vector_rate(rho, rotate(back, by_s.w))
    rho2 = vector_change(rho, rho1, rotate(back, by_s.w1))
    return [*zip(shift, by_s.p1, by_s.p2, strict=True), *zip(rho, rho1, rho2, strict=True)]


def _between_curves(before: Curve, after: Curve, point: Pose, leave: float, reach: float) -> Polynomial:
    length = leave + reach
    first, last = pose_state(before, before.length - leave, point), pose_state(after, reach, point)
    rows = [hermite(length, a, b) for a, b in zip(first, last, strict=True)]
    return Polynomial(point, (rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]), length)


def deviation(curve: Curve, point: Vector, samples: int = 64) -> float:
    """How far the curve misses the point: the smallest distance over the samples, refined between them."""

    def distance(s: float) -> float:
        return norm(sub(curve.at(s).position, point))

    best = min(range(samples + 1), key=lambda k: distance(curve.length * k / samples))
    low, high = (curve.length * min(max(best + d, 0), samples) / samples for d in (-1, 1))
    for _ in range(60):
        a, b = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, b) if distance(a) <= distance(b) else (a, high)
    return distance(0.5 * (low + high))


def inside_sphere(curve: Corner, point: Vector) -> float:
    """Radius of the smallest sphere round the point that holds all control points, and so the curve."""
    rows = curve.quintic.rows
    return max(norm(sub(add(curve.quintic.origin.position, p), point)) for p in control_points(rows[:3]))


def control_points(rows: Sequence[Row], length: float = 1.0) -> list[Vector]:
    """Six of the curve with these three rows of coefficients over 0 .. length: their hull holds it."""
    columns = []
    for row in rows:
        full = [c * length**k for k, c in enumerate([*row, *[0.0] * (6 - len(row))])]
        columns.append([sum(n * full[i] / FIVE[i] for i, n in enumerate(choices)) for choices in BINOMIAL])
    return [(x, y, z) for x, y, z in zip(*columns, strict=True)]
