"""Workpiece coordinates (rho 3 releases L8797-8817): dc about z, then db about the resulting y', then da about the resulting x''."""

import math

Frame = tuple[float, ...]
NO_FRAME: Frame = (0.0,) * 6


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
    """A point of the workpiece in the original coordinates; the first three components are x, y, z, the next three turn."""
    if frame == NO_FRAME:
        return point
    vector = (*point[:3], 0.0, 0.0, 0.0)[:3]
    moved = [sum(row[k] * vector[k] for k in range(3)) + frame[i] for i, row in enumerate(_matrix(frame))]
    turned = [value + frame[i] for i, value in enumerate(point[3:6], 3)]
    return (*moved[: min(3, len(point))], *turned, *point[6:])


def to_workpiece(frame: Frame, point: tuple[float, ...]) -> tuple[float, ...]:
    """The reverse."""
    if frame == NO_FRAME:
        return point
    vector = [value - frame[i] for i, value in enumerate((*point[:3], 0.0, 0.0, 0.0)[:3])]
    rows = _matrix(frame)
    moved = [sum(rows[k][i] * vector[k] for k in range(3)) for i in range(3)]
    turned = [value - frame[i] for i, value in enumerate(point[3:6], 3)]
    return (*moved[: min(3, len(point))], *turned, *point[6:])
