"""Curves of the tool centre point: geometry alone, no time (design 1: path and time are separate).

A curve runs from s = 0 to s = length.  s is the arc length of the TCP in m where the TCP moves, and the angle in rad where
only the orientation turns; splines and corners keep |p'| = 1 to the accuracy their module states.  A joint curve is the same
for axes: q(s), s = travel of the axis that leads.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

from motion.frames import Pose

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)


class Derivatives(NamedTuple):
    """By s, in the frame the curve is given in."""

    p1: Vector  # dp/ds, 1 (m per m) or 0 where only the orientation turns
    p2: Vector  # per m
    p3: Vector  # per m2
    w: Vector  # rotation vector rate: rad per unit of s
    w1: Vector  # its derivative by s


class Curve(Protocol):
    """A TCP curve; see the module.  s outside 0 .. length is cut to the ends."""

    @property
    def length(self) -> float:
        """m, or rad where the TCP stands; > 0."""
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


class JointCurve(Protocol):
    """A curve of the axes themselves."""

    @property
    def length(self) -> float:
        """Travel along the curve, in units of the leading axis (m or rad); > 0."""
        ...

    def q(self, s: float) -> tuple[float, ...]:
        """(axes,) m or rad."""
        ...

    def derivatives(self, s: float) -> JointDerivatives:
        """At s; one-sided from inside at the ends."""
        ...


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
