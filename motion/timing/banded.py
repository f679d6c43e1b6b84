"""Symmetric positive definite systems with few bands beside the diagonal: L D L' without pivots, in one sweep."""

from collections.abc import Sequence


class Banded:
    """Two bands: (i, i + 1) and (i, i + 2)."""

    def __init__(self, diagonal: Sequence[float], near: Sequence[float], far: Sequence[float]) -> None:
        n = len(diagonal)
        self._near, self._far = [0.0] * n, [0.0] * n
        self._pivots = [0.0] * n
        e1 = f1 = f2 = d1 = d2 = 0.0  # one and two rows up
        for i in range(n):
            pivot = diagonal[i] - e1 * e1 * d1 - f2 * f2 * d2
            e0 = (near[i] - f1 * e1 * d1) / pivot if i < n - 1 else 0.0
            f0 = far[i] / pivot if i < n - 2 else 0.0
            self._pivots[i], self._near[i], self._far[i] = pivot, e0, f0
            f2, d2 = f1, d1
            e1, f1, d1 = e0, f0, pivot

    def solve(self, right: Sequence[float]) -> list[float]:
        """x of A x = right."""
        z: list[float] = []
        z1 = z2 = e1 = f1 = f2 = 0.0
        for value, e0, f0 in zip(right, self._near, self._far, strict=True):
            z0 = value - e1 * z1 - f2 * z2
            z.append(z0)
            z1, z2, e1, f1, f2 = z0, z1, e0, f0, f1
        x1 = x2 = 0.0
        for i in range(len(z) - 1, -1, -1):
            x0 = z[i] / self._pivots[i] - self._near[i] * x1 - self._far[i] * x2
            z[i] = x0
            x1, x2 = x0, x1
        return z
