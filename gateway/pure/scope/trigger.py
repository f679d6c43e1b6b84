"""Trigger of a scope: a level passed, an edge or an error, with the records before it.

axis.A1.lag > 2.0        becomes true (it must have been false once: a level already passed triggers at its next crossing)
axis.A1.actual < -5
CTRL_ALLOW_RCI falls     rises, changes
error                    emergency, a spontaneous stop, or a faulty axis appears
"""

import re
from array import array
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from gateway.pure.image.signals import SignalList
from gateway.pure.scope.channels import FLAGS, AxisFact, Channel, ChannelError, Read, channel, stamp_ns

_FORM = re.compile(r"(?P<name>[\w.]+)\s*(?:(?P<sign>[<>])\s*(?P<level>-?\d+(?:\.\d+)?)|\s+(?P<edge>rises|falls|changes))")


class TriggerError(ValueError):
    """A trigger that cannot be read; the message shows the forms."""


@dataclass(frozen=True, slots=True)
class Trigger:
    """`fired(before, now)` judges two records that follow each other."""

    text: str
    fired: Callable[[bytes, bytes], bool]


def parse_trigger(text: str, axes: Sequence[AxisFact], signals: SignalList) -> Trigger:
    """Raises TriggerError."""
    if text.strip() == "error":
        return Trigger("error", _error(axes, signals))
    found = _FORM.fullmatch(text.strip())
    if found is None:
        raise TriggerError(f"{text!r}: NAME > LEVEL, NAME < LEVEL, NAME rises, falls or changes, or error")
    try:
        read = channel(found["name"], axes, signals).read
    except ChannelError as error:
        raise TriggerError(str(error)) from error
    if found["edge"]:
        return Trigger(text.strip(), _edge(read, found["edge"]))
    level, above = float(found["level"]), found["sign"] == ">"
    return Trigger(text.strip(), lambda before, now: _passed(read(before), read(now), level, above))


def _passed(before: float, now: float, level: float, above: bool) -> bool:
    return before <= level < now if above else before >= level > now


def _edge(read: Read, edge: str) -> Callable[[bytes, bytes], bool]:
    if edge == "rises":
        return lambda before, now: read(now) > read(before)
    if edge == "falls":
        return lambda before, now: read(now) < read(before)
    return lambda before, now: read(now) != read(before)


def _error(axes: Sequence[AxisFact], signals: SignalList) -> Callable[[bytes, bytes], bool]:
    names = ["cell.emergency", *(f"axis.{axis.name}.{flag}" for axis in axes for flag in ("fault", "lost") if flag in FLAGS)]
    reads = [channel(name, axes, signals).read for name in names]
    cause = channel("cell.stop_cause", axes, signals).read
    return lambda before, now: any(read(now) > read(before) for read in reads) or cause(now) not in (0.0, cause(before))


class Rows:
    """Rows of a recording that grows: one flat array, eight bytes a value, so ten minutes of 16 channels at 2 ms take 38 MB (AX-511)."""

    def __init__(self, width: int) -> None:
        self.width = width
        self.flat = array("d")

    def __len__(self) -> int:
        return len(self.flat) // self.width if self.width else 0

    def __getitem__(self, place: int) -> list[float]:
        """One row; IndexError beyond the end."""
        if not 0 <= place < len(self):
            raise IndexError(place)
        return self.flat[place * self.width : (place + 1) * self.width].tolist()

    def __iter__(self) -> Iterator[list[float]]:
        return (self[place] for place in range(len(self)))

    def value(self, place: int, column: int) -> float:
        """One value, without making its row."""
        return self.flat[place * self.width + column]

    def append(self, values: Iterable[float]) -> None:
        self.flat.extend(values)


class Capture:
    """Takes records in order; keeps `pre` before the trigger and `post` from it on.  Without a trigger it begins at once.

    `rows` are the values of the channels, `stamps` the SYNC each belongs to (ns); `lost` counts records that never came.
    """

    def __init__(self, channels: Sequence[Channel], post: int, pre: int = 0, trigger: Trigger | None = None) -> None:
        self._reads = [each.read for each in channels]
        self._pre: deque[bytes] = deque(maxlen=max(pre, 1))
        self._keep_pre, self._post, self._trigger = pre, post, trigger
        self.rows = Rows(len(self._reads))
        self.stamps = array("q")
        self.triggered_at: int | None = None  # place in rows
        self.lost = 0
        self._last = 0

    @property
    def full(self) -> bool:
        """All that was asked for is there."""
        return self.triggered_at is not None and len(self.rows) - self.triggered_at >= self._post

    def take(self, sequence: int, record: bytes) -> None:
        """The next record of the ring."""
        if self._last and sequence != self._last + 1:
            self.lost += sequence - self._last - 1
        self._last = sequence
        if self.full:
            return
        if self.triggered_at is None and not self._fires(record):
            self._pre.append(record)
            return
        self._keep(record)

    def _fires(self, record: bytes) -> bool:
        if self._trigger is not None and not (self._pre and self._trigger.fired(self._pre[-1], record)):
            return False
        kept = list(self._pre)[len(self._pre) - min(self._keep_pre, len(self._pre)) :]
        for before in kept:
            self._keep(before)
        self.triggered_at = len(self.rows)
        return True

    def _keep(self, record: bytes) -> None:
        self.stamps.append(stamp_ns(record))
        self.rows.append(read(record) for read in self._reads)
