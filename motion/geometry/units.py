"""Units at the command sources and inside: deg, mm, % outside; rad, m, 1 inside; all float64.

`unit` always names the outside unit of a position; speed, acceleration and jerk are the same unit per s, s2, s3.
"""

import math
from enum import Enum

from motion.errors import MotionError


class Kind(Enum):
    """What an axis does; its SI unit is the value."""

    LINEAR = "m"
    ROTARY = "rad"


# outside unit -> (kind, SI units in one outside unit)
UNITS: dict[str, tuple[Kind, float]] = {
    "mm": (Kind.LINEAR, 1e-3),
    "0.1 mm": (Kind.LINEAR, 1e-4),
    "um": (Kind.LINEAR, 1e-6),
    "m": (Kind.LINEAR, 1.0),
    "deg": (Kind.ROTARY, math.pi / 180),
    "0.1 deg": (Kind.ROTARY, math.pi / 1800),
    "rad": (Kind.ROTARY, 1.0),
    "turn": (Kind.ROTARY, 2 * math.pi),
}


def kind_of(unit: str) -> Kind:
    """LINEAR or ROTARY; raises MotionError for an unknown unit."""
    return _row(unit)[0]


def to_si(value: float, unit: str) -> float:
    """value in `unit` -> m or rad."""
    return value * _row(unit)[1]


def from_si(value: float, unit: str) -> float:
    """m or rad -> `unit`."""
    return value / _row(unit)[1]


def _row(unit: str) -> tuple[Kind, float]:
    try:
        return UNITS[unit]
    except KeyError:
        raise MotionError(f"unit {unit!r} is unknown; known are {', '.join(UNITS)}") from None
