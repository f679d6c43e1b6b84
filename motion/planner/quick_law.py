"""A quick law for paths that grow while they are run: acceleration-limited, then smoothed in time.

The raw law is the fastest one under speeds and 9/10 of the accelerations (TOPP); the law itself is its mean over the last w seconds,
which turns steps of acceleration into ramps of jerk 2 a / w at most along a straight path.  A mean of the past does not change
when only the future is planned anew: so a tail joins the part before it exactly in position, speed and acceleration, whatever the path
does.  The mean is behind the raw law by up to half the way made in w, so the raw law keeps a speed limit that far before and after its
place; then the mean keeps it.  Where curvature makes more of it than the axes may do, speed is lowered there and the law is made again.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.paths.joints import JointPath
from motion.timing import topp
from motion.timing.law import Law, check_seconds
from motion.timing.limits import LawLimits, speed_squares
from motion.timing.pulls import pull_shares
from motion.timing.slices import Work, whole

Array = NDArray[np.float64]
STEP_S = 1e-3
SHARE = 0.9  # of the accelerations
WIDTH = 1.2  # times acceleration / jerk of the slowest axis (AX-961)
POINTS = (200, 1600)  # of the grid over s
A_STRETCH = 8  # places for each polynomial of the path, if there is room
FINER = 4  # looks at the tool in an interval of the grid
STENCIL = 4  # samples after a cut that must not change: speed and acceleration are differences over them
ACCEL_GOOD, JERK_GOOD = 1.015, 1.045
ROUNDS = 10
STUBBORN = 16  # rounds more, from rest: a corner smaller than the grid may have to be passed a hundred times more slowly (AX-601)
FAIR = 1.003  # times too much that is left as it is then
SLOWEST = (1e-4, 1e-8)  # of the largest sdot^2: lower values are not lowered further; the second in the late rounds
HAIR = 1.01  # in sdot^2
WORST = 1.03  # of the good value: a worse tail is rejected


@dataclass(frozen=True)
class Swift:
    """law: the entire law from its beginning; raw: (m,) s of the raw law at k * STEP_S; speed: sdot of the raw law there."""

    law: Law
    raw: Array
    speed: Array

    def shifted(self, by: float) -> "Swift":
        """The same on a path that begins `by` further on."""
        return Swift(self.law.shifted(by), self.raw - by, self.speed)


def cropped(made: Swift, sample: int, width: float) -> tuple[Swift, int]:
    """Without what lies so far before the sample that the mean does not reach it; and the sample's new place."""
    first = max(sample - round(width / STEP_S) - 2 * STENCIL, 0)
    law = made.law
    start = (float(law.s[first]), float(law.speed[first]), float(law.accel[first]))
    short = Law(law.s[first:], law.speed[first:], law.accel[first:], law.step, start)
    return Swift(short, made.raw[first:], made.speed[first:]), sample - first


def width_s(limits: LawLimits) -> float:
    """Return the seconds of the mean: constant for an entire growing path."""
    finite = np.isfinite(limits.accel) & np.isfinite(limits.jerk)
    slowest = float(np.max(limits.accel[finite] / limits.jerk[finite])) if np.any(finite) else 0.02
    return max(round(WIDTH * slowest / STEP_S), 2) * STEP_S


def swift(path: JointPath, limits: LawLimits, width: float, before: Swift | None = None, cut: int = 0, start: float = 0.0) -> Swift:
    """As swift_work, at once."""
    return whole(swift_work(path, limits, width, before, cut, start))


