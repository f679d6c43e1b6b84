"""Straight lines with least rotation.  LINEAR of rho 3 and Reis (L300-302), movel of VAL 3 (L5374, L5493-5507)."""

import math

from motion.geometry.frames import Pose
from motion.geometry.orientation import between, is_half_turn
from motion.paths.base import PathError, norm, scale, sub
from motion.paths.polynomial import Polynomial, Row

NO_WAY_M = 1e-8  # shorter is no motion of the TCP
NO_TURN_RAD = 1e-9


def line(start: Pose, end: Pose) -> Polynomial:
    """From start to end; s in m, or in rad where only the orientation turns.

    PathError: no way and no turn; 553 where the orientations are half a turn apart (the direction is not known).
    """
    for value in (*start.position, *end.position, *start.rotation, *end.rotation):
        if not math.isfinite(value):
            raise PathError(f"a pose holds {value}, which is not a number")
    if is_half_turn(start.rotation, end.rotation):
        raise PathError("the orientation changes by exactly half a turn: its direction is not defined", 553)
    step, turn = sub(end.position, start.position), between(start.rotation, end.rotation)
    length = norm(step) if norm(step) > NO_WAY_M else norm(turn)
    if length <= NO_TURN_RAD:
        raise PathError("start and end are the same pose", 0)
    x, y, z = scale(step, 1 / length)
    a, b, c = scale(turn, 1 / length)
    rows: tuple[Row, Row, Row, Row, Row, Row] = ((0.0, x), (0.0, y), (0.0, z), (0.0, a), (0.0, b), (0.0, c))
    return Polynomial(start, rows, length)


def fixed_tool(place: Pose, length: float) -> Polynomial:
    """The tool stays at a place while something else goes its way, `length` in the units of that."""
    return Polynomial(place, ((0.0,), (0.0,), (0.0,), (0.0,), (0.0,), (0.0,)), length)
