"""Whether a process shows life: a hung one does not, one the machine gives no processor to cannot.

What counts as its silence is time it could have used: it slept, or it was running and did not get round to its beat.  Time in which it
wanted a processor (or its disk) and got none does not count, and neither does time in which the watcher itself did not look.  So a
stopped, a blocked and a spinning process are found within the limit, and a busy machine ends nothing.
"""

from dataclasses import dataclass

from protocols.base.machine import Ns, ms

LOOKS_FROM = 4  # the processor time is read from a quarter of the limit on: before that nothing has to be decided
LONGEST_LOOK = ms(50)  # between two looks; more is the watcher's own delay
BOUND = ms(5_000)  # beyond the limit: so long may a machine be busy before its process is taken for hung


@dataclass(frozen=True, slots=True)
class Load:
    """Of a whole process: processor time used so far, and whether a thread of it wants a processor or waits for a disk."""

    used: Ns
    wants: bool


@dataclass(slots=True)
class LifeWatch:
    """One process, looked at every few milliseconds."""

    limit: Ns
    silence: Ns = 0  # that counts
    starved: Ns = 0  # that does not, since the last beat
    _count: int = -1
    _looked: Ns = 0
    _used: Ns | None = None

    def wants_load(self, now: Ns, count: int, stamp: Ns) -> bool:
        """The next look needs the processor time."""
        return count == self._count and now - stamp > self.limit // LOOKS_FROM

    def look(self, now: Ns, count: int, stamp: Ns, load: Load | None = None) -> bool:
        """False: it is dead.  count, stamp: its last beat."""
        elapsed, self._looked = now - self._looked, now
        if count != self._count:
            self._count, self._used, self.starved = count, None, 0
            self.silence = min(now - stamp, elapsed, LONGEST_LOOK)
            return True
        charged = min(elapsed, LONGEST_LOOK)
        if load is not None:
            if load.wants and self._used is not None:
                charged = min(charged, load.used - self._used)
            self._used = load.used
        self.silence += charged
        self.starved += elapsed - charged
        return self.silence <= self.limit and now - stamp <= self.limit + BOUND
