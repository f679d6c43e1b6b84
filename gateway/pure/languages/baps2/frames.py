"""Workpiece coordinates (rho 3 releases L8797-8817): dc about z, then db about the resulting y', then da about the resulting x''.

The first three components of a point are x, y, z; the following ones are angles of its orientation.  An orientation is corrected as far as
the point has components for it (L8905-8914).
"""

import math
from collections.abc import Callable

from motion.geometry.conventions import DEGREE, RHO3
from motion.geometry.frames import Rotation, product, transposed

Frame = tuple[float, ...]
NO_FRAME: Frame = (0.0,) * 6
ORIENTED = {4: (2,)}  # components of a point -> which of a, b, c it has; one of four turns about z
Angles = tuple[float, ...]  # a, b, c, deg


def _turned(angle: float) -> tuple[float, float]:
    """Cosine and sine of an angle in degrees; of a right angle exactly, so that POS is written without a rest."""
    quarters = angle / 90.0
    if quarters.is_integer():
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarters) % 4]
    return math.cos(math.radians(angle)), math.sin(math.radians(angle))


def _matrix(frame: Frame) -> tuple[tuple[float, float, float], ...]:
    (ca, sa), (cb, sb), (cc, sc) = (_turned(angle) for angle in frame[3:6])
    return (
        (cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa),
        (sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa),
        (-sb, cb * sa, cb * ca),
    )


def to_world(frame: Frame, point: tuple[float, ...]) -> tuple[float, ...]:
    """A point of the workpiece in the original coordinates."""
    if frame == NO_FRAME:
        return point
    vector = (*point[:3], 0.0, 0.0, 0.0)[:3]
    moved = [sum(row[k] * vector[k] for k in range(3)) + frame[i] for i, row in enumerate(_matrix(frame))]
    return (*moved[: min(3, len(point))], *_oriented(point, lambda angles: _composed(frame[3:6], angles)), *point[6:])


def to_workpiece(frame: Frame, point: tuple[float, ...]) -> tuple[float, ...]:
    """The reverse."""
    if frame == NO_FRAME:
        return point
    vector = [value - frame[i] for i, value in enumerate((*point[:3], 0.0, 0.0, 0.0)[:3])]
    rows = _matrix(frame)
    moved = [sum(rows[k][i] * vector[k] for k in range(3)) for i in range(3)]
    return (*moved[: min(3, len(point))], *_oriented(point, lambda angles: _taken_off(frame[3:6], angles)), *point[6:])


def _oriented(point: tuple[float, ...], turn: Callable[[Angles], Angles]) -> list[float]:
    """The angles of a point, turned; those it has no components for are 0 and are dropped."""
    own = point[3:6]
    places = ORIENTED.get(len(point), range(len(own)))
    angles = [0.0, 0.0, 0.0]
    for place, value in zip(places, own, strict=True):
        angles[place] = value
    turned = turn(tuple(angles))
    return [turned[place] for place in places]


def _composed(frame: Angles, angles: Angles) -> Angles:
    """The orientation `angles` within the frame.  About z alone it is a sum, which leaves no rest."""
    if not any(frame[:2]):
        return (*angles[:2], angles[2] + frame[2])
    return frame if not any(angles) else _angles(product(_rotation(frame), _rotation(angles)))


def _taken_off(frame: Angles, angles: Angles) -> Angles:
    """The orientation `angles` as seen from the frame."""
    if not any(frame[:2]):
        return (*angles[:2], angles[2] - frame[2])
    return (0.0, 0.0, 0.0) if angles == frame else _angles(product(transposed(_rotation(frame)), _rotation(angles)))


def _rotation(angles: Angles) -> Rotation:
    a, b, c = (angle * DEGREE for angle in angles)
    return RHO3.to_rotation(a, b, c)


def _angles(rotation: Rotation) -> Angles:
    return tuple(angle / DEGREE for angle in RHO3.to_angles(rotation))
