"""Edges of the bits that telegrams carry.  The first telegram of a bit only sets its state (AX-141)."""

from collections.abc import Mapping


class Edges:
    """Of the names of one line's data blocks."""

    def __init__(self) -> None:
        self._levels: dict[str, float] = {}
        self._primed: set[str] = set()

    def restart(self) -> None:
        """The next telegram sets the state of every bit."""
        self._primed.clear()

    def of(self, name: str, levels: Mapping[str, float]) -> int:
        """1 rising, -1 falling, 0 none or not known yet."""
        if name not in levels:
            return 0
        before, now = self._levels.get(name, 0.0), levels[name]
        self._levels[name] = now
        if name not in self._primed:
            self._primed.add(name)
            return 0
        return (now > before) - (now < before)
