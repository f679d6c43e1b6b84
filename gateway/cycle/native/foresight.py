"""Limits that the path ahead sets on a change of speed, in C; the twin: motion.timing.foresight (AX-609)."""

from types import ModuleType
from typing import ClassVar, cast

from motion.timing.foresight import Foresight
from motion.timing.track import Span
from motion.timing.window import Window

Found = tuple[float, float, tuple[int, int] | None]  # c, the room for it, rows that are needed
EVERY = 1 << 60  # rows


class QuickForesight(Foresight):
    """One call a period."""

    part: ClassVar[ModuleType]

    def most(self, span: Span, omega: float, left: float, u: float) -> tuple[float, float]:
        most_u, most_c = self.part.most(span.rows, omega, left, u)
        return most_u, most_c

    def step(self, tau: float, w: float, u: float, wanted: float) -> float:
        if not self.begun:
            self._begin(u)
        track = self._track
        seen, past = track.view
        c, self.room, rows = self._found(seen, seen.low, past, tau, w, u, wanted)
        if rows is not None:
            track.show(*rows)
            c, self.room, _ = self._found(seen, -EVERY, EVERY, tau, w, u, wanted)
        self._steady = True
        return c

    def __reduce__(self) -> tuple[object, ...]:
        """A recording keeps the twin in this state: a replay does not need C (AX-484)."""
        return Foresight, (self._track, self._h), {name: value for name, value in vars(self).items() if name != "_native"}

    def _found(self, seen: Window, first: int, past: int, *now: float) -> Found:
        """Where rows before `first` or from `past` on are needed: which they are, the first and the last one."""
        steady, turns, inverse = self._steady, self._track.turns or None, self._track.inverse
        found = self.part.step(self._native, seen.rows, seen.low, seen.end, first, past, inverse, self._foreseen, steady, *now, turns)
        return cast(Found, found)

    def _set_up(self, ramp: float) -> None:
        super()._set_up(ramp)
        ahead = self.horizon
        self._native = self.part.ahead(self._track.columns, ahead.places, ahead.apart, self._h, ahead.most_u, ahead.most_c, ahead.probe)
