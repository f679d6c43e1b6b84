"""Poses: position and orientation of a frame in another one.  m and rad; plain floats, because numpy is slow for six numbers.

A pose is a position (x, y, z) m and a rotation matrix of nine floats, row by row.  `a @ b` takes b from a's frame into the frame in which
a is given: the product of the 4x4 matrices.  Angles of the old controllers are turned into this form in `motion.geometry.conventions`;
ways from one orientation to another are in `motion.geometry.orientation`.
"""

import math
from typing import NamedTuple

from motion.errors import MotionError

Vector = tuple[float, float, float]
Rotation = tuple[float, float, float, float, float, float, float, float, float]  # rows: r11 r12 r13 r21 r22 r23 r31 r32 r33
Quaternion = tuple[float, float, float, float]  # w, x, y, z

NO_ROTATION: Rotation = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
ORTHOGONAL = 1e-6  # how far the rows of a rotation may be from unit length and right angles


class Pose(NamedTuple):
    """position: (x, y, z) m; rotation: nine floats, row-major.  Frozen; a named tuple, since it is made thousands of times a second."""

    position: Vector
    rotation: Rotation

    def __matmul__(self, other: "Pose") -> "Pose":
        """self @ other: `other`, given in this frame, seen from outside."""
        return compose(self, other)

    def inverse(self) -> "Pose":
        """The outside seen from this frame: pose @ pose.inverse() is IDENTITY."""
        x, y, z = self.position
        a, b, c, d, e, f, g, h, i = self.rotation
        return Pose((-a * x - d * y - g * z, -b * x - e * y - h * z, -c * x - f * y - i * z), (a, d, g, b, e, h, c, f, i))

    def apply(self, point: Vector) -> Vector:
        """A point (m) given in this frame, seen from outside."""
        x, y, z = rotate(self.rotation, point)
        px, py, pz = self.position
        return px + x, py + y, pz + z

    def quaternion(self) -> Quaternion:
        """The orientation as unit quaternion (w, x, y, z) with w >= 0."""
        return quaternion_of(self.rotation)


IDENTITY = Pose((0.0, 0.0, 0.0), NO_ROTATION)


def compose(first: Pose, second: Pose) -> Pose:
    """first @ second."""
    x, y, z = first.position  # by name: a named tuple is unpacked slowly
    u, v, w = second.position
    if first.rotation is NO_ROTATION:  # a shift, as most frames are
        return Pose((x + u, y + v, z + w), second.rotation)
    a, b, c, d, e, f, g, h, i = first.rotation
    j, k, m, n, o, p, q, r, s = second.rotation
    return Pose(
        (x + a * u + b * v + c * w, y + d * u + e * v + f * w, z + g * u + h * v + i * w),
        (
            a * j + b * n + c * q,
            a * k + b * o + c * r,
            a * m + b * p + c * s,
            d * j + e * n + f * q,
            d * k + e * o + f * r,
            d * m + e * p + f * s,
            g * j + h * n + i * q,
            g * k + h * o + i * r,
            g * m + h * p + i * s,
        ),
    )


def rotate(rotation: Rotation, vector: Vector) -> Vector:
    """rotation times column vector."""
    a, b, c, d, e, f, g, h, i = rotation
    x, y, z = vector
    return a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z


def transposed(rotation: Rotation) -> Rotation:
    """The inverse of a rotation."""
    a, b, c, d, e, f, g, h, i = rotation
    return a, d, g, b, e, h, c, f, i


def product(first: Rotation, second: Rotation) -> Rotation:
    """first times second."""
    a, b, c, d, e, f, g, h, i = first
    j, k, m, n, o, p, q, r, s = second
    return (
        a * j + b * n + c * q,
        a * k + b * o + c * r,
        a * m + b * p + c * s,
        d * j + e * n + f * q,
        d * k + e * o + f * r,
        d * m + e * p + f * s,
        g * j + h * n + i * q,
        g * k + h * o + i * r,
        g * m + h * p + i * s,
    )


def translation(x: float, y: float, z: float) -> Pose:
    """A shift without rotation; m."""
    return Pose((x, y, z), NO_ROTATION)


def quaternion_of(rotation: Rotation) -> Quaternion:
    """Unit quaternion (w, x, y, z), w >= 0, of a rotation matrix; from its largest component, so exact near half turns too."""
    a, b, c, d, e, f, g, h, i = rotation
    trace = a + e + i
    if trace > 0.0:
        raw = (1.0 + trace, h - f, c - g, d - b)
    elif a >= e and a >= i:
        raw = (h - f, 1.0 + a - e - i, b + d, c + g)
    elif e >= i:
        raw = (c - g, b + d, 1.0 + e - a - i, f + h)
    else:
        raw = (d - b, c + g, f + h, 1.0 + i - a - e)
    w, x, y, z = raw
    scale = math.copysign(1.0 / math.sqrt(w * w + x * x + y * y + z * z), w)
    return w * scale, x * scale, y * scale, z * scale


def rotation_of(quaternion: Quaternion) -> Rotation:
    """Rotation matrix of a quaternion (w, x, y, z) of any length but zero (MotionError)."""
    w, x, y, z = quaternion
    square = w * w + x * x + y * y + z * z
    if not 0.0 < square < math.inf:  # a NaN fails here too
        raise MotionError(f"{quaternion} is not an orientation")
    s = 2.0 / square
    xs, ys, zs = x * s, y * s, z * s
    wx, wy, wz = w * xs, w * ys, w * zs
    xx, xy, xz, yy, yz, zz = x * xs, x * ys, x * zs, y * ys, y * zs, z * zs
    return 1.0 - yy - zz, xy - wz, xz + wy, xy + wz, 1.0 - xx - zz, yz - wx, xz - wy, yz + wx, 1.0 - xx - yy


def from_quaternion(position: Vector, quaternion: Quaternion) -> Pose:
    """Pose from a position (m) and a quaternion (w, x, y, z), which need not have unit length."""
    return Pose(position, rotation_of(quaternion))


def check_pose(pose: Pose) -> Pose:
    """Return the pose.  Raise MotionError when a number is not finite or the matrix is not a rotation."""
    if not all(map(math.isfinite, (*pose.position, *pose.rotation))):
        raise MotionError(f"a pose holds a value that is not a finite number: {pose}")
    a, b, c, d, e, f, g, h, i = pose.rotation
    faults = (
        a * a + b * b + c * c - 1.0,
        d * d + e * e + f * f - 1.0,
        a * d + b * e + c * f,
        b * f - c * e - g,
        c * d - a * f - h,
        a * e - b * d - i,
    )
    if max(map(abs, faults)) > ORTHOGONAL:
        raise MotionError(f"the nine numbers of a pose do not form a rotation: {pose.rotation}")
    return pose
