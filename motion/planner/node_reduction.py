"""Removal of unneeded nodes of a long law: the quintics over wider intervals follow those over the narrow ones.

A law has a node about every millisecond, and a follower holds some thousand pieces (motion.execution.follower.WAITING): in a long slow
section most nodes are redundant.  AX-606.  A path begins when its last piece is in the cycle: one that ends at rest begins sooner with
fewer (AX-1460).
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
WIDEST = 32  # most intervals that one may replace
LEFT_S = 1.0  # before the end: a continued path is cut there, and an interval cannot be cut
PLACES = 8  # at which a quintic is looked at, at most
SAME, SAME_SPEED, SAME_ACCEL = 1e-9, 1e-6, 2e-4  # m or rad; per s; share of the limit of acceleration


def needed(
    times: Array, states: Array, numbers: NDArray[np.int64], accel: Array, longest: float, *, left_s: float = LEFT_S
) -> NDArray[np.intp]:
    """Places of the nodes that stay, the first and the last among them.

    states: (n, 3 x columns) position, speed, acceleration; numbers: (n,) block of the interval that begins at each node, none reaches
    over two; accel: (columns,) limits; longest: s an interval may last; left_s: s before the end in which all stay.  Intervals are put
    together in pairs, pairs of pairs ..."""
    kept = np.ones(len(times), dtype=bool)
    free = int(np.searchsorted(times, times[-1] - left_s)) if left_s else len(times)
    starts, width = np.arange(free), 1
    while len(starts) and width < WIDEST and 2 * width * float(times[1] - times[0]) <= longest:
        firsts, single = starts[starts % (2 * width) == 0], set(starts.tolist())
        both = firsts[[first + width in single for first in firsts.tolist()]]
        width *= 2
        both = both[(both + width < free) & (numbers[both] == numbers[np.minimum(both + width - 1, len(numbers) - 1)])]
        starts = both[_alike(times, states, both, width, accel)]
        for k in range(1, width):
            kept[starts + k] = False
    return np.flatnonzero(kept)


def _alike(times: Array, states: Array, starts: NDArray[np.intp], width: int, accel: Array) -> NDArray[np.bool_]:
    """Return whether one quintic over `width` intervals from each of these nodes meets the nodes between."""
    ends = starts + width
    left, right = (states[at].reshape(len(at), len(accel), 3) for at in (starts, ends))
    h = (times[ends] - times[starts])[:, None]
    a, b, c = left[:, :, 0], left[:, :, 1] * h, 0.5 * left[:, :, 2] * h * h
    gap, lean, curl = right[:, :, 0] - a - b - c, right[:, :, 1] * h - b - 2 * c, right[:, :, 2] * h * h - 2 * c
    d, e, f = 10 * gap - 4 * lean + 0.5 * curl, -15 * gap + 7 * lean - curl, 6 * gap - 3 * lean + 0.5 * curl
    fine = np.ones(len(starts), dtype=bool)
    for k in range(max(width // PLACES, 1), width, max(width // PLACES, 1)):
        there = states[starts + k].reshape(len(starts), len(accel), 3)
        u = (times[starts + k] - times[starts])[:, None] / h
        place = a + u * (b + u * (c + u * (d + u * (e + u * f))))
        speed = (b + u * (2 * c + u * (3 * d + u * (4 * e + u * 5 * f)))) / h
        bend = (2 * c + u * (6 * d + u * (12 * e + u * 20 * f))) / h**2
        for found, order, most in ((place, 0, SAME), (speed, 1, SAME_SPEED), (bend, 2, SAME_ACCEL * accel)):
            fine &= np.all(np.abs(found - there[:, :, order]) <= most, axis=1)
    return fine
