"""Points, lines and frames as the page draws a robot: m, to a tenth of a millimetre."""

from collections.abc import Sequence

from motion.geometry.frames import NO_ROTATION, Pose

Point = tuple[float, float, float]
Lines = list[list[Point]]
Frame = tuple[str, Point, tuple[float, ...]]  # name, origin in m, rotation of nine floats, row after row
GRIPPER_M = 0.06  # a short piece along the flange's own z, so that its direction is seen, until a program names a tool
SHORT_TOOL = Pose((0.0, 0.0, GRIPPER_M), NO_ROTATION)


def rounded(point: Sequence[float]) -> Point:
    """To a tenth of a millimetre."""
    return round(point[0], 4), round(point[1], 4), round(point[2], 4)
