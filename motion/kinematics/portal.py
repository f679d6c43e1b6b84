"""Cartesian portals with 2 to 6 axes: linear axes x, y, z in any order, then up to three rotary axes that meet in one point.

`letters` names the axes in their order: "xz", "xyz", "xyzc", "xyzcba" (c about z, then b about y', then a about x'': the angles of
the rho 3), "xyzcbc" (a wrist).  The wrist carries the flange at the fixed pose `flange`.  Of a wrist of three axes there are two
ways; `wpositive` is the one whose middle angle lies in -90 .. 90 degrees (in 0 .. 180 where first and last axis are alike).
"""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.geometry.frames import IDENTITY, NO_ROTATION, Pose, Rotation, compose, product, rotate, transposed
from motion.geometry.limits import AxisLimits
from motion.geometry.units import Kind, kind_of
from motion.kinematics.base import FREE, Branch, Configuration, Joints, Unreachable, Wrist
from motion.kinematics.choice import Chooser, wrapped

STRAY = 1e-9  # m or rad: how far a pose may be off in a direction the portal does not have
POLE = 1e-10  # sine or cosine of the middle angle below which first and last axis turn about one line
POSITIVE, NEGATIVE = Configuration(wrist=Wrist.POSITIVE), Configuration(wrist=Wrist.NEGATIVE)


class Portal:
    """q: (axes,) m, then rad; poses of the flange in the portal's frame."""

    def __init__(self, letters: str, limits: Sequence[AxisLimits], flange: Pose = IDENTITY) -> None:
        linear = "".join(letter for letter in letters if letter in "xyz")
        rotary = letters[len(linear) :]
        if not 2 <= len(letters) <= 6 or not letters.startswith(linear) or len(set(linear)) < len(linear) or not linear:
            raise MotionError(f"portal {letters!r}: x, y, z at most once each and first, then a, b, c; 2 to 6 axes")
        if len(rotary) > 3 or set(rotary) - set("abc") or any(one == two for one, two in itertools.pairwise(rotary)):
            raise MotionError(f"portal {letters!r}: up to three rotary axes out of a, b, c, neighbours unlike")
        if len(limits) != len(letters):
            raise MotionError(f"portal {letters!r} has {len(letters)} axes, {len(limits)} limits are given")
        for letter, axis in zip(letters, limits, strict=True):
            if (kind_of(axis.unit) is Kind.ROTARY) is not (letter in "abc"):
                raise MotionError(f"portal {letters!r}: axis {axis.name} has the unit {axis.unit}, which does not fit {letter}")
        self.letters, self.limits, self.flange, self.axes = letters, tuple(limits), flange, len(letters)
        self._places = tuple("xyz".index(letter) for letter in linear)
        self._absent = tuple(n for n in range(3) if n not in self._places)
        self._turns = tuple("abc".index(letter) for letter in rotary)
        self._offset = flange.inverse() if flange != IDENTITY else None
        self._chooser = Chooser(limits)

    def forward(self, q: Sequence[float]) -> Pose:
        """(axes,) -> flange."""
        position = [0.0, 0.0, 0.0]
        for place, value in zip(self._places, q, strict=False):
            position[place] = value
        rotation = turned(self._turns, q[len(self._places) :])
        wrist = Pose((position[0], position[1], position[2]), rotation)
        return wrist if self._offset is None else compose(wrist, self.flange)

    def branches(self, pose: Pose) -> list[Branch]:
        """One way, or two with three rotary axes; none where the portal lacks an axis for it."""
        position, rotation = pose if self._offset is None else compose(pose, self._offset)
        for place in self._absent:
            if not abs(position[place]) <= STRAY:
                return []
        linear = tuple([position[place] for place in self._places])
        if not self._turns:
            return [(linear, FREE)] if rotation == NO_ROTATION or _alike(rotation, NO_ROTATION) else []
        if len(self._turns) == 1:
            angle = _single(self._turns[0], rotation)
            return [] if angle is None else [((*linear, angle), FREE)]
        if len(self._turns) == 3:
            first, second = both_ways(self._turns, rotation, 0.0)
            return [((*linear, *first), POSITIVE), ((*linear, *second), NEGATIVE)]
        return [((*linear, *angles), FREE) for angles in _fewer(self._turns, rotation)]

    def inverse(self, pose: Pose, near: Sequence[float], configuration: Configuration | None = None) -> Joints:
        """The nearest way inside the limits; Unreachable 532 or 534 names the direction the portal lacks."""
        found = self.branches(pose)
        if not found:
            raise self._lack(pose)
        if len(self._turns) == 3:
            found = self._held(pose, near, found)
        return self._chooser.choose(found, near, configuration, self.configuration(near))

    def follow(self, pose: Pose, near: Sequence[float]) -> Joints:
        """As inverse: the nearest way."""
        return self.inverse(pose, near)

    def configuration(self, q: Sequence[float]) -> Configuration:
        """The wrist of three rotary axes; FREE otherwise."""
        if len(self._turns) < 3:
            return FREE
        middle = wrapped(q[-2])
        alike = self._turns[0] == self._turns[2]
        return POSITIVE if (middle >= 0.0 if alike else abs(middle) <= math.pi / 2) else NEGATIVE

    def jacobian(self, q: Sequence[float]) -> NDArray[np.float64]:
        """(6, axes)."""
        columns = np.zeros((6, self.axes))
        for n, place in enumerate(self._places):
            columns[place, n] = 1.0
        first = len(self._places)
        x, y, z = rotate(turned(self._turns, q[first:]), self.flange.position)  # from the wrist to the flange
        for n, axis in enumerate(self._turns):
            before = turned(self._turns[:n], q[first : first + n])
            u, v, w = before[axis], before[axis + 3], before[axis + 6]
            columns[:, first + n] = (v * z - w * y, w * x - u * z, u * y - v * x, u, v, w)
        return columns

    def _held(self, pose: Pose, near: Sequence[float], found: list[Branch]) -> list[Branch]:
        """At the pole of the wrist the last axis stays where it is."""
        _, rotation = pose if self._offset is None else compose(pose, self._offset)
        ways = both_ways(self._turns, rotation, near[-1])
        first = len(self._places)
        return [((*joints[:first], *angles), flags) for (joints, flags), angles in zip(found, ways, strict=True)]

    def _lack(self, pose: Pose) -> Unreachable:
        position = (pose if self._offset is None else compose(pose, self._offset)).position
        for place in self._absent:
            if not abs(position[place]) <= STRAY:
                return Unreachable(f"{position[place] * 1e3:.6g} mm in {'xyz'[place]}, where {self.letters} has no axis", number=532)
        return Unreachable(f"this orientation with the axes {self.letters}", number=534)


