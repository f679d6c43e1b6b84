"""One route: a source sampled once per step, a target value with validity bit and life counter out of it (AX-395).

The source is a number, or None where it is invalid (a link is down, a value was never written, the bytes are no number).  Levels
follow the source; edges are output once, as a pulse, and need a sample before them: a state found when a source begins or comes back is
only adopted, so a bit that is still set starts nothing.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from protocols.base.machine import Ns, ms

LIFE = 1 << 16


class Edge(Enum):
    """What of the source is passed on."""

    LEVEL = "level"
    RISING = "rising"  # a pulse of 1 at 0 -> 1
    FALLING = "falling"  # a pulse of 1 at 1 -> 0
    CHANGE = "change"  # the value, from its first change on


class Loss(Enum):
    """What the target shows while the source is lost."""

    HOLD = "hold"
    ZERO = "zero"
    VALUE = "value"  # another value after a time; until then the last one


@dataclass(frozen=True, slots=True)
class RouteSettings:
    """target = source x scale + offset, inside low..high; a value beyond is not passed on."""

    name: str
    scale: float = 1.0
    offset: float = 0.0
    low: float = -math.inf
    high: float = math.inf
    edge: Edge = Edge.LEVEL
    pulse_ns: Ns = ms(100)
    debounce_ns: Ns = 0  # how long a source must be stable before it counts
    rate_ns: Ns = 0  # at least between two changes of the target; the last value always gets through
    loss: Loss = Loss.HOLD
    loss_value: float = 0.0  # as the target shows it
    loss_after_ns: Ns = 0
    command: bool = False  # 1 starts something: a 1 found when the source begins or comes back is passed on only where the target shows it


class Route:
    """`step` once per cycle; then `value` (None: nothing was ever to be written), `valid` and `life` are what the target shows."""

    def __init__(self, settings: RouteSettings) -> None:
        self.settings = settings
        self.value: float | None = None
        self.valid = False
        self.life = 0  # counts steps with a living source, 0..65535
        self.misfits = 0  # times a value did not fit the target
        self._lost_since: Ns | None = None
        self._alive = False
        self._seen: float | None = None  # last sample, for the debounce
        self._seen_since: Ns = 0
        self._before: float | None = None  # last settled sample, for edges
        self._pulse_until: Ns | None = None
        self._changed_ns: Ns | None = None
        self._misfit = False
        self._armed = False  # a command may start: its source has shown 0

    def step(self, now: Ns, source: float | None) -> bool:
        """True: value or validity are others than before."""
        before = (self.value, self.valid)
        if source is None or not math.isfinite(source):
            self._lose(now)
        else:
            self._follow(now, source)
        return (self.value, self.valid) != before

    def _follow(self, now: Ns, source: float) -> None:
        self.life = (self.life + 1) % LIFE
        if not self._alive:
            self._alive, self._lost_since, self._armed = True, None, not self.settings.command
            self._seen = self._before = self._changed_ns = None
        settled = self._settled(now, source)
        if settled is None:
            self._end_pulse(now)
            return
        wanted = self._wanted(now, settled)
        self._before = settled
        if wanted is not None:
            self._pass_on(wanted, now)

    def _settled(self, now: Ns, source: float) -> float | None:
        """The source once it has been stable long enough; None: not yet, the value before counts on."""
        if source != self._seen:
            self._seen, self._seen_since = source, now
        return source if now - self._seen_since >= self.settings.debounce_ns else None

    def _wanted(self, now: Ns, settled: float) -> float | None:
        """What the target is to show; None: leave it."""
        edge = self.settings.edge
        if edge is Edge.LEVEL:
            wanted = settled * self.settings.scale + self.settings.offset
            self._armed = self._armed or not wanted or wanted == self.value
            return wanted if self._armed else None
        if edge is Edge.CHANGE:
            moved = self._before is not None and settled != self._before
            fresh = moved or (self.valid and self.value is not None)
            return settled * self.settings.scale + self.settings.offset if fresh else None
        high = bool(settled) is (edge is Edge.RISING)
        if self._before is not None and high and bool(self._before) is not bool(settled):
            self._pulse_until = now + self.settings.pulse_ns
        return float(self._pulse_until is not None and now < self._pulse_until)

    def _end_pulse(self, now: Ns) -> None:
        if self._pulse_until is not None and now >= self._pulse_until:
            self.value, self._pulse_until = 0.0, None

    def _pass_on(self, wanted: float, now: Ns) -> None:
        fits = self.settings.low <= wanted <= self.settings.high
        self.misfits += not fits and not self._misfit
        self._misfit, self.valid = not fits, fits
        due = self._changed_ns is None or now - self._changed_ns >= self.settings.rate_ns
        if fits and wanted != self.value and due:
            self.value, self._changed_ns = wanted, now

    def _lose(self, now: Ns) -> None:
        settings = self.settings
        self._alive = self.valid = False
        if self._lost_since is None:
            self._lost_since = now
        if self._pulse_until is not None:
            self.value, self._pulse_until = 0.0, None
        if settings.loss is Loss.ZERO:
            self.value = 0.0
        elif settings.loss is Loss.VALUE and now - self._lost_since >= settings.loss_after_ns:
            self.value = settings.loss_value


class RouteTable:
    """All routes of a cell, compiled once."""

    def __init__(self, settings: Sequence[RouteSettings]) -> None:
        self.routes = tuple(Route(each) for each in settings)

    def step(self, now: Ns, sources: Sequence[float | None]) -> list[int]:
        """One sample for each route; which of them have another value or validity now."""
        return [n for n, (route, source) in enumerate(zip(self.routes, sources, strict=True)) if route.step(now, source)]
