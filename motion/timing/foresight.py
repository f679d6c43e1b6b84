"""Limits that the path ahead sets on a change of speed: place by place the largest legal step, computed anew in each period.

omega, u and c: motion.timing.change.  Along the way foreseen a period ago (omega, u, tau at places in time) the rows of the track yield,
in closed form, the lowest u that the accelerations allow and the range of c that the jerks allow.  One pass from the far end back yields
the lowest u from which all later limits can still be met; one pass forward yields the way that falls to it, follows it, and lands on the
wanted omega with u = 0.  The first period of that way is executed, the rest is the next foreseen way.  No search, and the same number of
operations in every period.

Everything is written for falling omega; for rising omega v = -u replaces u.
"""

from dataclasses import dataclass
from math import ceil
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from motion.timing.track import Part, Span, Track

Array = NDArray[np.float64]
PLACES = 48  # foreseen at most
AHEAD = 2.4  # times acceleration / jerk of the slowest axis: longest return of u
MOST_U, MOST_C = 0.08, 0.02  # change of omega and of u * period in a period: where the path hardly moves nothing else bounds them
QUICK, HASTE = 0.5, 2.0  # u by the ramp, c by u and ramp
HEAVY = 4.0  # times the least room for c of an axis: beyond, c hardly moves the axis
CALM = 0.4  # of the largest u where the path speeds up, which is not urgent
PROBE = 0.1  # of the largest u, for a look at places where v is smaller
RESERVE = 0.02  # of the jerk limit, for unforeseen changes: with it the set value reaches the goal of the last look
LESS = ((0.02, 0.935), (0.005, 0.95))  # of the jerk limit, with each period ahead less, and at least; on the way up, on the way down
TRUST = 0.5  # share of the new way and of the previous one in the foreseen way: two new ones would oscillate
SPARE, AMPLE = 1.05, 1.3  # factor on landing ways: they are foreseen, not known, and nothing lies beyond full speed
BOLD = 0.4  # share of the difference from the foreseen way: the limits of an axis about to reverse are known late
USEFUL = 0.75  # of the immediate effect of c on an axis, less half of the later effect of v: below it c does not help
STIFF = 0.8  # of v a period: its own jerk removes no more
SHARES = np.linspace(0.25, 1.0, 4)  # of the range of c, tried for the landing
BEYOND = 1.5  # of the largest u foreseen
SLOWEST = 0.01  # of full speed: slower, and an axis that turns back needs no jerk for it
LITTLE = 1e-6  # of c: less is rounding


class _Rise(NamedTuple):
    """v at place 1 and after it: scale * (sum + v at place 1 / first) where it rises as fast as the jerks allow."""

    scale: Array
    sum: Array
    first: float

    def back(self, v: float) -> Array:
        """From v at place 1 on; 0 once it is reached."""
        way = self.sum + v / self.first
        way *= self.scale
        return np.minimum(way, 0.0, out=way)

    def way(self, v: float) -> float:
        """The sum of v over all these places, place 1 by half."""
        back = self.back(v)
        return float(np.add.accumulate(back)[-1]) - 0.5 * back.item(0)  # sequentially, as in C: identical to the last bit

    def ways(self, tried: Array) -> Array:
        """The same from each of some v."""
        ways = self.sum + tried[:, None] / self.first
        ways *= self.scale
        np.minimum(ways, 0.0, out=ways)
        return np.asarray(np.add.accumulate(ways, axis=1)[:, -1] - 0.5 * ways[:, 0])


class _Bounds(NamedTuple):
    """Lowest v by the accelerations, lowest c (as change of v) by the jerks; v had it started at 0 and risen: scale * sum."""

    lowest: Array
    falls: Array
    scale: Array
    sum: Array


@dataclass(slots=True)
class Horizon:
    """How far ahead is looked, at how many places, and how much u and c may be at all: by the ramp of the slowest axis."""

    ramp: float
    most_u: float
    most_c: float
    probe: float  # u, for a look at places where v is smaller
    apart: float  # s from place to place
    places: int
    used: list[Array]  # of the jerk limit, place by place: on the way up, on the way down
    half: Array  # s from each place to the middle of the time its c holds: of the first one a period

    @classmethod
    def of(cls, ramp: float, period_s: float) -> Self:
        h = period_s
        most_u = min(MOST_U / h, QUICK / ramp)
        most_c = min(MOST_C / h**2, HASTE * most_u / ramp)
        ahead = max(AHEAD * ramp, 4 * h)
        apart = max(h, ahead / PLACES)
        count = ceil(ahead / apart) + 2
        used = [np.maximum(1.0 - less * apart / h * np.arange(count), least) for less, least in LESS]
        half = np.full(count, 0.5 * apart)
        half[0] = 0.5 * h
        return cls(ramp, most_u, most_c, PROBE * most_u, apart, count, used, half)


