"""Teach points of programs: those assigned since the start, then those of the feed, then those of the point file.  Pure."""

from collections.abc import Callable

from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.memory import Memory, Points
from gateway.pure.languages.base.faults import Faults


class TeachPoints:
    """Points by program and name.  file_of: of a program, the name of its source, which its point file bears too (L668)."""

    def __init__(self, memory: Memory, feed: Feed, file_of: Callable[[str], str]) -> None:
        self._memory, self._feed, self._file_of = memory, feed, file_of
        self._names: dict[str, str] = {}  # program -> name of its point file
        self._files: dict[str, dict[str, tuple[float, ...]]] = {}
        self._kept: dict[str, dict[str, tuple[float, ...]]] = {}  # program -> points assigned since the start

    def _file(self, program: str) -> str:
        """A point file that bears the name of the program is taken where the source has none."""
        if program not in self._names:
            file = self._file_of(program)
            own = self._memory.text(f"{file}.PKT") is None and self._memory.text(f"{program}.PKT") is not None
            self._names[program] = program if own else file
        return self._names[program]

    def get(self, program: str, name: str) -> tuple[float, ...] | None:
        """None: not defined."""
        found = self._kept.get(self._file(program), {}).get(name) or self._feed.points.get(program, {}).get(name)
        return self.of_file(program).get(name) if found is None else found

    def of_file(self, program: str) -> Points:
        """Those of the point file."""
        file = self._file(program)
        if file not in self._files:
            self._files[file] = self._memory.points(file, Faults())
        return self._files[file]

    def keep(self, program: str, name: str, value: tuple[float, ...]) -> None:
        """Stores an assigned point in the point file, too."""
        file = self._file(program)
        if self._kept.setdefault(file, {}).get(name) != value and None not in value:
            self._kept[file][name] = value
            self._memory.keep_point(file, name, value)

    def forget(self, file: str) -> None:
        """The point file was replaced: it is read again."""
        self._files.pop(file, None)
        self._kept.pop(file, None)
        self._names.clear()

    def forget_sources(self) -> None:
        """A source was replaced: programs may have other names."""
        self._names.clear()
