"""The transformations of TRAFO_6D as maps of points and orientations; mm.  Source: robotstar 6.3, 6.4 (L3326-3427, L3530-3806).

A mirrored orientation is brought back to a right-handed one by reversing the y direction of the tool: the tool's own x-z plane is its
plane of symmetry (L3525-3528).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from motion.geometry.conventions import angles_zyx, rotation_zyx

Xyz: TypeAlias = tuple[float, float, float]
Rows: TypeAlias = tuple[Xyz, Xyz, Xyz]
DISTANCE, ANGLE, WIDEST = 50.0, 30.0, 150.0  # mm, degrees (D-37)
IDENTITY: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ROUNDING = 1e-6
STRAIGHT = 0.001  # degrees: no plane goes through three points so near a line, whatever the digits of a taught position


class Unfit(ValueError):
    """Points do not make a frame, plane or line.  `number`: the last two digits of the error."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


@dataclass(frozen=True, slots=True)
class Map:
    """point -> point and rotation -> rotation.  `mirrors`: right-handed becomes left-handed."""

    point: Callable[[Xyz], Xyz]
    turn: Rows = IDENTITY
    mirrors: bool = False

    def pose(self, pose: Sequence[float], keep_orientation: bool) -> tuple[float, ...]:
        """X..C as they become."""
        at = self.point((pose[0], pose[1], pose[2]))
        if keep_orientation or (self.turn == IDENTITY and not self.mirrors):
            return (*at, *pose[3:6])
        a, b, c = (math.radians(angle) for angle in pose[3:6])
        rotation = times(self.turn, _rows(rotation_zyx(a, b, c)))
        if self.mirrors:
            rotation = _y_reversed(rotation)
        flat = rotation[0] + rotation[1] + rotation[2]
        return (*at, *(math.degrees(angle) for angle in angles_zyx(flat)))


# ---- vectors ---------------------------------------------------------------------------------------------------------------
def minus(a: Xyz, b: Xyz) -> Xyz:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def along(a: Xyz, way: Xyz, part: float) -> Xyz:
    """a + part * way."""
    return a[0] + part * way[0], a[1] + part * way[1], a[2] + part * way[2]


def dot(a: Xyz, b: Xyz) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Xyz, b: Xyz) -> Xyz:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def unit(a: Xyz) -> Xyz:
    length = math.hypot(*a)
    return a[0] / length, a[1] / length, a[2] / length


def times(a: Rows, b: Rows) -> Rows:
    """Product of two matrices."""
    columns = _transposed(b)
    one, two, three = (tuple(dot(row, column) for column in columns) for row in a)
    return (one[0], one[1], one[2]), (two[0], two[1], two[2]), (three[0], three[1], three[2])


def applied(rows: Rows, at: Xyz) -> Xyz:
    return dot(rows[0], at), dot(rows[1], at), dot(rows[2], at)


def _transposed(rows: Rows) -> Rows:
    (a, b, c), (d, e, f), (g, h, i) = rows
    return (a, d, g), (b, e, h), (c, f, i)


def _rows(flat: Sequence[float]) -> Rows:
    a, b, c, d, e, f, g, h, i = flat
    return (a, b, c), (d, e, f), (g, h, i)


def _y_reversed(rows: Rows) -> Rows:
    (a, b, c), (d, e, f), (g, h, i) = rows
    return (a, -b, c), (d, -e, f), (g, -h, i)


# ---- what the points make --------------------------------------------------------------------------------------------------
def check_triangle(one: Xyz, two: Xyz, three: Xyz) -> None:
    """Unfit 10: nearer than 50 mm; 4: on a straight line; 11: an angle at the first point below 30 or above 150 degrees."""
    ways = minus(two, one), minus(three, one)
    if min(math.hypot(*ways[0]), math.hypot(*ways[1]), math.dist(two, three)) < DISTANCE - ROUNDING:
        raise Unfit(10)
    cosine = dot(*ways) / (math.hypot(*ways[0]) * math.hypot(*ways[1]))
    angle = math.degrees(math.acos(max(-1.0, min(1.0, cosine))))
    if min(angle, 180 - angle) < STRAIGHT:
        raise Unfit(4)
    if not ANGLE - ROUNDING <= angle <= WIDEST + ROUNDING:
        raise Unfit(11)