def turned(turns: Sequence[int], angles: Sequence[float]) -> Rotation:
    """Return successive rotations about the axes 0 (x), 1 (y), 2 (z), each about the axis as already rotated."""
    rotation = NO_ROTATION
    for axis, angle in zip(turns, angles, strict=True):
        rotation = product(rotation, about(axis, angle))
    return rotation


def about(axis: int, angle: float) -> Rotation:
    """Rotation about x, y or z (0, 1, 2) by rad."""
    s, c = math.sin(angle), math.cos(angle)
    if axis == 0:
        return 1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c
    if axis == 1:
        return c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c
    return c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0


def both_ways(turns: Sequence[int], r: Rotation, last: float) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """The two ways to make a rotation by three axes; at the pole, where only a sum is known, the last one is `last`."""
    i, j, k = turns
    if k == i:
        return _with_like_ends(i, j, r, last)
    e = 1.0 if (j - i) % 3 == 1 else -1.0
    sine, cosine = e * r[3 * i + k], math.hypot(r[3 * j + k], r[3 * k + k])
    middle = math.atan2(sine, cosine)
    if cosine < POLE:
        rest = product(r, transposed(about(k, last)))  # R_i R_j alone
        first = math.atan2(e * rest[3 * k + j], rest[3 * j + j])
        return (first, middle, last), (first, middle, last)
    first = math.atan2(-e * r[3 * j + k], r[3 * k + k])
    rest = product(transposed(about(i, first)), r)  # R_j R_k alone, so that first and last fit together near the pole
    final = math.atan2(e * rest[3 * j + i], rest[3 * j + j])
    return (first, middle, final), (_opposite(first), wrapped(math.pi - middle), _opposite(final))


def _with_like_ends(i: int, j: int, r: Rotation, last: float) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """R_i(first) R_j(middle) R_i(last)."""
    k = 3 - i - j
    e = 1.0 if (j - i) % 3 == 1 else -1.0
    up, across = r[3 * j + i], -e * r[3 * k + i]
    sine = math.hypot(up, across)
    middle = math.atan2(sine, r[4 * i])
    if sine < POLE:
        rest = product(r, transposed(about(i, last)))  # R_i R_j with a middle of 0 or pi
        first = math.atan2(e * rest[3 * k + j], rest[3 * j + j])
        return (first, middle, last), (first, -middle, last)
    first = math.atan2(up, across)
    rest = product(transposed(about(i, first)), r)  # R_j R_i
    final = math.atan2(e * -rest[3 * j + k], rest[3 * j + j])
    return (first, middle, final), (_opposite(first), -middle, _opposite(final))


def _opposite(angle: float) -> float:
    return angle + math.pi if angle < 0.0 else angle - math.pi


def _single(axis: int, r: Rotation) -> float | None:
    """The angle of a rotation about this axis alone; None for another rotation."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    straight = r[4 * axis] > 0.0 and abs(r[3 * axis + j]) <= STRAY and abs(r[3 * axis + k]) <= STRAY
    return math.atan2(r[3 * k + j], r[4 * j]) if straight else None


def _fewer(turns: Sequence[int], rotation: Rotation) -> list[tuple[float, ...]]:
    """The one way with two axes; none where the rotation needs the third."""
    i, j = turns
    for first, second, _ in both_ways((i, j, 3 - i - j), rotation, 0.0):
        if _alike(turned(turns, (first, second)), rotation):
            return [(first, second)]
    return []


def _alike(one: Rotation, two: Rotation) -> bool:
    return all(abs(a - b) <= STRAY for a, b in zip(one, two, strict=True))
