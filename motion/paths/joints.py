"""Paths of the axes: piecewise quintics q(s), from which time laws and pieces are made.

Columns of a path: the axes (m or rad), then the way of the TCP (m) and its turning (rad), which carry the limits of path and
orientation speed.  PTP is a straight line in the axes (s = travel of the leading axis); corners between PTP blocks are the
quintic of motion.paths.corner in axis space; between unlike blocks a quintic joins value, slope and bend of both.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motion.paths.base import PathError
from motion.paths.corner import hermite

Array = NDArray[np.float64]
DEGREE = 5
JOIN, JOIN_SLOPE = 2e-8, 1e-5  # steps of value (m, rad) and slope (relative) allowed where paths meet
NO_WAY = 1e-12
RISING = np.arange(1, DEGREE + 1)  # powers that leave 0
FACTORS = tuple(tuple(float(math.perm(k, order)) for k in range(DEGREE + 1)) for order in range(4))  # of derivatives, by power


@dataclass(frozen=True)
class JointPath:
    """knots: (k + 1,) rising from 0; coefficients: (k, 6, axes + 2) lowest power first, in s - knot."""

    knots: Array
    coefficients: Array

    @property
    def axes(self) -> int:
        """How many axes."""
        return int(self.coefficients.shape[2]) - 2

    @property
    def length(self) -> float:
        """End of s."""
        return float(self.knots[-1])

    def at(self, s: Array, order: int = 0) -> Array:
        """(n, axes + 2): the columns, or their derivative of this order (0 .. 3) by s."""
        s = np.minimum(np.maximum(s, 0.0), self.knots[-1])
        if len(self.coefficients) == 1:
            u, rows = s[:, None], self.coefficients
        else:
            index = self.knots[1:-1].searchsorted(s, side="right")
            u, rows = (s - self.knots[index])[:, None], self.coefficients[index]
        value = FACTORS[order][DEGREE] * rows[:, DEGREE]
        for k in range(DEGREE - 1, order - 1, -1):
            value = value * u
            value += FACTORS[order][k] * rows[:, k] if order else rows[:, k]
        return value

    @cached_property
    def reach(self) -> tuple[Array, Array]:
        """(axes,) values none of the axes goes below, and above: not the nearest ones, but known at once."""
        table = self.coefficients[:, :, : self.axes]
        if len(table) == 1:
            h, rows = float(self.knots[-1]), table[0]
            away = (np.abs(rows[1:]) * np.array([[h], [h**2], [h**3], [h**4], [h**5]])).sum(axis=0)
            return rows[0] - away, rows[0] + away
        powers = (self.knots[1:] - self.knots[:-1])[:, None] ** RISING
        away = (np.abs(table[:, 1:]) * powers[:, :, None]).sum(axis=1)
        return (table[:, 0] - away).min(axis=0), (table[:, 0] + away).max(axis=0)

    def looks(self, count: int) -> Array:
        """Return the places to examine: `count` even intervals, and the knots, which are dense where the axes move fast."""
        return np.union1d(np.linspace(0.0, self.length, count + 1), self.knots)

    def q(self, s: float) -> tuple[float, ...]:
        """(axes,) at s."""
        s = min(max(s, 0.0), float(self.knots[-1]))
        index = int(self.knots[1:-1].searchsorted(s, side="right"))
        rows, u = self.coefficients[index, :, : self.axes], s - float(self.knots[index])
        found = rows[DEGREE]
        for k in range(DEGREE - 1, -1, -1):
            found = found * u + rows[k]
        return tuple(found.tolist())


def joint_path(knots: Sequence[float], rows: Sequence[Sequence[Sequence[float]]]) -> JointPath:
    """rows[interval][column] = coefficients, at most six."""
    table = np.zeros((len(rows), DEGREE + 1, len(rows[0])))
    for i, columns in enumerate(rows):
        for j, row in enumerate(columns):
            table[i, : len(row), j] = row
    return JointPath(np.asarray(knots, dtype=np.float64), table)


def joint_line(start: Sequence[float], end: Sequence[float]) -> JointPath:
    """Return the straight path from start to end.  Raise PathError where nothing moves or a value is NaN."""
    a, b = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    length = float(np.max(np.abs(b - a))) if a.shape == b.shape and a.size else float("nan")
    if not NO_WAY < length < float("inf"):
        raise PathError(f"no line leads from {list(start)} to {list(end)}")
    return joint_path([0.0, length], [[*((x, (y - x) / length) for x, y in zip(a, b, strict=True)), (0.0,), (0.0,)]])


def joint_blend(before: JointPath, leave_at: float, after: JointPath, reach_at: float, length: float | None = None) -> JointPath:
    """A quintic from s = leave_at on `before` to s = reach_at on `after`, joining value, slope and bend."""
    span = (before.length - leave_at + reach_at) if length is None else length
    first, last = _state(before, leave_at), _state(after, reach_at)
    last[0, -2:] += first[0, -2:] - last[0, -2:] + 0.5 * span * (first[1, -2:] + last[1, -2:])  # way and turning keep counting
    return joint_path([0.0, span], [[hermite(span, list(first[:, j]), list(last[:, j])) for j in range(first.shape[1])]])


def _state(path: JointPath, s: float) -> Array:
    return np.stack([path.at(np.array([s]), order)[0] for order in range(3)])


def joint_part(path: JointPath, start: float, end: float) -> JointPath:
    """The stretch start .. end of a path."""
    if not -1e-12 <= start < end <= path.length * (1 + 1e-12) + 1e-12:
        raise PathError(f"{start} .. {end} is not a section of a path of length {path.length}")
    if len(path.coefficients) == 1:
        return JointPath(np.array([0.0, end - start]), shifted(path.coefficients[0], float(start))[None])
    inner = path.knots[(path.knots > start + 1e-12) & (path.knots < end - 1e-12)]
    knots = np.concatenate([[start], inner, [end]])
    index = np.clip(np.searchsorted(path.knots, 0.5 * (knots[1:] + knots[:-1]), side="right") - 1, 0, len(path.coefficients) - 1)
    table = np.array([shifted(path.coefficients[i], float(k - path.knots[i])) for i, k in zip(index, knots[:-1], strict=True)])
    return JointPath(knots - start, table)


def shifted(rows: Array, u: float) -> Array:
    """Coefficients of the same polynomial about another point (Horner's scheme, repeated)."""
    result = rows.copy()
    if not rows[2:].any():  # a straight way
        result[0] += u * rows[1]
        return result
    for i in range(DEGREE):
        for k in range(DEGREE - 1, i - 1, -1):
            result[k] += u * result[k + 1]
    return result


def joined(paths: Sequence[JointPath]) -> JointPath:
    """Return the paths in sequence; way and turning keep counting.  Raise PathError where values or slopes do not fit."""
    for number, (left, right) in enumerate(pairwise(paths)):
        end, begin = _state(left, left.length), _state(right, 0.0)
        n = left.axes
        if float(np.max(np.abs(end[0, :n] - begin[0, :n]))) > JOIN:
            raise PathError(f"path {number + 1} does not begin where path {number} ends")
        if float(np.max(np.abs(end[1, :n] - begin[1, :n]))) > JOIN_SLOPE * (1 + float(np.max(np.abs(end[1, :n])))):
            raise PathError(f"there is a corner between path {number} and path {number + 1}")
    knots, tables, offset = [np.zeros(1)], [], 0.0
    counted = np.zeros(2)
    for path in paths:
        table = path.coefficients.copy()
        shift = counted - table[0, 0, -2:]
        table[:, 0, -2:] += shift
        tables.append(table)
        knots.append(path.knots[1:] + offset)
        offset += path.length
        counted = path.at(np.array([path.length]))[0, -2:] + shift
    return JointPath(np.concatenate(knots), np.concatenate(tables))
