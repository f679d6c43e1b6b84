"""How the share of full speed changes: in each period the strongest lawful step, found from what lies ahead.

omega = dtau/dt is the share of full speed, u = d omega/dt, c = du/dt.  |omega| <= 1 with u = 0 is lawful anywhere, because full speed
is; so u is lawful as long as it can be brought back to 0 in time.  Along the way that was foreseen a period ago (omega, u, tau at
places in time) the rows of the track give, in closed form, the lowest u that the accelerations allow and the range of c that the
jerks allow.  One pass from the far end back gives the lowest u from which everything behind can still be met; one pass forward the
way that falls to it, rides on it, and lands on the wanted omega with u = 0.  The first period of that way is driven, the rest is
what is foreseen next time.  No search, and as many operations in every period.

Everything is written for omega that falls; for omega that rises v = -u takes the place of u.
"""

from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motion.timing.track import Part, Track

Array = NDArray[np.float64]
PLACES = 48  # foreseen at most
AHEAD = 2.4  # times acceleration / jerk of the slowest axis: how long u may take to come back
MOST_U, MOST_C = 0.08, 0.02  # change of omega and of u * period in a period: where the path hardly moves nothing else bounds them
QUICK, HASTE = 0.5, 2.0  # u by the ramp, c by u and ramp
HEAVY = 4.0  # times the least room for c that an axis has: more, and it counts as one that c hardly moves
CALM = 0.4  # of the largest u where the path is to go faster: nobody waits for it
PROBE = 0.1  # of the largest u, for a look at places where v is smaller
RESERVE = 0.06  # of the jerk limit, kept for what was not foreseen
TRUST = 0.5  # of a new way in what is foreseen: two of them would answer one another
SPARE = 1.05  # ways to land are taken so much longer: they are foreseen, not known
BOLD = 0.4  # of a new way deeper than the foreseen one: what an axis that is about to turn back will bear is known late
STIFF = 0.8  # of v a period: more does its own jerk not take away
SHARES = np.linspace(0.0, 1.0, 5)  # of the range of c, tried for the landing


class _Rise(NamedTuple):
    """v at every place, had it started at 0 and risen as fast as the jerks allow: scale * sum; any other start: scale * (sum + start)."""

    scale: Array
    sum: Array

    def back(self, v: float) -> Array:
        """From v at place 1 on; 0 once it is reached."""
        scale, total = self.scale, self.sum
        return np.asarray(np.minimum((total[1:] - total[1] + v / scale[1]) * scale[1:], 0.0))


