"""Paths of several kinematics side by side: one s for all of them.

Columns: the axes of all kinematics in their order, then way and turning of each kinematic (they carry its limits of the tool), then,
as every path has them, a way and a turning at the very end: those of the kinematic that leads.  To the laws all columns but the last
two are axes like any others, so what holds for axes holds for every tool as well.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from motion.paths.base import PathError
from motion.paths.corner import hermite
from motion.paths.joints import DEGREE, JointPath, shifted

Array = NDArray[np.float64]
SAME = 1e-9  # share of the length: knots of two paths that are closer than this are one
TOLERANCE = 2e-9  # m or rad: as motion.planner.joint_path
PROBES = (0.2, 0.5, 0.8)
MOST_PIECES = 256
State = tuple[float, float, float]  # a value and its first two derivatives


def rescaled(path: JointPath, length: float) -> JointPath:
    """The same way with s from 0 to `length`."""
    factor = length / path.length
    powers = factor ** -np.arange(DEGREE + 1, dtype=np.float64)
    return JointPath(path.knots * factor, path.coefficients * powers[None, :, None])


def side_by_side(parts: Sequence[JointPath | tuple[float, ...]], lead: int) -> JointPath:
    """Paths of one length, one for each kinematic; a tuple: these axes rest there.  lead: the one whose way is last."""
    moving = [part for part in parts if isinstance(part, JointPath)]
    knots = _knots([part.knots for part in moving])
    axes, ways = [], []
    for part in parts:
        table = _on(part, knots) if isinstance(part, JointPath) else _rest(part, len(knots) - 1)
        axes.append(table[:, :, :-2])
        ways.append(table[:, :, -2:])
    return JointPath(knots, np.concatenate([*axes, *ways, ways[lead]], axis=2))


def repaced(path: JointPath, pace: Callable[[float], State], length: float) -> JointPath:
    """Return the same path in another parameter: pace returns (s on the path, its first and second derivative) for u in 0 .. length.

    Quintic Hermite pieces, halved until they follow to 2e-9; the ends have the slope and bend that the pace defines.
    """
    edges, todo = [0.0], [length]
    columns: list[list[Sequence[float]]] = []
    while todo:
        left, right = edges[-1], todo[-1]
        rows = [hermite(right - left, a, b) for a, b in zip(_states(path, pace(left)), _states(path, pace(right)), strict=True)]
        if len(edges) > MOST_PIECES:
            raise PathError("the pace of a corner leads away from its path")
        if _follows(path, pace, left, right - left, rows):
            columns.append(list(rows))
            edges.append(todo.pop())
        else:
            todo.append(0.5 * (left + right))
    table = np.zeros((len(columns), DEGREE + 1, path.axes + 2))
    for i, row in enumerate(columns):
        table[i] = np.array(row).T
    return JointPath(np.array(edges), table)


def _states(path: JointPath, at: State) -> list[State]:
    s, first, second = at
    q, q1, q2 = (path.at(np.array([s]), order)[0] for order in range(3))
    return [(float(a), float(b * first), float(c * first * first + b * second)) for a, b, c in zip(q, q1, q2, strict=True)]


def _follows(path: JointPath, pace: Callable[[float], State], start: float, span: float, rows: Sequence[Sequence[float]]) -> bool:
    table = np.array(rows)
    for probe in PROBES:
        u = probe * span
        exact = path.at(np.array([pace(start + u)[0]]))[0]
        made = table @ (u ** np.arange(DEGREE + 1))
        if float(np.max(np.abs(made - exact)[:-2])) > TOLERANCE:
            return False
    return True


def _knots(each: Sequence[Array]) -> Array:
    """All of them, rising, those that are the same but for the last bits once."""
    length = float(each[0][-1])
    found = np.unique(np.concatenate([*each, np.array([0.0, length])]))
    inner = found[(found > SAME * length) & (found < length * (1 - SAME))]
    apart = inner[np.concatenate([[True], np.diff(inner) > SAME * length])] if len(inner) else inner
    return np.concatenate([[0.0], apart, [length]])


def _on(path: JointPath, knots: Array) -> Array:
    """(k, 6, columns): its polynomials about other knots."""
    index = np.searchsorted(path.knots, 0.5 * (knots[1:] + knots[:-1]), side="right") - 1
    index = np.clip(index, 0, len(path.coefficients) - 1)
    return np.array([shifted(path.coefficients[i], float(k - path.knots[i])) for i, k in zip(index, knots[:-1], strict=True)])


def _rest(q: tuple[float, ...], count: int) -> Array:
    table = np.zeros((count, DEGREE + 1, len(q) + 2))
    table[:, 0, : len(q)] = q
    return table
