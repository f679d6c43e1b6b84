"""Teach points of programs: those assigned since the start, then those of the feed, then those of the point file.  Pure."""

from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.base.faults import Faults


class TeachPoints:
    """Points by program and name."""

    def __init__(self, memory: Memory, feed: Feed) -> None:
        self._memory, self._feed = memory, feed
        self._files: dict[str, dict[str, tuple[float, ...]]] = {}
        self._kept: dict[str, dict[str, tuple[float, ...]]] = {}  # program -> points assigned since the start

    def get(self, program: str, name: str) -> tuple[float, ...] | None:
        """None: not defined."""
        found = self._kept.get(program, {}).get(name) or self._feed.points.get(program, {}).get(name)
        if found is None:
            if program not in self._files:
                self._files[program] = self._memory.points(program, Faults())
            found = self._files[program].get(name)
        return found

    def keep(self, program: str, name: str, value: tuple[float, ...]) -> None:
        """Stores an assigned point in the point file, too."""
        if self._kept.setdefault(program, {}).get(name) != value and None not in value:
            self._kept[program][name] = value
            self._memory.keep_point(program, name, value)

    def forget(self, program: str) -> None:
        """The point file was replaced: it is read again."""
        self._files.pop(program, None)
        self._kept.pop(program, None)