def frame(one: Xyz, two: Xyz, three: Xyz) -> Rows:
    """Axes as columns: x from the first to the second point, the third in the x-y plane (L3568)."""
    check_triangle(one, two, three)
    x = unit(minus(two, one))
    z = unit(cross(x, minus(three, one)))
    return _transposed((x, cross(z, x), z))


def shift(source: Sequence[Xyz], destination: Sequence[Xyz], from_: Rows, to: Rows) -> Map:
    """The frame of the source onto that of the destination."""
    turn = times(to, _transposed(from_))
    return Map(lambda at: along(destination[0], applied(turn, minus(at, source[0])), 1.0), turn)


def mirror_shift(source: Sequence[Xyz], destination: Sequence[Xyz], from_: Rows, to: Rows) -> Map:
    """As a shift, the height above the plane of the points reversed (L3800-3802)."""
    flipped = times(to, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)))
    turn = times(flipped, _transposed(from_))
    return Map(lambda at: along(destination[0], applied(turn, minus(at, source[0])), 1.0), turn, True)


def offset(centre: Xyz, values: Sequence[float], cylinder: bool) -> Map:
    """Numbers for the shift; turns and radii are about the reference point PB (AX-759)."""
    one, two, dz, *angles = values[:6]
    a, b, c = (math.radians(angle) for angle in angles)
    turn = _rows(rotation_zyx(a, b, c))
    if not cylinder:
        return Map(lambda at: along(along(centre, applied(turn, minus(at, centre)), 1.0), (one, two, dz), 1.0), turn)
    turn = times(turn, _rows(rotation_zyx(0.0, 0.0, math.radians(two))))

    def point(at: Xyz) -> Xyz:
        x, y, z = minus(at, centre)
        radius = math.hypot(x, y)
        factor = (radius + one) / radius if radius else 0.0
        x, y, z = applied(turn, (x * factor if radius else one, y * factor, z))
        return centre[0] + x, centre[1] + y, centre[2] + z + dz

    return Map(point, turn)


# ---- expansion, shrinking, mirror inversion --------------------------------------------------------------------------------
def plane(one: Xyz, two: Xyz, three: Xyz, k: float) -> Map:
    """Distances from a plane times k; below 0 mirrored."""
    normal = unit(cross(minus(two, one), minus(three, one)))
    mirror = _reflection(normal) if k < 0 else IDENTITY
    return Map(lambda at: along(at, normal, (k - 1) * dot(minus(at, one), normal)), mirror, k < 0)


def line(one: Xyz, two: Xyz, k: float) -> Map:
    """Distances from a line times k; below 0 half a turn about it."""
    axis = unit(minus(two, one))

    def point(at: Xyz) -> Xyz:
        foot = along(one, axis, dot(minus(at, one), axis))
        return along(foot, minus(at, foot), k)

    half_turn = _scaled(_reflection(axis), -1.0)
    return Map(point, half_turn if k < 0 else IDENTITY)


def point(centre: Xyz, k: float) -> Map:
    """Distances from a point times k; below 0 mirrored in the point."""
    return Map(lambda at: along(centre, minus(at, centre), k), _scaled(IDENTITY, -1.0) if k < 0 else IDENTITY, k < 0)


def _reflection(normal: Xyz) -> Rows:
    one, two, three = (tuple(float(i == j) - 2 * normal[i] * normal[j] for j in range(3)) for i in range(3))
    return (one[0], one[1], one[2]), (two[0], two[1], two[2]), (three[0], three[1], three[2])


def _scaled(rows: Rows, by: float) -> Rows:
    (a, b, c), (d, e, f), (g, h, i) = rows
    return (by * a, by * b, by * c), (by * d, by * e, by * f), (by * g, by * h, by * i)


def plane_distance(one: Xyz, two: Xyz, three: Xyz, at: Xyz) -> float:
    """Signed distance from a plane."""
    return dot(minus(at, one), unit(cross(minus(two, one), minus(three, one))))


def line_distance(one: Xyz, two: Xyz, at: Xyz) -> float:
    """Distance from a line."""
    return math.hypot(*cross(minus(at, one), unit(minus(two, one))))
