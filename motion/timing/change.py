"""How the share of full speed changes: in each period by the largest legal step.

omega = dtau/dt is the share of full speed, u = d omega/dt, c = du/dt.  |omega| <= 1 with u = 0 is lawful anywhere, because full speed
is; so u is lawful as long as it can be brought back to 0 in time: what lies ahead limits it (motion.timing.foresight).

Where the way is so calm that one bound of u and one of c hold all along it, the change is known at once (motion.timing.phases) and is
nearly the fastest: it is taken when it is at least as fast as what foresight could ever find.
"""

from math import inf, nan

from motion.timing.foresight import BEYOND, Foresight
from motion.timing.phases import Phase, calmed, least_time, phases, travel
from motion.timing.track import Track

CALM_ENOUGH = 1.15  # times the duration that the limits here allow: longest change in phases
CLOSE = 8  # periods of a landing that phases execute
TURN = 1e-9  # of omega: rounding, no turning round
MOST = 1.02  # of full speed, for a moment: a change that comes back to it too fast lands from beyond, the jerk of the axes kept
LOOKS = 3  # at the way a change in phases makes, each a little further


class Change:
    """Decides c; the caller moves."""

    def __init__(self, track: Track, period_s: float, foresight: type[Foresight] = Foresight) -> None:
        self._track, self._h = track, period_s
        self._ahead = foresight(track, period_s)
        self._phases: list[Phase] = []  # the change under way, the last one first, where it is made of phases
        self._left = 0  # periods of the present phase
        self._ordered = nan  # omega the change under way leads to; nan: to be looked at anew
        self.room = 0.0  # the smaller of the two bounds of c in the next period

    @property
    def apart(self) -> float:
        """s from place to place that is foreseen."""
        return self._ahead.apart

    def prepare(self) -> None:
        """To be called when the track has grown."""
        self._ahead.prepare()

    def forget(self) -> None:
        """Nothing is foreseen: speed is steady, or the path is another one."""
        self._ahead.begun = False
        self._phases, self._left, self._ordered = [], 0, nan

    def disturbed(self) -> None:
        """Speed was moved, or the path ahead changed: phases are worked out anew."""
        if self._phases:
            self._ordered = nan

    def bounded(self, u: float, c: float) -> float:
        """c, as much of it as a period may bring at this u; the last look at the set values may go a little beyond what was foreseen."""
        ahead = self._ahead.horizon
        most = max(BEYOND * ahead.most_u, abs(u))
        c = min(max(c, -ahead.most_c), ahead.most_c)
        return min(max(c, (-most - u) / self._h), (most - u) / self._h)

    def step(self, tau: float, w: float, u: float, wanted: float) -> float:
        """c for this period, from tau, omega and u, towards the wanted omega."""
        if wanted != self._ordered or self._close(wanted - w, u):
            self._order(tau, w, u, wanted)
        if self._phases:
            return self._next_phase(wanted)
        c = self._ahead.step(tau, w, u, wanted)
        self.room = self._ahead.room
        return c

    # ---- in phases -----------------------------------------------------------------------------------------------------
    def _order(self, tau: float, w: float, u: float, wanted: float) -> None:
        """Begin a new change: in phases where possible; else foreseen, from u = 0 where phases had gone further than that would; else the
        current phases continue: they end sooner than any reversal.
        """
        found, ordered = self._planned(tau, w, u, wanted), wanted
        if not found and not self._ahead.begun and u != 0.0:
            found, ordered = self._calming(tau, w, u), nan
            if not found and self._phases and self._ordered == self._ordered:
                return
        self._phases, self._ordered = found, ordered if found else wanted
        if found:
            self._ahead.begun, self._left = False, found[-1].periods

    def _close(self, left: float, u: float) -> bool:
        """Return whether a foreseen change is about to land: full periods land without a remainder, whatever lies between its places."""
        most = CLOSE * self._h * self.room
        return self._ahead.begun and abs(u) <= most and 4 * abs(left) <= CLOSE * self._h * most

    def _next_phase(self, wanted: float) -> float:
        c = self._phases[-1].c
        self._left -= 1
        self.room = 0.0  # no landing before the end
        if self._left == 0:
            self._phases.pop()
            if self._phases:
                self._left = self._phases[-1].periods
            elif self._ordered == wanted:
                self.room = inf
        return c

    def _planned(self, tau: float, w: float, u: float, wanted: float) -> list[Phase]:
        """Return phases to the wanted omega; none where they would exceed the limits, reverse on the path, or last long."""
        h, left, top = self._h, wanted - w, max(abs(w), abs(wanted))
        if w * wanted < 0.0:
            return []
        most_u, most_c = self._track.here(tau)
        calm, ahead = least_time(left, most_u, most_c), self._ahead.horizon
        longest = max(CALM_ENOUGH * calm, least_time(left, ahead.most_u, ahead.most_c)) + 2 * abs(u) / most_c + 2 * h
        way = (0.5 * (abs(w) + abs(wanted)) * calm + top * abs(u) / most_c) * CALM_ENOUGH
        sense = 1.0 if w + wanted > 0.0 else -1.0
        for _ in range(LOOKS):
            most_u, most_c = self._most(tau, sense * way, top, left, u)
            if most_u <= 0.0 or most_c <= 0.0 or least_time(left, most_u, most_c) > longest:
                return []
            found = phases(left, u, most_u, most_c, h)
            if found is None:
                return []
            went = travel(found, w, u, h)
            low, high = sorted((sense * went.lowest, sense * went.highest))
            if low < -TURN or high > max(top, 1.0) + TURN:
                return []
            if sense * went.way <= way and high <= top + TURN:
                return found[::-1]
            way, top = max(way, sense * went.way * (1 + TURN)), max(top, high)
        return []

    def _calming(self, tau: float, w: float, u: float) -> list[Phase]:
        """To u = 0, whatever omega then is; none where even that would leave the limits."""
        _, most_c = self._most(tau, w * self._track.ramp, abs(w), 0.0, u)
        if most_c <= 0.0:
            return []
        found = calmed(u, most_c, self._h)
        went = travel(found, w, u, self._h)
        return found if went.lowest >= -MOST and went.highest <= MOST and w * went.end >= 0.0 else []

    def _most(self, tau: float, way: float, omega: float, left: float, u: float) -> tuple[float, float]:
        """Highest |u| and |c| along this way, two periods more at both ends."""
        h = self._h
        return self._ahead.most(self._track.span(tau + min(way, 0.0) - 2 * h, tau + max(way, 0.0) + 2 * h), omega, left, u)
