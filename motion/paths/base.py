"""Curves of the tool centre point: geometry alone, no time (design 1: path and time are separate).

A curve runs from s = 0 to s = length.  On lines and arcs s is the arc length of the TCP in m, or the angle in rad where only
the orientation turns.  Corners and splines have a smooth parameter of the same size that joins its neighbours with |p'| = 1
and equal second derivatives; inside, |p'| may differ from 1 (corners: less), so speed on the path is sdot |p'|.  `way` gives
true lengths.  A joint curve is the same for axes: q(s), s = travel of the leading axis.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol

from motion.errors import MotionError
from motion.geometry.frames import Pose, Vector

ZERO: Vector = (0.0, 0.0, 0.0)


class PathError(MotionError):
    """Geometry that makes no path; `number` is the manual's number where it has one (VAL 3 550..554, Reis 620..), else 0; `interval`:
    of a curve through many points the one to blame, from 0."""

    def __init__(self, message: str, number: int = 0, interval: int = 0) -> None:
        self.number, self.interval = number, interval
        super().__init__(f"path error {number}: {message}" if number else message)


class Derivatives(NamedTuple):
    """By s, in the frame the curve is given in."""

    p1: Vector  # dp/ds (m per m); 0 where only the orientation turns
    p2: Vector  # per m
    p3: Vector  # per m2
    w: Vector  # rotation vector rate: rad per unit of s
    w1: Vector  # its derivative by s


class Curve(Protocol):
    """A TCP curve; see the module.  s outside 0 .. length is cut to the ends."""

    @property
    def length(self) -> float:
        """m, or rad where the TCP is at rest; > 0."""
        ...

    def at(self, s: float) -> Pose:
        """The pose at s."""
        ...

    def derivatives(self, s: float) -> Derivatives:
        """At s; one-sided from inside at the ends."""
        ...


class JointDerivatives(NamedTuple):
    """dq/ds, d2q/ds2, d3q/ds3, each (axes,)."""

    q1: tuple[float, ...]
    q2: tuple[float, ...]
    q3: tuple[float, ...]


def add(a: Sequence[float], b: Sequence[float]) -> Vector:
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a: Sequence[float], b: Sequence[float]) -> Vector:
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(a: Sequence[float], k: float) -> Vector:
    """k a."""
    return (a[0] * k, a[1] * k, a[2] * k)


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[float], b: Sequence[float]) -> Vector:
    """a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def norm(a: Sequence[float]) -> float:
    """|a|."""
    return float(dot(a, a) ** 0.5)


def unit(a: Sequence[float]) -> Vector:
    """a / |a|; a zero vector is the caller's mistake (ZeroDivisionError)."""
    return scale(a, 1.0 / norm(a))


_GAUSS = ((-math.sqrt(0.6), 5 / 9), (0.0, 8 / 9), (math.sqrt(0.6), 5 / 9))


def way(curve: Curve, start: float, end: float, parts: int = 8) -> float:
    """True TCP way in m between two parameters (Gauss, 3 points a part)."""
    h = (end - start) / parts
    middles = (start + (k + 0.5) * h for k in range(parts))
    return sum(weight * norm(curve.derivatives(m + 0.5 * h * x).p1) for m in middles for x, weight in _GAUSS) * 0.5 * h
