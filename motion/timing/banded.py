"""Symmetric positive definite systems with two bands next to the diagonal, by cyclic reduction of 2 x 2 blocks.

The blocks that do not touch each other are eliminated all at once, which leaves a system of half the size of the same shape; a dozen
blocks are left to a dense solver.  Each halving is a handful of numpy operations: a sweep row by row would be six times as slow.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
DENSE = 16  # blocks and one that are left to the dense solver, at most


class _Halving(NamedTuple):
    """Eliminated blocks, (2, 2, k): their inverse, and its product with their coupling to the kept block after and before them."""

    inverse: Array
    behind: Array
    before: Array


class Banded:
    """Two bands: (i, i + 1) and (i, i + 2)."""

    def __init__(self, diagonal: Array, near: Array, far: Array) -> None:
        self._count, halvings = len(diagonal), 0
        blocks = (self._count + 3) // 2  # and one: a halving leaves half of it
        while blocks > DENSE:
            blocks, halvings = (blocks + 1) // 2, halvings + 1
        self._blocks = (blocks << halvings) - 1
        main, next_ = self._as_blocks(diagonal, near, far)
        self._halvings: list[_Halving] = []
        for _ in range(halvings):
            main, next_ = self._halved(main, next_)
        self._dense = _dense(main, next_)

    def _as_blocks(self, diagonal: Array, near: Array, far: Array) -> tuple[Array, Array]:
        """(2, 2, blocks) on the diagonal and (2, 2, blocks - 1) right of it; padding after the system is 1 on the diagonal."""
        padded = np.zeros((3, 2 * self._blocks))
        padded[0] = 1.0
        for row, band in zip(padded, (diagonal, near, far), strict=True):
            row[: len(band)] = band
        d, e, f = padded
        main = np.array([[d[::2], e[::2]], [e[::2], d[1::2]]])
        next_ = np.array([[f[:-2:2], np.zeros(self._blocks - 1)], [e[1:-2:2], f[1:-2:2]]])
        return main, next_

    def _halved(self, main: Array, next_: Array) -> tuple[Array, Array]:
        """Every other block, from the first one on, is taken out."""
        (a, b), (_, d) = main[:, :, ::2]
        inverse = np.array([[d, -b], [-b, a]]) / (a * d - b * b)
        from_before, to_behind = next_[:, :, ::2], next_[:, :, 1::2]
        behind = _product(inverse[:, :, :-1], from_before)
        before = _product(inverse[:, :, 1:], to_behind.swapaxes(0, 1))
        self._halvings.append(_Halving(inverse, behind, before))
        kept = main[:, :, 1::2] - _product(from_before.swapaxes(0, 1), behind) - _product(to_behind, before)
        return kept, -_product(to_behind[:, :, :-1], behind[:, :, 1:])

    def solve(self, right: Array) -> Array:
        """x of A x = right; of a singular system not all are finite."""
        b = np.zeros(2 * self._blocks)
        b[: self._count] = right
        now, out = b.reshape(-1, 2).T, []
        for _, behind, before in self._halvings:
            taken = now[:, ::2]
            out.append(taken)
            now = now[:, 1::2] - _applied(behind.swapaxes(0, 1), taken[:, :-1]) - _applied(before.swapaxes(0, 1), taken[:, 1:])
        try:
            x = np.asarray(np.linalg.solve(self._dense, now.T.ravel()), dtype=np.float64).reshape(-1, 2).T
        except np.linalg.LinAlgError:
            return np.full(self._count, np.nan)
        for (inverse, behind, before), taken in zip(reversed(self._halvings), reversed(out), strict=True):
            found = np.empty((2, 2 * x.shape[1] + 1))
            found[:, 1::2], missing = x, _applied(inverse, taken)
            missing[:, :-1] -= _applied(behind, x)
            missing[:, 1:] -= _applied(before, x)
            found[:, ::2] = missing
            x = found
        return np.asarray(x.T.ravel()[: self._count])


def _dense(main: Array, next_: Array) -> Array:
    """The blocks as one matrix."""
    count = main.shape[2]
    whole, at = np.zeros((count, 2, count, 2)), np.arange(count)
    whole[at, :, at] = main.transpose(2, 0, 1)
    whole[at[:-1], :, at[1:]] = next_.transpose(2, 0, 1)
    whole[at[1:], :, at[:-1]] = next_.transpose(2, 1, 0)
    return whole.reshape(2 * count, 2 * count)


def _product(one: Array, two: Array) -> Array:
    """2 x 2 by 2 x 2, (2, 2, k)."""
    return np.asarray(one[:, 0, None] * two[None, 0] + one[:, 1, None] * two[None, 1])


def _applied(one: Array, two: Array) -> Array:
    """2 x 2 by a pair, (2, k)."""
    return np.asarray(one[:, 0] * two[0] + one[:, 1] * two[1])
