"""Frames that leave later than their node made them, as a tester has ordered.  Pure."""

from bisect import insort

from drivers.emulator.canopen.guard import NEVER
from protocols.base.machine import Frame, Ns


class DelayedFrames:
    """In the order they are due; of two at once the older one first."""

    def __init__(self) -> None:
        self.due: Ns = NEVER  # of the next one
        self._waiting: list[tuple[Ns, int, Frame]] = []
        self._count = 0

    def add(self, frame: Frame, due: Ns) -> None:
        """It leaves at `due`."""
        self._count += 1
        insort(self._waiting, (due, self._count, frame))
        self.due = self._waiting[0][0]

    def take(self, now: Ns) -> list[Frame]:
        """Those that are due."""
        count = next((n for n, (due, _, _) in enumerate(self._waiting) if due > now), len(self._waiting))
        taken, self._waiting = [frame for _, _, frame in self._waiting[:count]], self._waiting[count:]
        self.due = self._waiting[0][0] if self._waiting else NEVER
        return taken

    def clear(self) -> None:
        """The port is lost."""
        self._waiting.clear()
        self.due = NEVER
