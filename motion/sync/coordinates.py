"""A pose as coordinates a belt of type 2 or 3 moves in proportion: x, y, z in m, and the rotation vector in rad from an orientation."""

from collections.abc import Sequence

from motion.geometry.frames import Pose, Rotation, product
from motion.geometry.orientation import between, rotation_by


def coordinates(pose: Pose, start: Rotation) -> tuple[float, ...]:
    """(6,)."""
    return (*pose.position, *between(start, pose.rotation))


def pose_of(values: Sequence[float], start: Rotation) -> Pose:
    """The reverse of coordinates()."""
    x, y, z, u, v, w = values[:6]
    return Pose((x, y, z), product(start, rotation_by((u, v, w))))