def swift_work(
    path: JointPath, limits: LawLimits, width: float, before: Swift | None = None, cut: int = 0, start: float = 0.0
) -> Work[Swift]:
    """Plan from rest at `start` (before: None), or continue `before` (same path coordinate) from its sample `cut` on.

    A slice is a part of a round.  Raise MotionError where no law leads to the end, or none continues `before` within the limits.
    """
    count = round(width / STEP_S)
    keep = 0 if before is None else cut + STENCIL
    if before is None or keep >= len(before.raw):
        held = np.array([start]) if before is None else np.concatenate([before.raw, np.full(keep + 1 - len(before.raw), before.raw[-1])])
        speeds = np.zeros(len(held))
    else:
        held, speeds = before.raw[: keep + 1], before.speed[: keep + 1]
    s0, v0 = float(held[-1]), float(speeds[-1])
    if path.length - s0 < 1e-12:
        raise MotionError("nothing is left of this path")
    points = int(min(max(A_STRETCH * len(path.coefficients), POINTS[0]), POINTS[1]))
    grid = np.linspace(s0, path.length, points + 1)
    first, second = path.at(grid, 1), path.at(grid, 2)
    behind = 0.0 if before is None else float(before.law.s[min(cut, len(before.law.s) - 1)])  # the mean is still there
    accel, most = SHARE * limits.pulls(grid), _kept(path, limits, grid, behind, width)
    yield
    floor = _braking(first, accel, grid, v0)
    made: Swift | None = None
    worst = math.inf
    for k in range(ROUNDS + STUBBORN):
        try:
            raw = _entered(first, second, float(grid[1] - grid[0]), accel, most, v0 * v0)
        except MotionError:
            if made is None:
                raise
            break  # lowered so far that it could not be entered any more: the round before is the best there is
        yield
        tail, rates = _sampled(grid, raw)
        made = _smoothed(np.concatenate([held, tail]), np.concatenate([speeds, rates]), count, path.length)
        excess = _excess(path, limits, made.law, keep)
        late = k >= ROUNDS - 1
        worst = float(excess.max(initial=0.0))
        if worst <= 1.0 or (late and (before is not None or worst <= FAIR)):
            break
        lower, accel = _lowered(most, accel, grid, made, excess, count, raw, late)
        most = np.minimum(most, np.maximum(lower, floor))
        yield
    assert made is not None
    if before is not None and worst > WORST:
        raise MotionError("nothing goes on with the law under way and keeps acceleration and jerk")
    return made


def _kept(path: JointPath, limits: LawLimits, grid: Array, behind: float, width: float) -> Array:
    """(n,) largest sdot^2 of the raw law on the grid, for its mean to keep the speed limits from s = behind on: each limit applies around
    its place as far as half the way made in `width` at its speed.
    """
    step = float(grid[1] - grid[0])
    more = max(math.ceil((float(grid[0]) - behind) / step), 0)
    s = np.concatenate([grid[0] - step * np.arange(more, 0, -1), grid])
    each = _squares(path, limits, s)
    reach = np.minimum(np.ceil(0.5 * width * np.sqrt(each) / step) + 1, len(s)).astype(np.int64)
    kept = each.copy()
    for k in np.flatnonzero(each < float(each.max())):
        around = kept[max(k - reach[k], 0) : k + reach[k] + 1]
        np.minimum(around, each[k], out=around)
    return np.asarray(kept[more:])


def _squares(path: JointPath, limits: LawLimits, s: Array) -> Array:
    """(n,) largest sdot^2 the speed limits allow at even places.  Those of a tool also hold between a place and its neighbours: along paths
    of the axes its rate has peaks a grid does not see."""
    each = speed_squares(path, s, limits)
    led = sorted({cap.column for cap in limits.caps if np.isinf(limits.speed[cap.column]) and np.isfinite(cap.speed)})
    if not led:
        return each
    fine = np.interp(np.arange(FINER * (len(s) - 1) + 1), FINER * np.arange(len(s)), s)
    rates = np.maximum(np.abs(path.at(fine, 1)[:, led]), 1e-12)
    most = np.min(limits.at(fine)[0][:, led] / rates, axis=1) ** 2
    most[1:-1] = np.minimum(
        np.minimum(most[:-2], most[2:]), most[1:-1]
    )  # where it steps, as at a change of the tool, from the side that is slower
    least = np.minimum(most[:-1].reshape(-1, FINER).min(axis=1), most[FINER::FINER])  # of each interval, both ends included
    each[:-1] = np.minimum(each[:-1], least)
    each[1:] = np.minimum(each[1:], least)
    return each


def _entered(first: Array, second: Array, step: float, accel: Array, most: Array, b: float) -> topp.Topp:
    """The raw law from sdot^2 = b; where something slow became known late with all of the acceleration, and on another grid than before
    it may have to be a hair slower."""
    ready = topp.entries(first, second, step, accel, most)
    if not ready.admit(b):
        ready = topp.entries(first, second, step, accel / SHARE, most)
    if not ready.admit(b):
        if b > ready.most * HAIR:
            raise MotionError(f"the path cannot be entered at {b**0.5:.6g}: at most {ready.most**0.5:.6g} can still be braked")
        b = ready.most * (1 - 1e-12)
    return ready.law(b)


