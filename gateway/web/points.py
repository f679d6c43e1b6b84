"""Points, lines and frames as the page draws a robot: m, to a tenth of a millimetre."""

from collections.abc import Sequence

Point = tuple[float, float, float]
Lines = list[list[Point]]
Frame = tuple[str, Point, tuple[float, ...]]  # name, origin in m, rotation of nine floats, row after row
GRIPPER_M = 0.06  # a short piece along the flange's own z, so that its direction is seen


def rounded(point: Sequence[float]) -> Point:
    """To a tenth of a millimetre."""
    return round(point[0], 4), round(point[1], 4), round(point[2], 4)
