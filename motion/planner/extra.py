"""Additional axes (7 .. 24) in step with the path: their columns, put behind those of the arm."""

from collections.abc import Sequence

import numpy as np

from motion.paths.corner import hermite
from motion.paths.joints import DEGREE, JointPath

End = tuple[float, float]  # value and slope by s


def with_extra(path: JointPath, start: Sequence[End], end: Sequence[End]) -> JointPath:
    """path: of the arm alone; each additional axis goes from start to end by a quintic without bend at its ends (a straight line
    where both slopes are its own)."""
    if not start:
        return path
    rows = [hermite(path.length, (a, da, 0.0), (b, db, 0.0)) for (a, da), (b, db) in zip(start, end, strict=True)]
    count, arm = len(path.coefficients), path.axes
    table = np.zeros((count, DEGREE + 1, arm + len(rows) + 2))
    table[:, :, :arm] = path.coefficients[:, :, :arm]
    table[:, :, -2:] = path.coefficients[:, :, arm:]
    for i, knot in enumerate(path.knots[:-1]):
        for j, row in enumerate(rows):
            table[i, :, arm + j] = _about(row, float(knot))
    return JointPath(path.knots, table)


def _about(row: Sequence[float], u: float) -> list[float]:
    """Coefficients of the same polynomial about another point."""
    result = list(row)
    for i in range(DEGREE):
        for k in range(DEGREE - 1, i - 1, -1):
            result[k] += u * result[k + 1]
    return result
