"""Interior point method for the problems of a law: least sum share / sqrt(x) under rows that couple three neighbours.

minimise sum share_i x_i^-1/2 subject to minus x_(i-1) + centre x_i + plus x_(i+1) <= right for every row of every i.
Predictor and corrector after Mehrotra; a step costs one five-banded factorisation and two sweeps.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motion.timing.banded import Banded
from motion.timing.slices import Work

Array = NDArray[np.float64]
STEPS = 40
GAP = 2e-5  # of the value: accuracy of the optimum
INSIDE = 0.9  # of the way to the nearest row, where the search begins
BACK = 0.995  # share of the way to the border


@dataclass(frozen=True)
class Rows:
    """All (rows,), in the order of their i: coefficients of x_(i-1), x_i, x_(i+1); ends: those of neighbours that do not exist are 0.
    counts: (n,) rows of each i, none has none."""

    minus: Array
    centre: Array
    plus: Array
    right: Array
    counts: NDArray[np.intp]

    @cached_property
    def _begins(self) -> NDArray[np.intp]:
        return np.concatenate([[0], np.cumsum(self.counts[:-1])])

    def times(self, x: Array) -> Array:
        """A x, (rows,)."""
        before, after = np.concatenate([x[:1], x[:-1]]), np.concatenate([x[1:], x[-1:]])
        return np.asarray(
            self.centre * np.repeat(x, self.counts)
            + self.minus * np.repeat(before, self.counts)
            + self.plus * np.repeat(after, self.counts)
        )

    def transposed(self, z: Array) -> Array:
        """A' z, (n,)."""
        result = self._summed(self.centre * z)
        result[:-1] += self._summed(self.minus * z)[1:]
        result[1:] += self._summed(self.plus * z)[:-1]
        return result

    def normal(self, d: Array) -> tuple[Array, Array, Array]:
        """Return the diagonal and its two neighbouring bands of A' diag(d) A."""
        plus, minus = d * self.plus, d * self.minus
        diagonal = self._summed(d * self.centre * self.centre)
        diagonal[1:] += self._summed(plus * self.plus)[:-1]
        diagonal[:-1] += self._summed(minus * self.minus)[1:]
        near = self._summed(plus * self.centre)[:-1] + self._summed(minus * self.centre)[1:]
        return diagonal, near, self._summed(plus * self.minus)[1:-1]

    def _summed(self, values: Array) -> Array:
        """(n,) of the rows of each i."""
        return np.asarray(np.add.reduceat(values, self._begins))


def fastest(rows: Rows, share: Array, begin: Array, held: int = 0, ending: int = 0) -> Work[Array]:
    """x > 0, (n,).  right > 0; begin: (n,) > 0, need not meet the rows; held: leading x that stay as they begin.  A slice is a step."""
    most = float(np.max(rows.times(begin) / rows.right))
    x = begin * min(1.0, INSIDE / most)
    fixed = np.r_[0:held, len(x) - ending : len(x)]
    x[fixed] = begin[fixed]
    stay = np.zeros(len(x), dtype=bool)
    stay[fixed] = True
    y = np.maximum(rows.right - rows.times(x), 1e-3)
    z = 1.0 / (y.size * y)
    for _ in range(STEPS):
        yield
        gradient, curve = -0.5 * share / x**1.5, 0.75 * share / x**2.5
        lack = rows.times(x) + y - rows.right
        mu = _sum(y, z) / y.size
        if mu * y.size < GAP and float(np.max(np.abs(lack))) < 1e-7:
            break
        weight = z / y
        diagonal, near, far = rows.normal(weight)
        diagonal += curve
        diagonal[fixed] = 1.0
        for band, apart in ((near, 1), (far, 2)):
            band[stay[apart:] | stay[:-apart]] = 0.0
        with np.errstate(all="ignore"):  # of rows that contradict each other: their search goes to infinity
            system = Banded(diagonal, near, far)
            target = weight * lack

            base = _Base(rows, system, gradient, lack, target, weight, z, fixed)
            _, dy, dz = base.directions(np.zeros_like(y))
            far_y, far_z = _room(y, dy, 1.0), _room(z, dz, 1.0)
            after = _sum(y + far_y * dy, z + far_z * dz) / y.size
            sigma = min((after / mu) ** 3, 1.0)
            dx, dy, dz = base.directions((sigma * mu - dy * dz) / y)
        if not np.isfinite(dx).all():
            break
        go, go_z = min(_room(y, dy, BACK), _room(x, dx, 0.9)), _room(z, dz, BACK)
        x, y, z = x + go * dx, y + go * dy, z + go_z * dz
    return x


@dataclass(frozen=True)
class _Base:
    """One step's equations."""

    rows: Rows
    system: Banded
    gradient: Array
    lack: Array
    target: Array
    weight: Array
    z: Array
    fixed: NDArray[np.intp]

    def directions(self, centred: Array) -> tuple[Array, Array, Array]:
        """(dx, dy, dz) towards slack times multiplier = centred times slack."""
        right = -self.gradient - self.rows.transposed(centred + self.target)
        right[self.fixed] = 0.0
        dx = self.system.solve(right)
        dy = -self.lack - self.rows.times(dx)
        return dx, dy, centred - self.z - self.weight * dy


def _sum(one: Array, two: Array) -> float:
    """Of all products; np.vdot would wake a thread on every core for so little, and wait for the last of them."""
    return float(np.einsum("i,i->", one, two))


def _room(value: Array, step: Array, share: float) -> float:
    """How much of the step keeps `value` positive, at most 1."""
    low = float(np.min(step / value))
    return min(1.0, -share / low) if low < 0.0 else 1.0
