"""Block slope of the rho 3: each block has its own ramps; the next one starts early and both are added.

Source: rho 3 Releases part 1, sections 6.2 (L1815-1840): the start is the moment at which every axis (or the TCP) has come within
its distance of the end; not before the middle of the previous block; an overlapped block ends before the middle of the next one.
The sum may exceed what the axes can do (sharp corners: up to twice): the start is then delayed until it does not (AX-413).

Time and path are separate here as everywhere: the sum is formed once at 100 %, and the resulting curve is frozen as a path (AX-413).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.execution.profile import Profile
from motion.geometry.limits import AxisLimits
from motion.paths.corner import hermite
from motion.paths.joints import JointPath, joint_path
from motion.timing.law import Law
from motion.timing.sine_square import SineSquare, sine_square
from motion.timing.two_ramps import TwoRamps, two_ramps

Array = NDArray[np.float64]
TRIES = 24  # start times looked at between the earliest one and no overlap
SAMPLES = 60  # of the overlap, against the limits
NODES = 24  # of the frozen curve: with 16 the U cycle of the portal took 0.3 ms more
ROOM = 1 + 1e-6
SLOWEST = 0.02  # of the faster block's speed: below it the sum is nearly at rest and defines no path
CREEP, LITTLE = 0.15, 1e-3  # of a block's mean speed, and of its length: see _little


@dataclass(frozen=True)
class Clock:
    """Where on its path a stretch is while blocks with sine-square slope run as they were added: from `begins` to `ends` of `way`."""

    way: Callable[[Array], Array]
    begins: float
    ends: float

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.ends - self.begins

    def at(self, t: Array) -> Array:
        """(n,) s since the stretch began, t after that."""
        return np.asarray(self.way(self.begins + t) - self.way(np.array([self.begins])))


@dataclass(frozen=True)
class Ramped:
    """One block with its own ramps from rest to rest."""

    path: JointPath
    duration: float
    _profile: Profile | TwoRamps | SineSquare

    def s(self, t: float) -> tuple[float, float, float]:
        """(s, sdot, sddot) t seconds after its start; at rest before and after."""
        if t <= 0.0:
            return 0.0, 0.0, 0.0
        if t >= self.duration:
            return self.path.length, 0.0, 0.0
        return self._profile.at(t)

    def time_at(self, s: float) -> float:
        """When it passes s."""
        low, high = 0.0, self.duration
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.s(middle)[0] >= s else (middle, high)
        return high

    def clock(self, begin: float, end: float) -> Clock | None:
        """Return the clock of the stretch between these s; None: its ramps are jerk-limited, and their law is made anew along the entire
        curve.
        """
        if not isinstance(self._profile, SineSquare):
            return None
        whole = self.path.length
        return Clock(self._profile.way, self.time_at(begin) if begin > 0.0 else 0.0, self.time_at(end) if end < whole else self.duration)

    @property
    def sine(self) -> bool:
        """Its ramps are sine squares."""
        return isinstance(self._profile, SineSquare)

    def law(self) -> Law:
        """Of sine squares, on an even grid."""
        assert isinstance(self._profile, SineSquare)
        return self._profile.law()

    def slower(self, factor: float) -> "Ramped":
        """With sine squares in `factor` times the time."""
        assert isinstance(self._profile, SineSquare)
        shape = self._profile.slower(factor)
        return Ramped(self.path, shape.duration, shape)

    def states(self, t: Array) -> Array:
        """(n, 3) s, sdot, sddot at these times, as s()."""
        if isinstance(self._profile, TwoRamps):  # a place alone costs as much as all of them
            return self._profile.states(t)
        return np.array([self.s(float(x)) for x in t])

    def motion(self, t: Array) -> tuple[Array, Array, Array]:
        """(n, axes) position against its start, speed and acceleration."""
        state = self.states(t)
        s, v, a = state[:, 0], state[:, 1:2], state[:, 2:3]
        n = self.path.axes
        q, q1, q2 = (self.path.at(s, order)[:, :n] for order in range(3))
        return q - self.path.at(np.zeros(1))[:, :n], q1 * v, q1 * a + q2 * v * v


def ramped(
    path: JointPath,
    limits: Sequence[AxisLimits],
    *,
    speed: float = 1.0,
    accel: tuple[float, float] = (1.0, 1.0),
    tool: tuple[float, float] = (math.inf, math.inf),
    pulls: tuple[tuple[float, float], float] = ((math.inf, math.inf), math.inf),
    sine: bool = False,
) -> Ramped:
    """A block with constant limits along s: the smallest its axes allow anywhere on it; shares of speed and of acceleration up and
    down; tool: most speed (m/s) and turning (rad/s) of the tool, by the path's last two columns, pulls: its accelerations, way up and
    down; sine: with the sine-square slope (AX-575)."""
    s = np.linspace(0.0, path.length, 33)
    n = path.axes
    first, second = np.abs(path.at(s, 1)), np.abs(path.at(s, 2))[:, :n]
    top, strength, jolt = (np.array([getattr(axis, name) for axis in limits]) for name in ("speed", "accel", "jerk"))
    largest = np.maximum(np.max(first[:, :n], axis=0), 1e-12)
    v = float(np.min(top * speed / largest))
    for most, rate in zip(tool, np.max(first[:, n:], axis=0), strict=True):
        v = min(v, most / max(float(rate), 1e-12))
    bend = float(np.max(second / (strength * min(accel))))
    if bend > 0.0:  # half of the acceleration is left for the ramps
        v = min(v, math.sqrt(0.5 / bend))
    quickest, way, turn = (float(x) for x in (np.min(jolt / largest), *np.maximum(np.max(first[:, n:], axis=0), 1e-12)))
    bent = np.max(second, axis=0) * v * v
    pull, drag = (
        min(float(np.min((strength * share - bent) / largest)), own / way, pulls[1] / turn)
        for share, own in zip(accel, pulls[0], strict=True)
    )
    if sine:
        shape = sine_square(path.length, v, pull, quickest, drag)
        return Ramped(path, shape.duration, shape)
    if pull != drag:
        ramps = two_ramps(path.length, v, (pull, drag), quickest)
        return Ramped(path, ramps.duration, ramps)
    profile = Profile()
    profile.configure(path.length, pull, quickest)
    if not profile.to_end((0.0, 0.0, 0.0), v):
        raise MotionError(f"no ramps fit a block of length {path.length:g}")
    return Ramped(path, profile.duration, profile)


def earliest(block: Ramped, leave: float) -> float:
    """When the next block may start at the earliest, s after this one's start: `leave` (in its s) before its end, and not before
    its middle (L1822)."""
    return block.time_at(block.path.length - min(leave, 0.5 * block.path.length))


@dataclass(frozen=True)
class Overlap:
    """The next block starts `start` s after the first; `shorter`: what that saves; leave: way the first has left then (in its s);
    reach: way the next has made when the first ends (in its s)."""

    start: float
    shorter: float
    leave: float
    reach: float


def overlap(
    before: Ramped, after: Ramped, start: float, limits: Sequence[AxisLimits], kept: Callable[[float], bool] | None = None
) -> Overlap | None:
    """The earliest legal overlap not before `start`: the first block ends before the middle of the next one, no axis exceeds its
    limits of speed, acceleration and jerk in the sum, and `kept` is the same for its other limits.  None: there is none."""

    def good(moment: float) -> bool:
        return within(before, after, moment, limits) and (kept is None or kept(moment))

    soonest = max(start, before.duration - after.time_at(0.5 * after.path.length))
    if soonest >= before.duration * (1 - 1e-9):
        return None
    span = before.duration - soonest
    refused = -1.0
    for k in range(TRIES):
        moment = soonest + span * k / TRIES
        if good(moment):
            return _overlap(before, after, _refined(good, refused, moment) if k else moment)
        refused = moment
    return None


def _refined(good: Callable[[float], bool], refused: float, found: float) -> float:
    for _ in range(6):
        middle = 0.5 * (refused + found)
        if good(middle):
            found = middle
        else:
            refused = middle
    return found


def _overlap(before: Ramped, after: Ramped, start: float) -> Overlap:
    shorter = before.duration - start
    return Overlap(start, shorter, before.path.length - before.s(start)[0], after.s(shorter)[0])


def within(before: Ramped, after: Ramped, start: float, limits: Sequence[AxisLimits]) -> bool:
    """Whether the sum keeps all limits while both blocks run."""
    t = np.linspace(start, before.duration, SAMPLES)
    _, v1, a1 = before.motion(t)
    _, v2, a2 = after.motion(t - start)
    step = float(t[1] - t[0])
    jerk = np.diff(a1 + a2, axis=0) / step
    top, strength, jolt = (np.array([getattr(axis, name) for axis in limits]) * ROOM for name in ("speed", "accel", "jerk"))
    return bool(np.all(np.abs(v1 + v2) <= top) and np.all(np.abs(a1 + a2) <= strength) and np.all(np.abs(jerk) <= jolt))


def summed(before: Ramped, after: Ramped, start: float, t: Array) -> Array:
    """(n, axes) set positions t after the first block's start: both added."""
    place = before.path.at(np.zeros(1))[0, : before.path.axes]
    return np.asarray(place + before.motion(t)[0] + after.motion(t - start)[0])


