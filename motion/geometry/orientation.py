"""Ways from one orientation to another: the least rotation, its axis and angle, and points on it.

Least rotation is what VAL 3 ("tool rotation is always of minimum amplitude", L5493-5507) and ZIRK_MIN_ORI of the Reis (L304)
ask for.  At exactly half a turn the axis is undefined (VAL 3 error 553): `rotation_vector` then chooses one of the two.
"""

import math

from motion.geometry.frames import Pose, Rotation, Vector, product, quaternion_of, transposed

TINY = 1e-12  # rad: below it the series are exact to the last bit
HALF_TURN = 1e-9  # rad: so near to a half turn the direction of the least rotation is not known


def rotation_vector(rotation: Rotation) -> Vector:
    """Axis times angle (rad, angle 0 .. pi) of a rotation."""
    w, x, y, z = quaternion_of(rotation)
    sine = math.sqrt(x * x + y * y + z * z)
    if sine < TINY:
        return 2.0 * x, 2.0 * y, 2.0 * z
    factor = 2.0 * math.atan2(sine, w) / sine
    return factor * x, factor * y, factor * z


def rotation_by(vector: Vector) -> Rotation:
    """Rotation about `vector` by its length (rad): the inverse of `rotation_vector`."""
    x, y, z = vector
    angle = math.sqrt(x * x + y * y + z * z)
    if angle < TINY:
        return 1.0, -z, y, z, 1.0, -x, -y, x, 1.0
    x, y, z = x / angle, y / angle, z / angle
    s, c = math.sin(angle), math.cos(angle)
    half = math.sin(0.5 * angle)
    v = 2.0 * half * half  # 1 - cos, without losing digits at small angles
    return (
        c + x * x * v,
        x * y * v - z * s,
        x * z * v + y * s,
        x * y * v + z * s,
        c + y * y * v,
        y * z * v - x * s,
        x * z * v - y * s,
        y * z * v + x * s,
        c + z * z * v,
    )


def between(start: Rotation, end: Rotation) -> Vector:
    """Rotation vector (rad, in the frame of `start`) of the least rotation from start to end."""
    return rotation_vector(product(transposed(start), end))


def angle_between(start: Rotation, end: Rotation) -> float:
    """Angle of the least rotation, 0 .. pi rad."""
    x, y, z = between(start, end)
    return math.sqrt(x * x + y * y + z * z)


def is_half_turn(start: Rotation, end: Rotation) -> bool:
    """True where the least rotation has no direction: both ways round are equally long."""
    return math.pi - angle_between(start, end) < HALF_TURN


def slerp(start: Rotation, end: Rotation, part: float) -> Rotation:
    """Return the orientation at `part` of the least rotation from start (0) to end (1); outside 0 .. 1 the rotation continues."""
    if start == end:
        return start
    x, y, z = between(start, end)
    return product(start, rotation_by((part * x, part * y, part * z)))


def interpolated(start: Pose, end: Pose, part: float) -> Pose:
    """Straight line and least rotation together."""
    (x, y, z), (u, v, w) = start.position, end.position
    position = (x + part * (u - x), y + part * (v - y), z + part * (w - z))
    return Pose(position, slerp(start.rotation, end.rotation, part))