class Change:
    """Decides c; the caller moves."""

    def __init__(self, track: Track, period_s: float) -> None:
        self._track, self._h = track, period_s
        self._count = 0
        self._ramp = 0.0
        self._set_up(period_s)
        self._reserve = 0.0  # of c, beyond its bound
        self._steady = False  # a way has been driven a period long already
        self._foreseen = np.zeros(0)  # u at places dt apart, from the present one
        self.room = 0.0  # the smaller of the two bounds of c in the next period

    def forget(self) -> None:
        """Nothing is foreseen: speed is steady, or the path is another one."""
        self._count = 0

    def bounded(self, u: float, c: float) -> float:
        """c, as much of it as a period may bring at this u."""
        most = max(self._most_u, abs(u))
        c = min(max(c, -self._most_c), self._most_c)
        return min(max(c, (-most - u) / self._h), (most - u) / self._h)

    def step(self, tau: float, w: float, u: float, wanted: float) -> float:
        """c for this period, from tau, omega and u, towards the wanted omega."""
        if self._count == 0:
            self._begin(u)
        dt, seen = self._dt, self._foreseen
        seen[0] = u
        flip = 1.0 if w > wanted or (w == wanted and u > 0.0) else -1.0
        omega = np.maximum(np.minimum(self._summing @ seen + w, max(w, wanted)), min(w, wanted))
        v0 = flip * u
        lowest, falls, rise = self._bounds(self._placing @ omega + tau, omega, flip * seen, flip, abs(w) > abs(wanted))
        scale, total = rise
        base = scale * (np.maximum.accumulate((lowest / scale - total)[::-1])[::-1] + total)
        least = min(max(base.item(1), v0 + falls.item(0) * dt), 0.0) if v0 <= 0.0 else v0 + falls.item(0) * dt
        if self._steady and abs(w) > abs(wanted):
            foreseen = flip * seen.item(1)
            least = max(least, foreseen + BOLD * (least - foreseen)) if least < foreseen else least
        self._steady = True
        highest = max(scale.item(1) * (total.item(1) + v0), v0 - self._most_c * dt)
        first, back = self._landing(flip * (w - wanted), v0, least, highest, rise)
        first = min(first, highest + self._reserve * dt)
        if back is not None:
            way = np.concatenate([[v0], back])
        else:
            down = self._before @ falls
            way = np.minimum(base, 0.0) - down
            way[0] = v0
            way = np.maximum.accumulate(way) + down
        way[1] = first
        self._keep(flip * way, dt)
        return flip * (first - v0) / dt

    def _begin(self, u: float) -> None:
        self.prepare()
        self._steady = False
        self._count = self._places
        self._foreseen = np.zeros(self._count)
        self._foreseen[0] = u

    def prepare(self) -> None:
        """What depends on the robot's limits alone; to be called when the track has grown, so that no period has to."""
        ramp = max(self._track.ramp, 1e-6)
        if ramp != self._ramp:
            self._set_up(ramp)

    def _set_up(self, ramp: float) -> None:
        h = self._h
        self._ramp = ramp
        self._most_u = min(MOST_U / h, QUICK / ramp)
        self._probe = PROBE * self._most_u
        self._most_c = min(MOST_C / h**2, HASTE * self._most_u / ramp)
        ahead = max(AHEAD * ramp, 4 * h)
        self._dt = dt = max(h, ahead / PLACES)
        count = ceil(ahead / dt) + 2
        self._places = count
        self._tables = np.empty((7, self._track.columns, count))
        self._before = dt * np.tri(count, k=-1)
        self._summing = 0.5 * dt * (np.tri(count, k=-1) + np.tri(count))
        self._summing[:, 0] -= 0.5 * dt
        self._summing[0] = 0.0
        self._placing = np.concatenate([self._summing, self._summing + 0.5 * h * np.eye(count)])

    def _keep(self, way: Array, dt: float) -> None:
        """The way as it is seen a period later."""
        mean = TRUST * way
        mean += (1.0 - TRUST) * self._foreseen
        mean[:2] = way[:2]
        if dt == self._h:
            seen = np.empty(len(way))
            seen[:-1] = mean[1:]
            seen[-1] = 0.0
        else:
            share = self._h / dt
            seen = mean
            seen[:-1] += share * (mean[1:] - mean[:-1])
        self._foreseen = seen

    def _bounds(self, taus: Array, omega: Array, v: Array, flip: float, braking: bool) -> tuple[Array, Array, _Rise]:
        """Lowest v by the accelerations; lowest and highest c (as change of v) by the jerks.

        taus: of the places, then of the middles of the periods that begin there: c is that of a period.
        """
        count = len(v)
        rows = self._track.at(taus)  # (parts, columns, places)
        here, rows = rows[:, :, :count], rows[:, :, count:]
        bound, lean, gain, steady, pull, above, below = (
            self._tables
        )  # columns first, in one run of memory: so minima over columns are quick
        np.multiply(here[Part.BEND], flip * omega * omega, out=bound)
        bound += here[Part.REACH]
        lowest = np.maximum(-bound.min(axis=0), -self._most_u * (1.0 if braking else CALM))
        v0 = v.item(0)
        v = np.minimum(v, -self._probe) if v0 <= 0.0 else np.where(v > 0.0, v, np.minimum(v, -self._probe))
        middle = omega + (0.5 * self._h * flip) * v
        np.multiply(rows[Part.LEAN], middle, out=lean)
        np.multiply(lean, 0.5 * self._h, out=gain)
        gain += 1.0  # c changes v, and v the jerk, while the period lasts
        np.multiply(rows[Part.TWIST], flip * middle * middle * middle, out=steady)
        steady /= gain
        lean *= v
        lean /= gain
        np.absolute(gain, out=gain)
        np.divide(rows[Part.PULL], gain, out=pull)
        np.subtract(pull, steady, out=above)
        np.add(pull, steady, out=below)
        idle, foot = above.min(axis=0), below.min(axis=0)
        above -= lean
        below += lean
        rises, falls = above.min(axis=0), -below.min(axis=0)
        free = idle + foot
        tight, soft = float(pull[:, 0].min()), pull[:, 0].copy()
        # both ends of what c may be are bent towards one another with growing |v|: chords from v = 0 to the v foreseen are on the safe side
        room = rises - falls
        edge = v * free / np.maximum(free - room, 1e-9 * free)
        further = (
            np.maximum(np.minimum(edge, 0.0), -self._most_u) / v - 1.0
        )  # beyond the v foreseen the chord is not safe: looked at again there
        np.multiply(lean, further, out=gain)
        np.subtract(above, gain, out=pull)
        gain += below
        spare = pull.min(axis=0) + gain.min(axis=0)
        deep = (further > 0.0) & (spare < 0.0)
        edge = np.where(deep, v * (1.0 + further * room / np.maximum(room - spare, 1e-9 * free)), edge)
        lowest = np.maximum(lowest, np.minimum(edge, 0.0))
        lowest[-1] = 0.0
        slope = (idle - rises) / v  # the more v is below that place the slower it rises
        if 0.0 >= v0 > v.item(0):
            share = v0 / v.item(0)
            falls[0] = share * falls[0] - (1.0 - share) * foot[0]
        if room.item(0) < 0.0:  # an axis that turns back can hardly be helped by c: the others decide
            heavy = soft <= HEAVY * tight
            rises[0], falls[0] = above[heavy, 0].min(), -below[heavy, 0].min()
        self._reserve = RESERVE * tight
        most = self._most_c
        rises, falls = np.minimum(rises, most), np.maximum(falls, -most)
        self.room = min(rises.item(1), -falls.item(1))
        return lowest, falls, self._rise(rises, slope, v)

    def _rise(self, rises: Array, slope: Array, v: Array) -> _Rise:
        """v rises by (rises + slope * (seen v - v)) * dt from place to place."""
        dt = self._dt
        kept = np.minimum(np.maximum(dt * slope, -STIFF), STIFF)
        scale, total = np.ones(len(v)), np.zeros(len(v))
        np.cumprod((1.0 - kept)[:-1], out=scale[1:])
        np.cumsum((dt * rises + kept * v)[:-1] / scale[1:], out=total[1:])
        return _Rise(scale, total)

    def _landing(self, left: float, v0: float, least: float, highest: float, rise: _Rise) -> tuple[float, Array | None]:
        """The lowest v after this period, at least `least`, from which the wanted omega is not overshot; the way on where that decides."""
        dt = self._dt
        left /= SPARE
        back = rise.back(least)
        if -dt * (float(back.sum()) - 0.5 * back.item(0)) - 0.5 * dt * (v0 + least) <= left:
            return least, None
        tried = least + SHARES * max(highest - least, 0.0)
        backs = np.minimum((rise.sum[1:] - rise.sum[1] + tried[:, None] / rise.scale[1]) * rise.scale[1:], 0.0)
        ways = -dt * (backs.sum(axis=1) - 0.5 * backs[:, 0]) - 0.5 * dt * (v0 + tried)
        first = float(np.interp(-left, -ways, tried))
        return first, rise.back(first)