def frozen(before: Ramped, after: Ramped, found: Overlap) -> tuple[JointPath, Clock] | None:
    """Return the curve of the overlap as a path of the axes (way and turning continue those of the two blocks) and the clock of both
    blocks on it; None where the sum is nearly at rest, so that no path exists that can be run at any speed.
    """
    t = np.linspace(found.start, before.duration, NODES + 1)
    one, two = before.motion(t), after.motion(t - found.start)
    place = summed(before, after, found.start, t)
    v, a = one[1] + two[1], one[2] + two[2]
    size = np.sqrt(np.sum(v * v, axis=1))
    if float(np.min(size)) < SLOWEST * float(np.max(size)):
        return None
    # the parameter of both blocks added: at either end it is that of the one which runs there, so slope and bend join
    own = before.states(t) + after.states(t - found.start)
    rate, pull = own[:, 1], own[:, 2]
    if before.sine and after.sine and _little(before, after, found, float(rate[0]), float(rate[-1])):
        return None
    first = v / rate[:, None]
    second = (a - first * pull[:, None]) / (rate * rate)[:, None]
    ways, slopes = _ways(before, after, found, t)
    knots, rows = [0.0], []
    for k in range(NODES):
        h = float(t[k + 1] - t[k])
        length = h * (rate[k] + rate[k + 1]) / 2 + h * h * (pull[k] - pull[k + 1]) / 12  # Hermite's quadrature
        ends = [
            [(place[i, n], first[i, n], second[i, n]) for n in range(before.path.axes)]
            + [(ways[i, c], slopes[i, c] / rate[i], 0.0) for c in range(2)]
            for i in (k, k + 1)
        ]
        rows.append([hermite(length, a, b) for a, b in zip(*ends, strict=True)])
        knots.append(knots[-1] + length)
    law = Law(np.array(knots), rate, pull, float(t[1] - t[0]), (0.0, float(rate[0]), float(pull[0])))
    return joint_path(knots, rows), Clock(law.at, 0.0, law.duration)


def _little(before: Ramped, after: Ramped, found: Overlap, leaving: float, joining: float) -> bool:
    """Return whether sine squares meet where both are nearly at rest or over a negligible way: that is practically a stop in the point,
    and a separate law would creep through the bend of a tenth of a millimetre or not resolve it (AX-601).
    """
    one, two = before.path.length, after.path.length
    creeping = leaving < CREEP * one / before.duration and joining < CREEP * two / after.duration
    return creeping or (found.leave < LITTLE * one and found.reach < LITTLE * two)


def _ways(before: Ramped, after: Ramped, found: Overlap, t: Array) -> tuple[Array, Array]:
    """Way and turning of both blocks added: an upper bound of what the TCP really does."""
    total, rate = np.zeros((len(t), 2)), np.zeros((len(t), 2))
    for block, moments in ((before, t), (after, t - found.start)):
        state = block.states(moments)
        table = block.path.at(state[:, 0])[:, -2:]
        total += table - table[0]
        rate += block.path.at(state[:, 0], 1)[:, -2:] * state[:, 1:2]
    return total, rate
