"""Continuation of a law over a path that has grown: the tail that braked for the old end is replaced while the axes move.

A second law is planned from rest a little way back to the new end.  Both are near the optimum, so soon after the second one is up to
speed, and before the first one brakes for its end, they run at nearly the same speed: there one changes over into the other (s(t) blended
over a smooth step in time).  Where they never come close the old law stays: it ends at rest, and the path goes on from there; only motion
that is planned to the end is executed.
"""

import numpy as np
from numpy.typing import NDArray

from motion.timing.law import Law

Array = NDArray[np.float64]
RUN_UP_S = 0.25  # how far back the second law begins, in time of the first
LEAD_S = 0.04  # over which one law becomes the other
CLOSE = 0.5  # largest difference of the speeds there, as share
GRID, STRIDE = 4000, 20


def led_over(before: Law, index: int, second: Law) -> tuple[Law, float] | None:
    """From `before` at its grid point `index` to the end of `second`, both on the same path; and the s after which it is the second one.

    None: the laws do not come close after that point.
    """
    s = np.linspace(float(before.s[index]), float(before.s[-1]), GRID)
    at = _meeting(s, _squares(before, s), _squares(second, s), before)
    return None if at is None else (_led_over(before, second, index, *at), at[1] - index * before.step)


def _squares(law: Law, s: Array) -> Array:
    """sdot^2 at these places; between grid points linear in s."""
    return np.interp(s, law.s, law.speed**2)


def _meeting(s: Array, one: Array, two: Array, before: Law) -> tuple[float, float] | None:
    """The stretch of LEAD_S on which the speeds are closest: times of the first law; None where they are nowhere close."""
    speed = np.sqrt(np.maximum(one, 1e-12))
    apart = np.abs(np.sqrt(np.maximum(two, 0.0)) - speed) / speed
    times = np.interp(s, before.s, before.step * np.arange(len(before.s)))
    best, found = CLOSE, None
    for first in range(0, len(s) - 1, STRIDE):
        last = int(np.searchsorted(times, times[first] + LEAD_S))
        if last >= len(s):
            break
        worst = float(np.max(apart[first : last + 1]))
        if worst < best:
            best, found = worst, (float(times[first]), float(times[last]))
    return found


def _led_over(before: Law, second: Law, index: int, begin: float, end: float) -> Law:
    """The first law, from grid point `index`, up to `begin` (s of its own time), the second one from `end`."""
    h = before.step
    middle = np.full(1, 0.5 * (begin + end))
    low, high = 0.0, second.duration
    place = float(before.at(middle)[0])
    for _ in range(60):  # when the second law is where the first one is in the middle
        half = 0.5 * (low + high)
        low, high = (half, high) if float(second.at(np.full(1, half))[0]) < place else (low, half)
    late = low - float(middle[0])
    t = np.asarray(h * np.arange(index, int((second.duration - late) / h) + 2), dtype=np.float64)
    x = np.clip((t - begin) / (end - begin), 0.0, 1.0)
    share = x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3)
    s = (1 - share) * before.at(t) + share * second.at(t + late)
    s[-1] = second.s[-1]
    return Law.sampled(s, h, (float(before.s[index]), float(before.speed[index]), float(before.accel[index])))
