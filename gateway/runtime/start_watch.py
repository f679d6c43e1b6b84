"""Whether a process without a sign of life may still be starting: a busy computer prolongs a start, a hung process is detected."""

import contextlib
from dataclasses import dataclass

from gateway.runtime.realtime import processor_ns, wants_processor

READY_NS = 20_000_000_000  # patience until the first sign of life; time in which it gets no processor does not count
LONGEST_NS = 120_000_000_000  # but no longer than this


@dataclass(slots=True)
class StartWatch:
    """One start, looked at every few milliseconds."""

    started_ns: int
    _looked_ns: int = 0
    _starved_ns: int = 0  # it needed a processor

    def due(self, now: int, pid: int | None) -> bool:
        """Its first sign of life is overdue.  pid None: it is just started again."""
        if pid is None:
            return False
        age, elapsed, self._looked_ns = now - self.started_ns, now - (self._looked_ns or self.started_ns), now
        used = 0
        if age > READY_NS // 2:  # before that nothing has to be decided
            with contextlib.suppress(OSError):
                used = processor_ns(pid)
                self._starved_ns += elapsed if wants_processor(pid) else 0
        return age - max(self._starved_ns - used, 0) >= READY_NS or age >= LONGEST_NS
