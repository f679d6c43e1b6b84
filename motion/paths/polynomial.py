"""The curve most others are made of: position and rotation vector as polynomials of degree <= 5 in s."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from motion.geometry.frames import Pose, Vector, product, rotate
from motion.geometry.orientation import rotation_by
from motion.paths.base import Curve, Derivatives, PathError, add, norm, sub
from motion.paths.turning import rate, rate_change

Row = tuple[float, ...]  # coefficients, lowest power first
JOIN_M, JOIN_RAD = 1e-9, 1e-9  # largest step where curves of a chain meet
JOIN_SLOPE = 1e-7  # relative
STILL: Vector = (0.0, 0.0, 0.0)  # no turning


def values(row: Row, u: float) -> tuple[float, float, float, float]:
    """Value and first three derivatives at u."""
    f = f1 = f2 = f3 = 0.0
    for coefficient in reversed(row):
        f3 = f3 * u + f2
        f2 = f2 * u + f1
        f1 = f1 * u + f
        f = f * u + coefficient
    return f, f1, 2 * f2, 6 * f3


def slopes(row: Row, u: float) -> tuple[float, float]:
    """The first two derivatives at u, as of values() to the last bit."""
    if len(row) == 6:  # as the loop, written out: each corner asks for some twenty
        _, b, c, d, e, f1 = row
        f = f1 * u + e
        f2, f1, f = f1, f1 * u + f, f * u + d
        f2, f1, f = f2 * u + f1, f1 * u + f, f * u + c
        f2, f1, f = f2 * u + f1, f1 * u + f, f * u + b
        return f1 * u + f, 2 * (f2 * u + f1)
    f = f1 = f2 = 0.0
    for coefficient in reversed(row):
        f2 = f2 * u + f1
        f1 = f1 * u + f
        f = f * u + coefficient
    return f1, 2 * f2


def value(row: Row, u: float) -> float:
    """At u."""
    found = 0.0
    for coefficient in reversed(row):
        found = found * u + coefficient
    return found


@dataclass(frozen=True, slots=True)
class Polynomial:
    """pose(s) = origin shifted by the first three rows (m, outside frame) and turned by exp of the last three (rad, its own frame)."""

    origin: Pose
    rows: tuple[Row, Row, Row, Row, Row, Row]
    length: float

    def at(self, s: float) -> Pose:
        """The pose at s."""
        u = min(max(s, 0.0), self.length)
        rows, rotation = self.rows, self.origin.rotation
        place = add(self.origin.position, (value(rows[0], u), value(rows[1], u), value(rows[2], u)))
        if not any(map(any, rows[3:])):
            return Pose(place, rotation)
        a, b, c = value(rows[3], u), value(rows[4], u), value(rows[5], u)
        return Pose(place, product(rotation, rotation_by((a, b, c))) if a or b or c else rotation)

    def derivatives(self, s: float) -> Derivatives:
        """At s, in the outside frame."""
        u = min(max(s, 0.0), self.length)
        turns = any(map(any, self.rows[3:]))
        table = [values(row, u) for row in (self.rows if turns else self.rows[:3])]
        p1, p2, p3 = (_three(table, 0, k) for k in (1, 2, 3))
        if not turns:
            return Derivatives(p1, p2, p3, STILL, STILL)
        rho, rho1, rho2 = (_three(table, 3, k) for k in (0, 1, 2))
        rotation = self.origin.rotation
        return Derivatives(p1, p2, p3, rotate(rotation, rate(rho, rho1)), rotate(rotation, rate_change(rho, rho1, rho2)))


def _three(table: list[tuple[float, float, float, float]], at: int, order: int) -> Vector:
    return table[at][order], table[at + 1][order], table[at + 2][order]


@dataclass(frozen=True, slots=True)
class Part:
    """A stretch of another curve."""

    whole: Curve
    start: float
    length: float

    def at(self, s: float) -> Pose:
        """The pose at s of this part."""
        return self.whole.at(self.start + min(max(s, 0.0), self.length))

    def derivatives(self, s: float) -> Derivatives:
        """At s of this part."""
        return self.whole.derivatives(self.start + min(max(s, 0.0), self.length))


def part(curve: Curve, start: float, end: float) -> Part:
    """The stretch start .. end; PathError when it is empty or not on the curve."""
    slack = 1e-9 * curve.length
    if not -slack <= start < end <= curve.length + slack:
        raise PathError(f"{start} .. {end} is not a section of a curve of length {curve.length}")
    return Part(curve, max(start, 0.0), min(end, curve.length) - max(start, 0.0))


def whole(base: Curve) -> tuple[Curve, float, float]:
    """The curve itself and the stretch of it that `base` is."""
    if isinstance(base, Part):
        curve, start, _ = whole(base.whole)
        return curve, start + base.start, start + base.start + base.length
    return base, 0.0, base.length


@dataclass(frozen=True, slots=True)
class Chain:
    """Consecutive curves, joined without a corner."""

    curves: tuple[Curve, ...]
    starts: tuple[float, ...]
    length: float

    def at(self, s: float) -> Pose:
        """The pose at s."""
        index = self.index(s)
        return self.curves[index].at(s - self.starts[index])

    def derivatives(self, s: float) -> Derivatives:
        """At s."""
        index = self.index(s)
        return self.curves[index].derivatives(s - self.starts[index])

    def index(self, s: float) -> int:
        """Number of the curve s lies on."""
        low, high = 0, len(self.starts) - 1
        while low < high:
            middle = (low + high + 1) // 2
            low, high = (middle, high) if self.starts[middle] <= s else (low, middle - 1)
        return low


def chain(curves: Sequence[Curve]) -> Chain:
    """Curves that join with position, orientation, tangent and rate; PathError where they do not."""
    if not curves:
        raise PathError("a chain of no curves")
    starts = [0.0]
    for number, (left, right) in enumerate(pairwise(curves)):
        check_join(left, right, number)
        starts.append(starts[-1] + left.length)
    return Chain(tuple(curves), tuple(starts), starts[-1] + curves[-1].length)


def check_join(left: Curve, right: Curve, number: int = 0) -> None:
    """Raise PathError unless `right` continues `left` in place and direction."""
    end, begin = left.at(left.length), right.at(0.0)
    if (
        norm(sub(end.position, begin.position)) > JOIN_M
        or max(abs(a - b) for a, b in zip(end.rotation, begin.rotation, strict=True)) > JOIN_RAD
    ):
        raise PathError(f"curve {number + 1} does not begin where curve {number} ends")
    out, into = left.derivatives(left.length), right.derivatives(0.0)
    if norm(sub(out.p1, into.p1)) > JOIN_SLOPE or norm(sub(out.w, into.w)) > JOIN_SLOPE * (1 + norm(out.w)):
        raise PathError(f"there is a corner between curve {number} and curve {number + 1}")
