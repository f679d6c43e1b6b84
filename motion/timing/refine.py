"""A quick law made faster: over corners it comes near the optimum, at a tenth of what a law from scratch costs.

It is warped (motion.timing.jerk) from its present form in few rounds.  Where it begins while the axes move, place, speed and acceleration
there are kept; after its first seconds it is unchanged.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motion.paths.joints import JointPath
from motion.timing.interior import Rows, fastest
from motion.timing.jerk import ACCEL_GOOD, AROUND, JERK_GOOD, JUDGE_S, PHASES, differences, law_rows
from motion.timing.law import Law
from motion.timing.limits import LawLimits
from motion.timing.slices import Work

Array = NDArray[np.float64]
STEP_S, FEWEST = 0.7e-3, 60  # s and number of its intervals
HELD, EDGE, AFTER = 2, 16, 8  # points that stay: at a moving start, and at the end of its first seconds; of these, the last ones
SHORTEST_S = 0.05  # remainder after its first seconds: a shorter one is refined with them
NEAR, HAIR, MORE = 30, 1.002, 1.03  # points after a moving start where the law is kept, and its largest excess over the limits
ROUNDS = 4
USED, LESS = 0.975, 0.99  # of the jerk in the rows; and factor on the remainder where it was too high
FAIR = 1.005  # times too much that is left as it is
FASTER = 10  # weight of an excess over a speed
PHASE = len(PHASES)
PAST = 3 * PHASE  # samples before the start that are judged with it
LONGER = 1.1  # times as long as before: the rows contradict each other


def refined_work(path: JointPath, limits: LawLimits, law: Law, seconds: float, past: Array | None = None) -> Work[Law | None]:
    """Its first seconds faster, and within the limits; None where that is not found.  It may break limits itself, but not where it begins.

    past: of a moving start, s before it (past_of).
    """
    before, open_end = np.full(PAST, law.s[0]) if past is None else past, seconds < law.duration - SHORTEST_S
    now = _first(law, seconds) if open_end else law.on_grid(max(round(law.duration / STEP_S), FEWEST))
    now, end = replace(now, start=law.start), now.duration
    tight, best, least = np.full(len(now.s), USED), None, FAIR
    for k in range(ROUNDS):
        beta = yield from _warp(path, limits, now, tight, open_end)
        made = now.warped(beta, float(now.s[-1])).calmed()
        if made.duration > LONGER * end:
            break
        yield
        around, much = _judged(path, limits, made, before, open_end)
        yield
        worst = float(much.max())
        if worst <= least:
            best, least = made, max(worst, 1.0)
        if k and worst <= 1.0:
            break
        for n in np.flatnonzero(much > 1.0):
            near = (now.s >= around[0][n]) & (now.s <= around[1][n])
            tight[near] = np.minimum(tight[near], LESS * tight[near] / float(much[n]))
        tight, now = np.interp(made.s, now.s, tight), made
    return _joined(best, law, end) if open_end and best is not None else best


def _first(law: Law, seconds: float) -> Law:
    """Its first seconds, as if it went on beyond them."""
    t: Array = STEP_S * np.arange(round(seconds / STEP_S) + AFTER + 1.0)
    part = Law.sampled(law.at(t), STEP_S, law.start)
    return Law(part.s[:-AFTER], part.speed[:-AFTER], part.accel[:-AFTER], STEP_S)


def _joined(made: Law, law: Law, end: float) -> Law:
    """Return the law made from another up to its time `end`, followed by the remainder: both agree over the last points."""
    t: Array = made.step * np.arange(math.ceil((law.duration - end + made.duration) / made.step) + 1.0)
    s = np.where(t < made.duration - AFTER * made.step, made.at(t), law.at(end - made.duration + t))
    return Law.sampled(s, made.step, law.start)


def past_of(law: Law, tau: float) -> Array:
    """s of a law just before tau."""
    t = tau + JUDGE_S * np.arange(-PAST, 0) / PHASE
    back = np.minimum(t, 0.0)
    return np.asarray(law.at(t) + law.start[1] * back + 0.5 * law.start[2] * back**2)


def _warp(path: JointPath, limits: LawLimits, law: Law, tight: Array, open_end: bool) -> Work[Array]:
    """beta on the law's grid."""
    one = np.ones(len(law.s))
    rows = law_rows(path, limits, law, one, tight, one)
    begin, end = (0 if law.at_rest else HELD), (EDGE if open_end else 0)
    return (yield from fastest(_loose(rows, len(one), begin, end), one / len(one), one, begin, end))


def _loose(rows: Rows, count: int, begin: int, end: int) -> Rows:
    """Loosen rows of fixed points, which are kept anyway, and rows near a moving start, where the law may continue as it is."""
    at, least = np.repeat(np.arange(count), rows.counts), rows.times(np.ones(count))
    fixed, near = (at < begin - 1) | (at > count - end), at < (NEAR if begin else 0)
    right = np.where(near, np.clip(HAIR * least, rows.right, MORE * rows.right), rows.right)
    return replace(rows, right=np.where(fixed, np.maximum(right, 1.1 * least + 0.1), right))


def _judged(path: JointPath, limits: LawLimits, law: Law, past: Array, open_end: bool) -> tuple[tuple[Array, Array], Array]:
    """(from, to) in s around each sample, and how many times too much is asked for there, wherever samples fall."""
    begins, ends, much = [], [], []
    last = law.duration + (-EDGE * law.step if open_end else 4 * JUDGE_S)
    for phase in PHASES:
        t = JUDGE_S * (np.arange(-3.0, last / JUDGE_S) + phase)
        s = law.at(t)
        s[:3] = past[int(PHASE * phase) :: PHASE][:3]
        speed, accel, jerk = differences(path, limits, s, JUDGE_S)
        index = np.arange(len(jerk)) + 2
        begins.append(s[np.maximum(index - AROUND, 0)])
        ends.append(s[np.minimum(index + AROUND, len(s) - 1)])
        fast = speed[2:] + (FASTER - 1) * np.maximum(speed[2:] - 1.0, 0.0)
        much.append(np.max([jerk / JERK_GOOD, accel[1:] / ACCEL_GOOD, fast], axis=0))
    return (np.concatenate(begins), np.concatenate(ends)), np.concatenate(much)
