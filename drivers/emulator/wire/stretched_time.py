"""Simulated time that waits for the machine: it stands still while a SYNC is due and does not come (AX-681).  Pure: `now` is handed in.

Drives that are simulated beside everything else of a busy machine would miss a SYNC that was only late.  Here the time between two
SYNCs is never longer than one period and a little; what the machine was late is cut out.  Nor is it much shorter where a SYNC follows a
late one at once: the set values go a whole period further with each SYNC, so time that was cut out comes back (AX-1090).

A SYNC that stays away for HOLD_NS is missing: time goes on, and the drives do what they do without one.
"""

from collections.abc import Iterable, Set

from protocols.base.machine import Frame, Ns, ms

HOLD_NS = ms(800)  # longer than the cycle waits for the drives, shorter than what services wait for a silent cycle there
NAP_NS = ms(1)  # between two looks while time stands still
JITTER = 8  # a SYNC may come this part of a period late before time stands still, or early before time that was cut out comes back


class StretchedTime:
    """Of one bus."""

    def __init__(self, period_ns: Ns, sync_ids: Set[int]) -> None:
        self.cut_ns: Ns = 0  # by how much simulated time is behind
        self._sync_ids = sync_ids
        self._shortest, self._longest = period_ns - period_ns // JITTER, period_ns + period_ns // JITTER
        self._last: Ns | None = None  # when the last SYNC came, simulated; None: none is awaited

    def at(self, now: Ns) -> Ns:
        """What the drives take for `now`."""
        simulated = now - self.cut_ns
        if self._last is None or simulated <= self._last + self._longest:
            return simulated
        if simulated - self._last > HOLD_NS:
            self.cut_ns += HOLD_NS - self._longest
            self._last = None
            return now - self.cut_ns
        return self._last + self._longest

    def held(self, now: Ns) -> bool:
        """Whether time stands still."""
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
