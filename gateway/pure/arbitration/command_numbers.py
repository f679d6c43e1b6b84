"""Numbers a command of a data block needs: targets, speed, number, parity, override, by name, good, refused or not written (AX-610).

A refused number blocks every command until a good one is written; none of them outlives the link it came over.
"""

from collections.abc import Collection, Iterable, Mapping

START, NUMBER, PARITY, SPEED, OVERRIDE = "move.start", "move.number", "move.parity", "move.speed", "cell.override"


def is_target(name: str) -> bool:
    """move.X.target"""
    return name.startswith("move.") and name.endswith(".target")


class MoveNumbers:
    """What the PLC has written of them since the link began."""

    def __init__(self, names: Collection[str]) -> None:
        """`names`: every name the PLC's blocks declare."""
        self.target_names = sorted(name for name in names if is_target(name))
        self._names = frozenset(names)
        self._good: dict[str, float] = {}
        self._bad: dict[str, str] = {}

    def clear(self) -> None:
        """A lost link, or a start of the services: all of them are void."""
        self._good.clear()
        self._bad.clear()

    def put(self, name: str, value: float | None, words: str) -> None:
        """As written; None: refused, for the reason in `words`."""
        if value is None:
            self._good.pop(name, None)
            self._bad[name] = words
        else:
            self._bad.pop(name, None)
            self._good[name] = value

    def declared(self, name: str) -> bool:
        """A block of the PLC has an entry for it."""
        return name in self._names

    def seen(self, name: str) -> bool:
        """It was written since the link began, good or not."""
        return name in self._good or name in self._bad

    def refused(self, name: str) -> str:
        """Why it was refused; empty: it was not."""
        return self._bad.get(name, "")

    def missing(self, names: Iterable[str]) -> str:
        """Why the first of these cannot be used: refused, or declared and not written; empty: all can."""
        for name in names:
            if name in self._bad:
                return self._bad[name]
            if name in self._names and name not in self._good:
                return f"{name} has not been written since the link began; write it before the start"
        return ""

    @property
    def targets(self) -> Mapping[str, float]:
        """By the name of the axis."""
        return {name.split(".")[1]: self._good[name] for name in self.target_names if name in self._good}

    @property
    def speed(self) -> float:
        """0..1; full speed where no block has an entry for it."""
        return self._good.get(SPEED, 100.0) / 100.0
