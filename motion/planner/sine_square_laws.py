"""Laws of blocks with the sine-square slope (AX-575): one block from rest to rest, or a row of blocks with block slope, whose laws are
added as they were when its curve was made.

One speed and two ramps serve the entire block: its slowest place sets them.  Where a curve adds to the acceleration or the jerk of an axis
the law is stretched in time, which leaves its shape.
"""

import math
from itertools import pairwise

import numpy as np

from motion.planner.runs import Run
from motion.planner.stretch import Kind
from motion.program.blocks import Shape
from motion.program.slopes import Clock
from motion.timing.jerk import slowing
from motion.timing.law import Law, check_seconds
from motion.timing.sine_square import STEP_S, sine_square

LOOKS = 8  # at each quintic of the path
LEAST_LOOKS = 200
SLOWER = 8  # times at most


def shaped_law(run: Run) -> Law | None:
    """None: no sine-square slope is asked for, or the row passes corners that no block slope made."""
    sources = [stretch.source for stretch in run.stretches]
    if any(source.shape is not Shape.SIN2 or source.pace.time is not None for source in sources):
        return None
    if any(stretch.kind is Kind.CORNER for stretch in run.stretches):
        law = _added(run)
    elif all(one.block == two.block for one, two in pairwise(run.stretches)):
        law = _alone(run)
    else:
        law = None
    if law is None:
        return None
    for _ in range(SLOWER):
        slower = slowing(run.path, run.limits, law)
        if slower == 1.0:
            break
        law = law.slower(slower)  # its samples fall elsewhere now, which a swing shows
    return law


def _alone(run: Run) -> Law | None:
    """The smallest of all limits along the path, as if it were straight."""
    s = run.path.looks(max(LOOKS * len(run.path.coefficients), LEAST_LOOKS))
    first = np.abs(run.path.at(s, 1))
    top, _, jolt = run.limits.at(s)
    with np.errstate(divide="ignore"):
        speed, accel, decel, jerk = (
            float(np.min(np.where(first > 1e-12, rows / np.maximum(first, 1e-12), np.inf))) for rows in (top, *run.limits.pulls(s), jolt)
        )
    if not all(map(math.isfinite, (speed, accel, decel, jerk))):
        return None
    return sine_square(run.path.length, speed, accel, jerk, decel).law()


def _added(run: Run) -> Law | None:
    """Return the law of successive blocks and, between them, of the time in which both run, as in slopes.frozen.

    None: the row begins or ends within a block, because its beginning was run before the rest was known: no block's own ramp begins there.
    """
    if run.stretches[0].share[0] > 0.0 or run.stretches[-1].share[1] < 1.0:
        return None
    clocks: list[Clock] = []
    for stretch in run.stretches:
        if stretch.clock is None:
            return None
        clocks.append(stretch.clock)
    ends = np.cumsum([clock.duration for clock in clocks])
    count = max(math.ceil(check_seconds(float(ends[-1])) / STEP_S), 2)
    times = np.linspace(0.0, float(ends[-1]), count + 1)
    index = np.minimum(np.searchsorted(ends, times, side="right"), len(clocks) - 1)
    s = np.zeros(count + 1)
    for k, (start, clock) in enumerate(zip(run.starts, clocks, strict=True)):
        here = index == k
        s[here] = start + clock.at(times[here] - (float(ends[k]) - clock.duration))
    s[-1] = run.path.length
    return Law.sampled(np.maximum.accumulate(np.minimum(s, run.path.length)), float(ends[-1]) / count)
