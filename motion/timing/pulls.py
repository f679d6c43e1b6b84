"""Accelerations that differ for speeding up and slowing down: what a column may do at a place follows from the direction it moves in."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def sided(slope: Array, pulls: Array) -> tuple[Array, Array]:
    """(highest, lowest as a size) acceleration of columns with this slope; pulls: (2, n, columns) speeding up, slowing down."""
    forward = slope >= 0.0
    return np.where(forward, pulls[0], pulls[1]), np.where(forward, pulls[1], pulls[0])


def pull_shares(q: Array, period_s: float, pulls: Array) -> Array:
    """Return (n - 2, columns) second differences of samples as shares of their limits; pulls: (2, n - 2, columns).  Where a column turns
    back between two samples it does both, and the larger one counts.
    """
    change = np.diff(q, axis=0)
    before, after = change[:-1], change[1:]
    allowed = np.where(np.abs(after) >= np.abs(before), pulls[0], pulls[1])
    allowed = np.where(before * after < 0.0, np.maximum(pulls[0], pulls[1]), allowed)
    return np.asarray(np.abs(after - before) / period_s**2 / allowed)
