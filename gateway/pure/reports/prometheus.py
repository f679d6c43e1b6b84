"""The text format Prometheus reads (version 0.0.4): metrics with help and type, labels escaped, histograms cumulative."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
Labels = Mapping[str, str]


@dataclass(slots=True)
class Page:
    """Lines of one answer; every metric is named once."""

    _lines: list[str] = field(default_factory=list)

    def metric(self, name: str, kind: str, words: str, samples: Sequence[tuple[Labels, float]]) -> None:
        """kind: gauge | counter; nothing is printed for a metric without samples."""
        if not samples:
            return
        self._head(name, kind, words)
        self._lines += [f"{name}{labels(with_)} {number(value)}" for with_, value in samples]

    def histogram(self, name: str, words: str, seen: "Histogram") -> None:
        """Buckets with their upper borders, sum and count."""
        self._head(name, "histogram", words)
        total = 0
        for border, count in zip((*seen.borders, math.inf), seen.counts, strict=True):
            total += count
            self._lines.append(f"{name}_bucket{labels({'le': number(border)})} {total}")
        self._lines += [f"{name}_sum {number(seen.sum)}", f"{name}_count {total}"]

    def text(self) -> str:
        """Return the complete page."""
        return "\n".join(self._lines) + "\n"

    def _head(self, name: str, kind: str, words: str) -> None:
        self._lines += [f"# HELP {name} {words}", f"# TYPE {name} {kind}"]


@dataclass(slots=True)
class Histogram:
    """How often a value was at most each border."""

    borders: tuple[float, ...]
    counts: list[int] = field(default_factory=list)  # one for each border and one above
    sum: float = 0.0

    def __post_init__(self) -> None:
        self.counts = self.counts or [0] * (len(self.borders) + 1)

    def see(self, value: float) -> None:
        """One more value."""
        self.counts[sum(border < value for border in self.borders)] += 1
        self.sum += value


def labels(with_: Labels) -> str:
    """{command_source="plc",kind="line"}; empty where there are none."""
    escaped = (value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") for value in with_.values())
    inner = ",".join(f'{name}="{value}"' for name, value in zip(with_, escaped, strict=True))
    return f"{{{inner}}}" if inner else ""


def number(value: float) -> str:
    """As Prometheus writes it."""
    if math.isinf(value):
        return "+Inf" if value > 0 else "-Inf"
    return "NaN" if math.isnan(value) else repr(int(value)) if float(value).is_integer() and abs(value) < 1e15 else repr(float(value))
