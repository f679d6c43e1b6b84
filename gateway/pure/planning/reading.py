"""The planner's queue of statements, each processed in slices: a row of splines needs seconds, and the planner must show life and hand on
pieces meanwhile.  Pure.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from motion.timing.slices import Slices, Work


@dataclass
class Reading:
    """In the order in which it came."""

    _waiting: deque[Callable[[], Work[None]]] = field(default_factory=deque)
    _now: Slices[None] | None = None

    @property
    def busy(self) -> bool:
        """Something is not read to its end."""
        return self._now is not None or bool(self._waiting)

    @property
    def under_way(self) -> bool:
        """A statement is half read."""
        return self._now is not None

    def put(self, work: Callable[[], Work[None]]) -> None:
        """Queue a statement; it begins when the previous ones are done."""
        self._waiting.append(work)

    def go(self) -> bool:
        """A slice of the first; True: that one is done."""
        if self._now is None and self._waiting:
            self._now = Slices(self._waiting.popleft()())
        now = self._now
        if now is not None and now.go():
            self._now = None
        return self._now is None

    def stop(self) -> None:
        """Stop reading the current one; waiting statements may belong to another job."""
        self._now = None

    def forget(self) -> None:
        """All of it."""
        self._waiting.clear()
        self.stop()
