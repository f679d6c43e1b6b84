"""Simulated time that waits for the computer: it stops while a SYNC is due and missing (AX-681).  Pure: `now` is passed in.

Drives simulated on a busy computer would miss a SYNC that was only late.  Here the time between two SYNCs is at most one period and a
little more; the lateness of the computer is cut out.  Nor is it much shorter if a SYNC follows a late one at once: the set values advance
by a full period with each SYNC, so time that was cut out is added back (AX-1090).

A SYNC later than HOLD_NS counts as missing: time continues, and the drives react to the missing SYNC.
"""

from collections.abc import Iterable, Set

from protocols.base.machine import Frame, Ns, ms

HOLD_NS = ms(800)  # longer than the cycle waits for the drives, shorter than the services' limit for a silent cycle in a simulation
NAP_NS = ms(1)  # between two looks while time is stopped
JITTER = 8  # fraction of a period: a SYNC may be so late before time stops, or so early before cut-out time is added back


class StretchedTime:
    """Time of one bus."""

    def __init__(self, period_ns: Ns, sync_ids: Set[int]) -> None:
        self.cut_ns: Ns = 0  # lag of simulated time
        self._sync_ids = sync_ids
        self._shortest, self._longest = period_ns - period_ns // JITTER, period_ns + period_ns // JITTER
        self._last: Ns | None = None  # when the last SYNC came, simulated; None: none is expected

    def at(self, now: Ns) -> Ns:
        """The time for the drives."""
        simulated = now - self.cut_ns
        if self._last is None or simulated <= self._last + self._longest:
            return simulated
        if simulated - self._last > HOLD_NS:
            self.cut_ns += HOLD_NS - self._longest
            self._last = None
            return now - self.cut_ns
        return self._last + self._longest

    def held(self, now: Ns) -> bool:
        """Whether time is stopped."""
        return self.at(now) != now - self.cut_ns

    def frames(self, frames: Iterable[Frame]) -> list[Frame]:
        """With the stamps the drives see; each SYNC begins a period."""
        found = []
        for frame in frames:
            stamp = self.at(frame.stamp_ns)
            if frame.identifier in self._sync_ids:
                if self._last is not None:
                    stamp = min(max(stamp, self._last + self._shortest), frame.stamp_ns)
                self.cut_ns = frame.stamp_ns - stamp
                self._last = stamp
            found.append(frame._replace(stamp_ns=stamp))
        return found
