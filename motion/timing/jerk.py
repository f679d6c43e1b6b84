"""Jerk-limited laws along any smooth path, near the time optimum.

The law of the moment, s(t) on an even time grid, is warped by beta(t) = (dt_old / dt_new)^2 > 0.  With the differences of the
axis positions on that grid (q', q'', q''' by time, what a judge of the set values sees) the rows are

    |q'|^2 beta <= v^2,   |q'' beta + q' beta'/2| <= a,   |(q''' beta + 3/2 q'' beta' + 1/2 q' beta'') sqrt(beta)| <= j

and the time to shorten is sum h / sqrt(beta).  Newton's method on this sum plus a barrier for the rows (relaxed: a parabola
beyond the limit, so that a law that breaks limits may be the start) needs a five-banded system a step.  After each round the law
is put on a new even grid, the barrier is lowered, and beta tends to 1: then differences and limits meet as the judge measures them.
"""

import math

import numpy as np
from numpy.typing import NDArray

from motion.paths.joints import JointPath
from motion.timing import topp
from motion.timing.interior import Rows, fastest
from motion.timing.law import POSSIBLE_S, Law, check_seconds
from motion.timing.limits import LawLimits, speed_squares
from motion.timing.needed import needed
from motion.timing.pulls import pull_shares, sided
from motion.timing.slices import Work, whole

Array = NDArray[np.float64]
Excess = tuple[Array, Array, Array]

GRID, MOST_GRID, GRID_S = 1500, 15_000, 2e-3  # intervals of s for the first guess; more where one would last longer than this
QUICK_GRID, MOST_QUICK, A_PIECE = 200, 2000, 8  # of an estimate; A_PIECE for the shortest polynomial of the path, if there is room
STEP, FEWEST, MOST = 0.7e-3, 300, 15_000  # s and number of the intervals in time: longer runs belong into windows (timing.splice)
ROUNDS = 3
JERK_USED = 1.02  # of the jerk limit, in the rows: what the differences at 1 ms show stays below JERK_GOOD (AX-386)
TOUCH = 0.9999  # of the speed limit: differences of rounded positions stay below it
WARP = 2.0  # largest ratio of a round's beta to that of the round before
SETTLED = 1e-4  # change of the duration below which no further round is tried
JUDGE_S = 1e-3  # period at which the set values are judged
ACCEL_GOOD, JERK_GOOD = 1.012, 1.044  # shares of the limits at that period; beyond them the place is planned again with less
PHASES = (0.0, 0.25, 0.5, 0.75)  # of the period: where its samples fall; between two of them jerk was 0.01 more
HAIR = 1e-6  # two differences of rounded positions
REPAIRS, SLOWER = 3, 12
THERE, NEAR_S, FEW = 6, 0.25, 64  # rounds limited to the places, seconds before and after each, most places for such rounds
WORTH = 1.03  # times the duration: accepted to keep the programmed speed in all other places
LONGER = 4.0  # times the first law: it stops at a bend that the grid does not resolve, and slowing the first one is quicker
A_SLICE = 20_000  # samples that are looked at in one go
AROUND = 4  # periods on both sides of such a place