def _braking(first: Array, accel: Array, grid: Array, speed: float) -> Array:
    """(n,) sdot^2 that braking from the start leaves at least: what caps may not ask to be below."""
    slope = np.maximum(np.abs(first), 1e-9)
    strength = 0.6 * float(np.min(accel / slope))
    return np.asarray(np.maximum(speed * speed - 2 * strength * (grid - grid[0]), 0.0) * 1.0001)


def _sampled(grid: Array, raw: topp.Topp) -> tuple[Array, Array]:
    """Return s and sdot of the raw law at STEP_S, 2 STEP_S .. after its start, to its end."""
    times, root = raw.times, np.sqrt(raw.b)
    moments = np.arange(1, int(np.ceil(check_seconds(float(times[-1])) / STEP_S - 1e-9)) + 1) * STEP_S
    index = np.clip(np.searchsorted(times, moments, side="right") - 1, 0, len(times) - 2)
    u = (raw.b[index + 1] - raw.b[index]) / (2 * raw.step)
    t = np.minimum(moments, times[-1]) - times[index]
    s = np.minimum(grid[index] + t * (root[index] + 0.5 * u * t), grid[-1])
    v = np.where(moments >= times[-1], 0.0, np.maximum(root[index] + u * t, 0.0))
    s[-1] = grid[-1]
    return np.asarray(np.maximum.accumulate(s)), np.asarray(v)


def _smoothed(raw: Array, speed: Array, count: int, length: float) -> Swift:
    """Return the mean over the last `count` steps; before its start the raw law is at rest."""
    padded = np.concatenate([np.full(count, raw[0]), raw, np.full(count, raw[-1])])
    halves = 0.5 * (padded[1:] + padded[:-1])
    total = np.concatenate([[0.0], np.cumsum(halves)])
    s = (total[count:] - total[:-count]) / count
    s = np.minimum(np.maximum.accumulate(s), length)
    s[-1] = raw[-1]
    return Swift(Law.sampled(s, STEP_S, (float(raw[0]), 0.0, 0.0)), raw, speed)


def _excess(path: JointPath, limits: LawLimits, law: Law, keep: int) -> Array:
    """How many times too much at the samples that may still change, acceleration and jerk by differences of the columns."""
    s = np.concatenate([law.s[:1]] * 3 + [law.s] + [law.s[-1:]] * 3)
    q = path.at(s)
    jerk = limits.at(s)[2]
    second = pull_shares(q, STEP_S, limits.pulls(s)[:, 1:-1]) / ACCEL_GOOD
    third = np.abs(np.diff(q, 3, axis=0)) / STEP_S**3 / jerk[1:-2] / JERK_GOOD
    both = np.maximum(second[1:].max(axis=1), third.max(axis=1) ** (2 / 3))[2:]
    return np.asarray(both[keep:])


def _lowered(
    most: Array, accel: Array, grid: Array, made: Swift, excess: Array, count: int, raw: topp.Topp, late: bool
) -> tuple[Array, Array]:
    """Lower speeds and accelerations around each excess as far before and after as the mean reaches.  late: in the last rounds lower only
    speeds where it moves, because with less deceleration it would creep over long distances.
    """
    s, step = made.law.s, float(grid[1] - grid[0])
    first = len(s) - len(excess) - 2
    factor = np.ones(len(grid))
    over = np.flatnonzero(excess > 1.0)
    low, high = (s[np.minimum(np.maximum(first + over + by, 0), len(s) - 1)] for by in (-4, count))
    rows = zip(grid.searchsorted(low - step).tolist(), grid.searchsorted(high + step, side="right").tolist(), over.tolist(), strict=True)
    for begin, end, k in rows:
        np.minimum(inside := factor[begin:end], max(0.93 / float(excess[k]), 0.6), out=inside)
    touched = factor < 1.0
    running = touched & (raw.b > SLOWEST[late] * float(raw.b.max()))
    weaker = touched & ~running if late else touched
    return np.where(running, np.minimum(most, raw.b * factor), most), np.where(weaker[:, None], accel * factor[:, None], accel)
