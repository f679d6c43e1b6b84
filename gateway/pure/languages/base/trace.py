"""What a program did, event by event, in virtual time: the form of `axisgate program trace --json`."""

from collections.abc import Iterator
from dataclasses import dataclass, field

Value = object  # what JSON can hold


@dataclass(slots=True)
class Trace:
    """Collects events in the order in which they happen."""

    _events: list[dict[str, Value]] = field(default_factory=list)

    def add(self, at_ns: int, process: str, line: int, event: str, **facts: Value) -> None:
        """One event; `at_ns` is virtual time since the start."""
        self._events.append({"t": round(at_ns / 1e9, 6), "process": process, "line": line, "event": event, **facts})

    def __iter__(self) -> Iterator[dict[str, Value]]:
        return iter(self._events)

    def __len__(self) -> int:
        return len(self._events)
