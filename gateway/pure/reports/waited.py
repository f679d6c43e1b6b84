"""What the operator reads of a stretched simulation whose machine is late: how long simulated time waited for it (AX-915)."""

from protocols.base.machine import Ns, ms

EVERY_NS = ms(60_000)  # between two sentences: a machine that is always late fills no journal
NOTED = 2  # periods: drives that count by the wall clock would have stopped


class WaitedTime:
    """Of one cycle.  Pure: `now` is handed in."""

    def __init__(self, period_ns: Ns) -> None:
        self._noted = NOTED * period_ns
        self._sum: Ns = 0
        self._longest: Ns = 0
        self._next: Ns | None = None  # no sentence before

    def late(self, by_ns: Ns) -> None:
        """Note that a SYNC left this long after its grid instant; a delay that no drive would notice is ignored."""
        if by_ns >= self._noted:
            self._sum, self._longest = self._sum + by_ns, max(self._longest, by_ns)

    def take_words(self, now: Ns) -> str:
        """Return the sentence that is due; empty: none."""
        if not self._sum or (self._next is not None and now < self._next):
            return ""
        words = f"this machine was late: simulated time waited {self._sum // ms(1)} ms, at most {self._longest // ms(1)} ms at once"
        self._sum, self._longest, self._next = 0, 0, now + EVERY_NS
        return words
