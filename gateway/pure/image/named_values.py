"""Named values of a cell: what telegrams write and read (order.number ..), with quality and stamp.  Source: design.md 5; users.md 3.5.

Only names of the cell file exist, so the table does not grow.  A signal is a value with a count of its writes: code that acts on it
compares counts and so handles each write once, however late it looks.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from gateway.pure.image.records.cell import Quality
from protocols.base.machine import Ns
from protocols.telegrams.fields import Value


@dataclass(frozen=True, slots=True)
class Sample:
    """A present value.  BAD: never written.  STALE: its source is away; the value is the last one it wrote."""

    value: Value | None = None
    quality: Quality = Quality.BAD
    stamp_ns: Ns = 0
    source: str = ""  # line/telegram, or the tool that wrote it


class Values:
    """All named values.  KeyError: a name the cell does not use."""

    def __init__(self, names: Iterable[str], signals: Iterable[str] = ()) -> None:
        self.signals = frozenset(signals)
        self._samples = dict.fromkeys(sorted({*names, *self.signals}), Sample())
        for signal in self.signals:
            self._samples[signal] = Sample(0, Quality.GOOD)

    def __contains__(self, name: str) -> bool:
        return name in self._samples

    def names(self) -> list[str]:
        """Every name, sorted."""
        return list(self._samples)

    def sample(self, name: str) -> Sample:
        """Value, quality, stamp, source."""
        return self._samples[name]

    def get(self, name: str) -> Value:
        """The value, also a stale one (see its quality); KeyError if it was never written."""
        value = self._samples[name].value
        if value is None:
            raise KeyError(name)
        return value

    def put(self, name: str, value: Value, now: Ns, source: str) -> None:
        """A new value; a signal is given once more whatever `value` is."""
        if name in self.signals:
            self.give(name, now, source)
            return
        if name not in self._samples:
            raise KeyError(name)
        self._samples[name] = Sample(value, Quality.GOOD, now, source)

    def give(self, signal: str, now: Ns, source: str) -> None:
        """The signal, once."""
        count = self._samples[signal].value
        self._samples[signal] = Sample((count if isinstance(count, int) else 0) + 1, Quality.GOOD, now, source)

    def source_gone(self, source: str) -> None:
        """What came from there is old from now on; signals stay what they were."""
        for name, sample in self._samples.items():
            if sample.source.partition("/")[0] == source and sample.quality is Quality.GOOD and name not in self.signals:
                self._samples[name] = replace(sample, quality=Quality.STALE)