class Foresight:
    """Of one track.  In C: gateway.cycle.native.foresight (AX-609)."""

    def __init__(self, track: Track, period_s: float) -> None:
        self._track, self._h = track, period_s
        self.begun = False  # something is foreseen
        self.room = 0.0  # the smaller of the two bounds of c in the next period
        self._set_up(period_s)
        self._reserve = 0.0  # of c, beyond its bound
        self._steady = False  # a way has been driven a period long already
        self._foreseen = np.zeros(0)  # u at places dt apart, from the present one

    @property
    def apart(self) -> float:
        """s from place to place."""
        return self.horizon.apart

    def most(self, span: Span, omega: float, left: float, u: float) -> tuple[float, float]:
        """As Span.most."""
        return span.most(omega, left, u)

    def step(self, tau: float, w: float, u: float, wanted: float) -> float:
        """c for this period, from tau, omega and u, towards the wanted omega."""
        if not self.begun:
            self._begin(u)
        dt, seen, braking = self.horizon.apart, self._foreseen, abs(w) > abs(wanted)
        seen[0] = u
        flip = 1.0 if w > wanted or (w == wanted and u > 0.0) else -1.0
        spare = SPARE if braking else AMPLE
        omega = self._summed(seen)
        if not braking:
            omega *= spare
        omega += w
        np.minimum(omega, max(w, wanted), out=omega)
        np.maximum(omega, min(w, wanted), out=omega)
        taus = self._times(omega)
        taus += tau
        v0 = flip * u
        lowest, falls, scale, total = self._bounds(taus, omega, flip * seen, flip, braking, w * wanted < 0.0)
        base = lowest / scale
        base -= total
        least = v0 + falls.item(0) * dt
        if v0 <= 0.0:  # from the lowest v of place 1 every later place can still be met
            first = scale.item(1) * (float(np.maximum.reduce(base[1:])) + total.item(1))
            least = min(max(first, least), 0.0)
        highest = max(scale.item(1) * (total.item(1) + v0), v0 - self.horizon.most_c * dt)
        if self._steady and v0 <= 0.0:
            foreseen = flip * seen.item(1)
            least = min(foreseen + BOLD * (least - foreseen), max(least, highest))  # never above what c can reach now
        self._steady = True
        rise = _Rise(scale[1:], total[1:] - total.item(1), scale.item(1))
        first, back = self._landing(flip * (w - wanted) / spare, v0, least, highest, rise)
        first = min(first, highest + self._reserve * dt)
        if back is not None:
            way = np.empty(len(seen))
            way[1:] = back
        else:
            way = self._down(base, total, scale, falls, v0)
        way[0], way[1] = v0, first
        if flip < 0.0:
            np.negative(way, out=way)
        self._keep(way, dt)
        return flip * (first - v0) / dt

    def _down(self, base: Array, total: Array, scale: Array, falls: Array, v0: float) -> Array:
        """Return the way from v0 down to the lowest v from which all later places can be met, and along it; overwrites `base`."""
        backwards = base[::-1]
        np.maximum.accumulate(backwards, out=backwards)
        base += total
        base *= scale
        down = np.zeros(len(falls))
        np.add.accumulate(falls[:-1], out=down[1:])
        down *= self.horizon.apart
        way = np.minimum(base, 0.0, out=base)
        way -= down
        way[0] = v0
        np.maximum.accumulate(way, out=way)
        way += down
        return way

    def _begin(self, u: float) -> None:
        self.prepare()
        self._steady, self.begun = False, True
        self._foreseen = np.zeros(self.horizon.places)
        self._foreseen[0] = u

    def prepare(self) -> None:
        """What depends on the robot's limits alone; to be called when the track has grown, so that no period has to."""
        ramp = max(self._track.ramp, 1e-6)
        if ramp != self.horizon.ramp:
            self._set_up(ramp)

    def _set_up(self, ramp: float) -> None:
        self.horizon = horizon = Horizon.of(ramp, self._h)
        count = horizon.places
        self._sides, self._chords, self._gain = (np.empty((*parts, self._track.columns, count)) for parts in ((4,), (2,), ()))
        self._scale, self._sum = np.ones(count), np.zeros(count)

    def _summed(self, rates: Array) -> Array:
        """Trapezoids from the first place on: omega from u, times from omega.  One after the other: no row is chosen by a rounding."""
        sums = np.zeros(len(rates))
        np.add(rates[:-1], rates[1:], out=sums[1:])
        sums *= 0.5 * self.horizon.apart
        return np.add.accumulate(sums, out=sums)

    def _times(self, omega: Array) -> Array:
        """Of the places, then of the middles between them."""
        count = len(omega)
        times = np.empty(2 * count)
        times[:count] = places = self._summed(omega)
        middles = times[count:]
        np.multiply(omega, self.horizon.half, out=middles)
        middles += places
        return times

    def _keep(self, way: Array, dt: float) -> None:
        """The way as it is seen a period later, never beyond what u can be at all: seen again it would only grow."""
        mean, most = self._foreseen, max(BEYOND * self.horizon.most_u, abs(way.item(0)))
        mean += way
        mean *= TRUST
        np.minimum(mean, most, out=mean)
        np.maximum(mean, -most, out=mean)
        mean[0], mean[1] = way.item(0), way.item(1)
        if dt == self._h:
            mean[:-1] = mean[1:]
            mean[-1] = 0.0
        else:
            mean[:-1] += (self._h / dt) * (mean[1:] - mean[:-1])

    def _bounds(self, taus: Array, omega: Array, v: Array, flip: float, braking: bool, turning: bool) -> _Bounds:
        """taus: of the places, then of the middles between them, where c is wanted: the first one a period, the others a place wide."""
        v0 = v.item(0)
        lower = np.minimum(v, -self.horizon.probe)
        v = lower if v0 <= 0.0 else np.where(v > 0.0, v, lower)
        here, rows = self._track.around(taus, len(v), turning)  # (parts, columns, places), our own
        lowest = self._braked(here, omega, flip, braking)
        used, middle = self.horizon.used[1 if braking else 0], self.horizon.half * v
        if flip < 0.0:
            np.negative(middle, out=middle)
        middle += omega
        rows[0] *= used  # the actual way differs a little: later places must still be met then
        idle, foot, rises, falls = self._reach(rows, middle, v, flip)
        pull, lean = rows[0], rows[1]
        slope = idle - rises
        slope /= v  # the more v is below that place the slower it rises
        if 0.0 >= v0 > v.item(0):
            share = v0 / v.item(0)
            falls[0] = share * falls.item(0) + (1.0 - share) * foot.item(0)
        tight = min(pull[:, 0].tolist())
        self._reserve = RESERVE * tight
        room, free = rises + falls, idle + foot
        if rises.item(0) < 0.0 or falls.item(0) < 0.0:  # an axis that bears more of c later than it gains now asks for nothing
            self._use(self._gain[:, 0] > USEFUL, rises, falls)
        if rises.item(0) + falls.item(0) < 0.0:  # an axis that turns back can hardly be helped by c: the others decide
            self._use(pull[:, 0] <= HEAVY * tight, rises, falls)
        np.maximum(lowest, self._edge(room, free, v, lean), out=lowest)
        if self._track.turns:
            self._turned(taus[: len(v)], omega, flip, lowest, used)
        lowest[-1] = 0.0
        np.negative(falls, out=falls)
        self.room = min(rises.item(1), -falls.item(1))
        if self.horizon.apart > self._h:  # the next period lies between the first two places
            self.room = min(self.room, rises.item(0), -falls.item(0))
        return _Bounds(lowest, falls, *self._risen(rises, slope, v))

    def _use(self, axes: NDArray[np.bool_], rises: Array, falls: Array) -> None:
        """What c may be at the present place, by these axes alone; by all of them where there are none."""
        if axes.any():
            rises[0], falls[0] = (min(float(side[axes, 0].min()), self.horizon.most_c) for side in self._sides[2:])

    def _braked(self, here: Array, omega: Array, flip: float, braking: bool) -> Array:
        """Lowest v by the accelerations; `here` is used up."""
        bound = here[Part.BEND]
        bound *= omega * omega if flip > 0.0 else -omega * omega
        bound += here[Part.REACH]
        lowest: Array = np.minimum.reduce(bound, axis=0, initial=self.horizon.most_u * (1.0 if braking else CALM))
        return np.negative(lowest, out=lowest)

    def _turned(self, taus: Array, omega: Array, flip: float, lowest: Array, used: Array) -> None:
        """Raises the lowest v at both places between which an axis turns back to what its jerk bears there: no c helps it."""
        for tau, edge, low, high in self._track.between(float(np.minimum.reduce(taus)), float(np.maximum.reduce(taus))):
            off = taus - tau
            for k in np.flatnonzero(off[:-1] * off[1:] <= 0.0).tolist():
                before, after = off[k : k + 2].tolist()
                share = before / (before - after) if before != after else 0.0
                w = abs(omega.item(k) + share * (omega.item(k + 1) - omega.item(k)))
                bound = used.item(k + 1) * edge / max(w, SLOWEST) + w * w * (low if flip > 0.0 else -high)
                np.maximum(lowest[k : k + 2], min(-bound, 0.0), out=lowest[k : k + 2])

    def _reach(self, rows: Array, middle: Array, v: Array, flip: float) -> Array:
        """Return how far c may rise and fall with v = 0, then with the v foreseen: (4, places).  rows: PULL, LEAN, TWIST are replaced by
        their values for c all the way to the next place, with the v foreseen; the columns stay in `_sides`.
        """
        pull, lean, steady = rows
        lean *= middle
        gain = self._gain
        np.multiply(lean, self.horizon.half, out=gain)
        gain += 1.0  # c changes v, and v the jerk, while it lasts
        lean *= v
        steady *= flip * middle * middle * middle
        rows[1:] /= gain
        pull /= np.absolute(gain, out=self._chords[0])
        sides = self._sides
        np.subtract(pull, steady, out=sides[0])
        np.add(pull, steady, out=sides[1])
        np.subtract(sides[0], lean, out=sides[2])
        np.add(sides[1], lean, out=sides[3])
        return np.asarray(np.minimum.reduce(sides, axis=1, initial=self.horizon.most_c))  # over columns: in one run of memory

    def _edge(self, room: Array, free: Array, v: Array, lean: Array) -> Array:
        """Return the lowest v by the jerks.  Both ends of the range of c approach one another with growing |v|: chords from v = 0 to the v
        foreseen are on the safe side."""
        edge = v * free
        edge /= np.maximum(free - room, LITTLE)
        further = np.minimum(edge, 0.0)
        np.maximum(further, -self.horizon.most_u, out=further)
        further /= v
        further -= 1.0  # beyond the v foreseen the chord is not safe: looked at again there
        gain, (above, below) = self._gain, self._chords
        np.multiply(lean, further, out=gain)
        np.subtract(self._sides[2], gain, out=above)
        np.add(self._sides[3], gain, out=below)
        spare = np.add(*np.minimum.reduce(self._chords, axis=1, initial=self.horizon.most_c))
        if np.minimum.reduce(spare) < 0.0:
            deep = (further > 0.0) & (spare < 0.0)
            np.copyto(edge, v * (1.0 + further * room / np.maximum(room - spare, LITTLE)), where=deep)
        return np.minimum(edge, 0.0, out=edge)

    def _risen(self, rises: Array, slope: Array, v: Array) -> tuple[Array, Array]:
        """v rises by (rises + slope * (seen v - v)) * dt from place to place."""
        dt, scale, total = self.horizon.apart, self._scale, self._sum  # their first ones stay 1 and 0
        kept = dt * slope
        share = STIFF / np.maximum(kept, STIFF)  # stiffer: v comes near where it rises no more, not beyond
        np.minimum(kept, STIFF, out=kept)
        np.maximum(kept, -STIFF, out=kept)
        rises = dt * rises
        rises *= share
        rises += kept * v
        np.multiply.accumulate((1.0 - kept)[:-1], out=scale[1:])
        np.add.accumulate(rises[:-1] / scale[1:], out=total[1:])
        return scale, total

    def _landing(self, left: float, v0: float, least: float, highest: float, rise: _Rise) -> tuple[float, Array | None]:
        """The lowest v after this period, at least `least`, from which the wanted omega is not overshot; the way on where that decides."""
        dt = self.horizon.apart
        half = 0.5 * dt
        way = -dt * rise.way(least) - half * (v0 + least)
        if way <= left:
            return least, None
        tried = least + SHARES * max(highest - least, 0.0)
        if least < 0.0 < highest:  # beyond v = 0 nothing is gained: a chord over that place would stop short of the goal
            tried = np.append(least * (1.0 - SHARES), highest)
        low = least
        for v, behind in zip(tried.tolist(), rise.ways(tried).tolist(), strict=True):
            before, way = way, -dt * behind - half * (v0 + v)
            if way <= left:
                low += (v - low) * (before - left) / (before - way)
                break
            low = v
        return low, rise.back(low)
