"""A path of the axes with its own parameter where they move faster than the tool.

A line that passes 1e-6 m from a wrist pole turns axis 4 by half a turn within micrometres: no even grid over the tool's way resolves that.
Here s(u) slows down there: ds/du = 1 / r with r = sqrt(1 + (x / RATE - 1)^2) where the axes' own rate x = |q'(s)| is above RATE, and 1
elsewhere, so that consecutive paths still fit each other.
"""

import math

import numpy as np
from numpy.typing import NDArray

from motion.paths.joints import DEGREE, JointPath

Array = NDArray[np.float64]
RATE = 25.0  # rad or m of the axes for each m of the way
STEEPEST = 0.5 * DEGREE  # times the span an axis cannot leave in an interval: no polynomial goes faster than that
CLOSE = 1e-9  # m or rad between both paths
HALVINGS = 12  # of an interval, until they are so close
GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(8)
LOOKS = np.array([0.15, 0.35, 0.5, 0.65, 0.85])


def evened(path: JointPath) -> JointPath | None:
    """The same places by the new parameter; None where the axes swing nowhere, or no new parameter follows them."""
    low, high = path.reach
    if STEEPEST * math.sqrt(path.axes) * float((high - low).max()) <= RATE * float((path.knots[1:] - path.knots[:-1]).min()):
        return None
    if max(_square(path.coefficients[:, 1, : path.axes]), _square(path.at(path.knots[-1:], 1)[:, : path.axes])) <= RATE * RATE:
        return None
    s = path.knots
    for _ in range(HALVINGS):
        made, bad = _tried(path, s)
        if not np.any(bad):
            return made
        middles = 0.5 * (s[:-1] + s[1:])[bad]
        s = np.sort(np.concatenate([s, middles]))
    return None


def _square(slopes: Array) -> float:
    """The largest of the axes' own rates, squared; slopes: of the axes at some places."""
    return float((slopes * slopes).sum(axis=1).max())


def _rates(path: JointPath, s: Array) -> tuple[Array, Array]:
    """r and dr/ds."""
    first, second = (path.at(s, order)[:, : path.axes] for order in (1, 2))
    x = np.sqrt(np.sum(first * first, axis=1))
    over = np.maximum(x / RATE - 1.0, 0.0)
    r = np.sqrt(1.0 + over * over)
    return r, over / r * np.sum(first * second, axis=1) / (RATE * np.maximum(x, 1e-12))


def _tried(path: JointPath, s: Array) -> tuple[JointPath, NDArray[np.bool_]]:
    """On these places: the path, and which of its intervals do not follow."""
    h = np.diff(s)
    inner = s[:-1, None] + 0.5 * h[:, None] * (1.0 + GAUSS)
    span = 0.5 * h * (_rates(path, inner.ravel())[0].reshape(inner.shape) @ WEIGHTS)
    r, change = _rates(path, s)
    ds, dds = 1.0 / r, -change / r**3
    q, first, second = (path.at(s, order) for order in range(3))
    ways = _quintics(span, s[:, None], ds[:, None], dds[:, None])
    table = _quintics(span, q, first * ds[:, None], second * ds[:, None] ** 2 + first * dds[:, None])
    bad = np.zeros(len(h), dtype=bool)
    for share in LOOKS:
        u = share * span
        place, pace = _value(ways, u)[:, 0], _slope(ways, u)[:, 0]
        bad |= (pace <= 0.0) | (place <= s[:-1]) | (place >= s[1:])
        bad |= np.max(np.abs(_value(table, u) - path.at(place)), axis=1) > CLOSE
    return JointPath(np.concatenate([[0.0], np.cumsum(span)]), table), bad


def _quintics(span: Array, value: Array, slope: Array, bend: Array) -> Array:
    """(n, 6, columns) Hermite coefficients between (n + 1, columns) states."""
    h = span[:, None]
    a, b, c = value[:-1], slope[:-1], 0.5 * bend[:-1]
    gap = value[1:] - a - b * h - c * h * h
    lean, curl = (slope[1:] - b - 2 * c * h) * h, (bend[1:] - 2 * c) * h * h
    rows = (
        a,
        b,
        c,
        (10 * gap - 4 * lean + 0.5 * curl) / h**3,
        (-15 * gap + 7 * lean - curl) / h**4,
        (6 * gap - 3 * lean + 0.5 * curl) / h**5,
    )
    return np.stack(rows, axis=1)


def _value(table: Array, u: Array) -> Array:
    value = np.zeros((len(table), table.shape[2]))
    for k in range(DEGREE, -1, -1):
        value = value * u[:, None] + table[:, k]
    return value


def _slope(table: Array, u: Array) -> Array:
    value = np.zeros((len(table), table.shape[2]))
    for k in range(DEGREE, 0, -1):
        value = value * u[:, None] + k * table[:, k]
    return value
