"""RELATIVE and CALC_REL of the Reis ROBOTstar V.  Source: L366-422, vectors L787 and L3985-4010, VEC_ADD and others L889-939.

A vector holds a frame number, x, y, z mm, A, B, C deg and offsets of up to 24 axes; all its values are added to the position's,
number by number, also the angles: as in the manual ("will be added"), not a composition of rotations.
"""

import math
from dataclasses import dataclass, replace

from motion.errors import MotionError

MOST_AXES = 24


@dataclass(frozen=True, slots=True)
class Vector:
    """valid: components have been given values; RELATIVE needs that (L380)."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    a: float = 0.0
    b: float = 0.0
    c: float = 0.0
    frame: int = 0
    axes: tuple[float, ...] = ()
    valid: bool = True

    @property
    def values(self) -> tuple[float, float, float, float, float, float]:
        """x, y, z, A, B, C."""
        return self.x, self.y, self.z, self.a, self.b, self.c

    def value(self) -> float:
        """VEC_VALUE: length of the shift, mm (L910-924)."""
        return math.hypot(self.x, self.y, self.z)


@dataclass(frozen=True, slots=True)
class Position:
    """A programmed position: TCP in mm and deg, frame number, additional axes in mm or deg."""

    x: float
    y: float
    z: float
    a: float = 0.0
    b: float = 0.0
    c: float = 0.0
    frame: int = 0
    axes: tuple[float, ...] = ()

    @property
    def values(self) -> tuple[float, float, float, float, float, float]:
        """x, y, z, A, B, C."""
        return self.x, self.y, self.z, self.a, self.b, self.c


VNULL = Vector()


def added(first: Vector, second: Vector) -> Vector:
    """VEC_ADD first, second: what second becomes (L889-906)."""
    return _combined(first, second, 1.0)


def subtracted(first: Vector, second: Vector) -> Vector:
    """VEC_SUB first, second: second - first, as SUB (doubt D38)."""
    return _combined(first, second, -1.0)


def _combined(first: Vector, second: Vector, sign: float) -> Vector:
    x, y, z, a, b, c = (two + sign * one for one, two in zip(first.values, second.values, strict=True))
    axes = tuple(two + sign * one for one, two in zip(*_padded(first.axes, second.axes), strict=True))
    return Vector(x, y, z, a, b, c, second.frame, axes, first.valid and second.valid)


def _padded(one: tuple[float, ...], two: tuple[float, ...]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    most = max(len(one), len(two))
    return one + (0.0,) * (most - len(one)), two + (0.0,) * (most - len(two))


class Displacement:
    """The shift in force and the CALC_REL that waits for its position."""

    def __init__(self) -> None:
        self._vector = VNULL
        self._waiting = False

    def relative(self, vector: Vector) -> None:
        """RELATIVE: added to every position from now on; replaces the one before, _VNULL switches off.  Invalid: refused."""
        if not vector.valid:
            raise MotionError("RELATIVE: the vector has no valid values yet")
        if len(vector.axes) > MOST_AXES:
            raise MotionError(f"RELATIVE: {len(vector.axes)} axis offsets, at most {MOST_AXES}")
        self._vector = vector

    def calc_rel(self) -> None:
        """CALC_REL: the next position is not approached, it only gives the vector."""
        self._waiting = True

    def position(self, programmed: Position, actual: Position) -> tuple[Position | None, Vector | None]:
        """POSITION: (where to go, None), or after CALC_REL (None, actual - programmed).  Frames of both must be the same then."""
        if not self._waiting:
            return self._shifted(programmed), None
        if programmed.frame != actual.frame:
            raise MotionError(f"CALC_REL: actual position in frame {actual.frame}, programmed in {programmed.frame}")
        self._waiting = False
        x, y, z, a, b, c = (here - there for here, there in zip(actual.values, programmed.values, strict=True))
        axes = tuple(here - there for here, there in zip(*_padded(actual.axes, programmed.axes), strict=True))
        return None, Vector(x, y, z, a, b, c, programmed.frame, axes)

    def _shifted(self, programmed: Position) -> Position:
        v = self._vector
        x, y, z, a, b, c = (value + by for value, by in zip(programmed.values, v.values, strict=True))
        axes = tuple(value + by for value, by in zip(programmed.axes, _padded(v.axes, programmed.axes)[0], strict=False))
        return replace(programmed, x=x, y=y, z=z, a=a, b=b, c=c, axes=axes)
