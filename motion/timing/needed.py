"""Which axes' limits count at a place: those of the others follow from them.

A limit is |p x| <= 1 with as many coefficients p as the unknowns have parts.  Where one p lies between others and their opposites,
as most do when many axes share a path, its limit is met as soon as those of the others are.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
CLOSE = 1e-5  # of the largest coefficient of the place, or of the limit: tolerance of an omitted limit


def needed(points: Array, least: float = 1.0) -> NDArray[np.bool_]:
    """points: (n, m, parts) coefficients of m limits at n places; (n, m), True: it counts.  least: coefficients below it, times CLOSE,
    are noise.

    At each place as many points as there are parts are chosen, each the farthest from the span of the previous ones; an omitted point is a
    sum of them whose shares add up to at most 1.
    """
    count, _, parts = points.shape
    left = np.moveaxis(points / np.maximum(np.max(np.abs(points), axis=1, keepdims=True), least), 2, 0).copy()
    at, chosen, along = np.arange(count), [], []
    for _ in range(parts):
        squares = np.sum(left * left, axis=0)
        farthest = np.argmax(squares, axis=1)
        size = np.sqrt(squares[at, farthest])
        unit = left[:, at, farthest] / np.where(size > CLOSE, size, np.inf)
        along.append(np.einsum("pnm,pn->nm", left, unit))
        left -= along[-1] * unit[:, :, None]
        chosen.append(farthest)
    total = np.zeros_like(along[0])
    out = np.zeros(total.shape, dtype=np.bool_)
    for k in reversed(range(parts)):
        own = along[k][at, chosen[k]]
        share = along[k] / np.where(own > CLOSE, own, np.inf)[:, None]
        total += np.abs(share)
        for before in range(k):
            along[before] = along[before] - share * along[before][at, chosen[k]][:, None]
        out[at, chosen[k]] |= own > CLOSE
    return np.asarray(out | (total > 1.0 + CLOSE))
