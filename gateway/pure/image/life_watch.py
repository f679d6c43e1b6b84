"""Whether a process shows life; distinguishes a hung process from one that gets no processor time.

Only time that the process could have used counts as silence: it slept, or it ran without beating.  Time in which it waited for a processor
or its disk does not count, nor does time in which the watcher itself did not look.  So a stopped, a blocked and a spinning process are
found within the limit, and a busy machine ends no process.
"""

from dataclasses import dataclass

from protocols.base.machine import Ns, ms

LOOKS_FROM = 4  # the processor time is read from a quarter of the limit on: before that nothing has to be decided
LONGEST_LOOK = ms(50)  # between two looks; more is the watcher's own delay
BOUND = ms(5_000)  # beyond the limit: how long a machine may be busy before its process counts as hung


@dataclass(frozen=True, slots=True)
class Load:
    """Load of a process: processor time used so far, and whether one of its threads waits for a processor or a disk."""

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