def jerk_limited(path: JointPath, limits: LawLimits, start: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Law:
    """As jerk_limited_work, at once."""
    return whole(jerk_limited_work(path, limits, start))


def jerk_limited_work(
    path: JointPath, limits: LawLimits, start: tuple[float, float, float] = (0.0, 0.0, 0.0), begin: Law | None = None
) -> Work[Law]:
    """Plan from (s, sdot, sddot) to rest at the end of the path; begin: a law from rest at which the search begins.  Raise MotionError
    where the path cannot be run at all.

    Works in slices, because making a law lasts about as long as running it.  The law is judged at 1 ms by the differences of the axis
    positions; where acceleration or jerk are too high it is planned again with lower limits there, and if that does not help it is slowed
    a little as a whole.
    """
    guess = begin.on_grid(_points(begin.duration)) if begin is not None else (yield from _guess(path, limits, start))
    yield
    tight, slow = np.ones(len(guess.s)), np.ones(len(guess.s))  # shares of the limits of jerk and of speed, point by point
    law, found, first, least, beta = guess, None, 0.0, math.inf, np.ones(len(guess.s))
    for _ in range(REPAIRS):
        beta = yield from _warp(path, limits, guess, beta, tight, slow)
        yield
        made = guess.warped(beta, path.length).calmed()
        if made.duration > LONGER * (first or made.duration):
            break
        first = first or made.duration
        at, excess, fast = yield from _excess(path, limits, made)
        worst = max(float(np.cbrt(np.max(excess))), float(np.max(fast)))
        few = made.duration > 4 * NEAR_S and int(np.count_nonzero(np.maximum(excess, fast) > 1.0)) <= FEW
        mend = min(worst, WORTH) if few else worst  # a few places are slowed alone
        value = made.duration * max(mend, 1.0)  # a round with lower limits may cost more than it mends
        if not made.at_rest or value < (least if worst > 1.0 else WORTH * least):
            law, found, least = made, (at, excess, fast), value
        if worst <= 1.0:
            break
        for place in np.flatnonzero(np.maximum(excess, fast) > 1.0):
            near = np.abs(guess.s - at[place, 1]) <= at[place, 2] - at[place, 1]
            tight[near] *= 0.97 / max(float(excess[place]), 0.97)
            slow[near] = np.minimum(slow[near], 0.9999 / max(float(fast[place]), 1.0))
    return (yield from _slowed(path, limits, law, found))


def estimate(path: JointPath, limits: LawLimits) -> float:
    """Estimate the seconds of a law of this path at a fiftieth of the cost: within two per cent where nothing slows it on its way, and
    mostly too low where corners do.  A corner smaller than the ramps is as slow as its change of curvature requires.
    """
    shortest = float(np.min(np.diff(path.knots)))
    count = int(min(max(A_PIECE * path.length / shortest, QUICK_GRID), MOST_QUICK))
    second, ramp = whole(_second(path, limits, (0.0, 0.0, 0.0), count, bends=True)).duration, _ramp(limits)
    if second < 8.0**0.5 * ramp:  # it ends before full acceleration is there
        return float(np.cbrt(8.0 * ramp * second**2))
    return ramp + math.hypot(ramp, second)


def _slowed(path: JointPath, limits: LawLimits, law: Law, found: Excess | None = None) -> Work[Law]:
    """Slow the law until the set values are good: a long law around the bad places, as long as that is quicker than slowing all of it; one
    with many or recurring places as a whole.  found: known excess of the law.  A moving start cannot be slowed and stays.
    """
    around, quickest = True, law
    for k in range(SLOWER):
        at, excess, fast = found or (yield from _excess(path, limits, law))
        found, much = None, np.maximum(np.cbrt(excess), fast)
        worst = float(np.max(much))
        if worst <= 1.0 or not law.at_rest:
            break
        slower, bad = law.slower(1.001 * worst), much > 1.0
        quickest = slower if not k or not around or slower.duration < quickest.duration else quickest
        around = around and k < THERE and law.duration > 4 * NEAR_S and int(np.count_nonzero(bad)) <= FEW
        there = _slower_there(law, at[bad, 1], 1.001 * much[bad], path.length) if around else quickest
        around = there is not quickest and there.duration < WORTH * quickest.duration
        law = there if around else quickest
    return law


def _slower_there(law: Law, places: Array, factors: Array, length: float) -> Law:
    """Return the law slowed by a factor within NEAR_S of each place (s), and smoothly less up to twice as far."""
    t = law.step * np.arange(len(law.s))
    more = np.zeros(len(t))
    for moment, factor in zip(np.interp(places, law.s, t), factors, strict=True):
        share = 0.5 + 0.5 * np.cos(np.pi * np.clip(np.abs(t - moment) / NEAR_S - 1.0, 0.0, 1.0))
        np.maximum(more, share * (float(factor) - 1.0), out=more)
    return law.warped((1.0 + more) ** -2, length).calmed()


def shares(path: JointPath, limits: LawLimits, law: Law, period_s: float = JUDGE_S) -> tuple[float, float, float]:
    """Largest speed, acceleration and jerk as shares of their limits, from differences of the set values of the axes."""
    parts = differences(path, limits, _places(law, period_s), period_s)
    speed, accel, jerk = (float(np.max(part)) for part in parts)
    return speed, accel, jerk


def slowing(path: JointPath, limits: LawLimits, law: Law) -> float:
    """Return the factor on the law's duration that keeps the limits; 1.0: it keeps them."""
    speed, accel, jerk = shares(path, limits, law)
    excess = max(speed, math.sqrt(accel), jerk ** (1 / 3))
    return excess if excess > 1.0 + HAIR else 1.0


def _places(law: Law, period_s: float, phase: float = 0.0) -> Array:
    """s of the samples; a moving start is not judged before its third sample."""
    s = law.at(np.arange(phase * period_s, check_seconds(law.duration) + 4 * period_s, period_s))
    return np.concatenate([np.full(3 if law.at_rest else 0, law.s[0]), s])


def differences(path: JointPath, limits: LawLimits, s: Array, period_s: float) -> list[Array]:
    """Shares of speed, acceleration and jerk at each sample."""
    q = path.at(s)
    most, _, jolt = limits.at(s)
    speed, jerk = (np.abs(np.diff(q, order, axis=0)) / period_s**order / rows[order:] for order, rows in ((1, most), (3, jolt)))
    accel = pull_shares(q, period_s, limits.pulls(s)[:, 2:])
    return [np.max(part, axis=1) for part in (speed, accel, jerk)]


def _excess(path: JointPath, limits: LawLimits, law: Law) -> Work[Excess]:
    """Return places (from, at, to in s), the excess of acceleration or jerk there, and that of speed, for every phase of the samples.  A
    slice is a number of samples: a motion of minutes has some hundred thousand per phase.
    """
    places, much, fast = [], [], []
    for phase in PHASES if law.at_rest else (0.0,):
        s = _places(law, JUDGE_S, phase)
        for first in range(0, len(s) - 3, A_SLICE):
            speed, accel, jerk = differences(path, limits, s[first : first + A_SLICE + 3], JUDGE_S)
            index = np.arange(len(jerk)) + first + 2
            places.append(np.stack([s[np.maximum(index - AROUND, 0)], s[index], s[np.minimum(index + AROUND, len(s) - 1)]], axis=1))
            much.append(np.maximum(jerk / JERK_GOOD, accel[1:] / ACCEL_GOOD))
            fast.append(speed[2:])
            yield
    return np.concatenate(places), np.concatenate(much), np.concatenate(fast)


def _guess(path: JointPath, limits: LawLimits, start: tuple[float, float, float]) -> Work[Law]:
    """Return the acceleration-limited law averaged over the time of a full ramp: it violates limits a little, which the rounds correct."""
    second = yield from _second(path, limits, start, GRID)
    yield
    if check_seconds(second.duration, POSSIBLE_S) > GRID * GRID_S:  # least duration: a longer one is not worth minutes of computing
        second = yield from _second(path, limits, start, int(min(second.duration / GRID_S, MOST_GRID)))
        yield
    ramp = _ramp(limits)
    duration = second.duration + ramp
    count = _points(duration)
    t = np.linspace(0.0, duration, count + 1)
    smooth = np.minimum(start[0] + second.smoothed(t, ramp), path.length)
    smooth[-1] = path.length
    return Law.sampled(smooth, float(t[1]), start)


def _points(duration: float) -> int:
    """Return the number of intervals of a law of this duration in seconds."""
    return int(min(max(duration / STEP, FEWEST), MOST))


def _second(path: JointPath, limits: LawLimits, start: tuple[float, float, float], count: int, *, bends: bool = False) -> Work[topp.Topp]:
    """Return the acceleration-limited law on `count` intervals; bends: not faster than the jerk of the path's own bends allows at steady
    speed.
    """
    s = np.linspace(start[0], path.length, count + 1)
    jerk = limits.at(s)[2]
    most = speed_squares(path, s, limits)
    if bends:
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.nan_to_num(np.abs(path.at(s, 3)) / jerk)
            most = np.minimum(most, np.max(shares, axis=1) ** (-2 / 3))
    return (yield from topp.solve_work(path.at(s, 1), path.at(s, 2), float(s[1] - s[0]), limits.pulls(s), most, start[1] ** 2))


def _ramp(limits: LawLimits) -> float:
    """Seconds from no to full acceleration of the slowest column."""
    finite = np.isfinite(limits.accel) & np.isfinite(limits.jerk)
    return float(np.max(limits.accel[finite] / limits.jerk[finite])) if np.any(finite) else 0.0


def law_rows(path: JointPath, limits: LawLimits, law: Law, beta: Array, tight: Array, slow: Array) -> Rows:
    """Return the limits of beta on the law's grid."""
    h, known = law.step, beta[:, None]
    padded = law.padded(2)
    q = path.at(padded) if law.at_rest else _extended(path, padded)
    first, second = (q[3:-1] - q[1:-3]) / (2 * h), (q[3:-1] - 2 * q[2:-2] + q[1:-3]) / h**2
    thirds = np.diff(q, 3, axis=0) / h**3
    speed, _, jerk = limits.at(law.s)
    speed, jerk = TOUCH * slow[:, None] * speed, JERK_USED * jerk * tight[:, None]
    some = np.any(np.isfinite(limits.speed)[None, :] | np.isfinite(speed), axis=0)
    highest, lowest = sided(first, limits.pulls(law.s))
    first, second, thirds, speed, highest, lowest, jerk = (part[:, some] for part in (first, second, thirds, speed, highest, lowest, jerk))
    none, unity = np.zeros_like(first), np.ones_like(first)
    fastest_of_all = np.argmax(np.abs(first / speed), axis=1)[:, None] == np.arange(first.shape[1])
    blocks = [(none, (first / speed) ** 2, none, unity, fastest_of_all)]
    both = [(0.25 * sign * first / most / h, sign * second / most) for sign, most in ((1.0, highest), (-1.0, lowest))]
    counts = unity > 0.0 if limits.lopsided else needed(np.stack(both[0], axis=2))
    blocks += [(-a1, a2, a1, unity, counts) for a1, a2 in both]
    side, middle = 0.75 * second / jerk / h, 0.5 * first / jerk / h**2
    flat, steep = 1.5 / np.sqrt(known) * unity, 0.5 / known**1.5  # tangent of 1 / sqrt(beta) at the beta of the round before
    for third in (thirds[:-1] / jerk, thirds[1:] / jerk):
        counts = needed(np.stack([middle, side, third], axis=2))
        for sign in (1.0, -1.0):
            blocks.append((sign * (middle - side), sign * (third - 2 * middle) + steep, sign * (middle + side), flat, counts))
    one = np.ones_like(known)
    blocks.append((0.0 * one, one, 0.0 * one, WARP * known, one > 0.0))
    minus, centre, plus, right, count = (np.concatenate([block[k] for block in blocks], axis=1) for k in range(5))
    centre[0] += minus[0]
    centre[-1] += plus[-1]
    minus[0] = plus[-1] = 0.0
    return Rows(minus[count], centre[count], plus[count], right[count], np.sum(count, axis=1))


def _extended(path: JointPath, s: Array) -> Array:
    """Like path.at, and before the path's own start along its tangent."""
    before = np.minimum(s, 0.0)[:, None]
    return path.at(s) + before * path.at(np.zeros(1), 1)


def _warp(path: JointPath, limits: LawLimits, law: Law, near: Array, tight: Array, slow: Array) -> Work[Array]:
    """beta on the law's grid; near: one that is not far from it, where the first search begins."""
    n = len(law.s)
    share = np.full(n, 1.0 / (n - 1))
    share[0] = share[-1] = 0.5 / (n - 1)
    beta, begin, value = np.ones(n), np.minimum(near, WARP), np.inf
    for _ in range(ROUNDS):
        beta = begin = yield from fastest(law_rows(path, limits, law, beta, tight, slow), share, begin, 0 if law.at_rest else 2)
        before, value = value, float(np.sum(share / np.sqrt(beta)))
        if abs(before - value) < SETTLED * value:
            break
    return beta
