"""The pieces a stepper has been given, to look at what comes: axes at a time at full speed, and that time for a sample."""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass, field
from operator import attrgetter, itemgetter

from motion.execution.stepper import Sample
from motion.execution.timed import TimedPiece

HALVINGS = 14
KEPT = 64  # completed pieces kept
NUMBER, WAY = attrgetter("id"), itemgetter(-3)  # of a piece; of a node


@dataclass(slots=True)
class Chain:
    """Timed pieces in their order, tau = 0 where the first one begins."""

    _pieces: list[TimedPiece] = field(default_factory=list)
    _begins: list[float] = field(default_factory=list)

    @property
    def end(self) -> float:
        """tau of the end of everything."""
        return self._begins[-1] + self._pieces[-1].duration if self._pieces else 0.0

    def load(self, piece: TimedPiece) -> None:
        """Behind the others; a new tail drops those from its id on, a lower id begins a new chain."""
        while self._pieces and self._pieces[-1].id >= piece.id:
            self._pieces.pop()
            self._begins.pop()
        self._begins.append(self.end)
        self._pieces.append(piece)

    def clear(self) -> None:
        """Nothing is known any more."""
        self._pieces.clear()
        self._begins.clear()

    def tau(self, sample: Sample) -> float | None:
        """Time at full speed of a sample; None when its piece is not known.  Searched along the way, which never runs back."""
        index = bisect_left(self._pieces, sample.piece_id, key=NUMBER)
        if index == len(self._pieces) or self._pieces[index].id != sample.piece_id:
            return None
        if index > KEPT:
            del self._pieces[: index - KEPT], self._begins[: index - KEPT]
            index = KEPT
        piece = self._pieces[index]
        s = sample.s
        k = min(max(bisect_right(piece.nodes, s, key=WAY) - 1, 0), len(piece.nodes) - 2)
        f, e, d, c, b, a = piece.quintics[k][-1]
        low, high = 0.0, piece.times[k + 1] - piece.times[k]
        for _ in range(HALVINGS):
            u = 0.5 * (low + high)
            if ((((f * u + e) * u + d) * u + c) * u + b) * u + a < s:
                low = u
            else:
                high = u
        return self._begins[index] + piece.times[k] + high

    def at(self, tau: float, resting: tuple[float, ...]) -> tuple[float, ...]:
        """Axes (n,) there; `resting`: of axes that have no part in the piece."""
        index = min(max(bisect_right(self._begins, tau) - 1, 0), len(self._pieces) - 1)
        piece = self._pieces[index]
        u = min(max(tau - self._begins[index], 0.0), piece.duration)
        k = min(max(bisect_right(piece.times, u) - 1, 0), len(piece.times) - 2)
        u -= piece.times[k]
        q, row = list(resting), piece.quintics[k]
        for n, axis in enumerate(piece.axes):
            f, e, d, c, b, a = row[n]
            q[axis] = ((((f * u + e) * u + d) * u + c) * u + b) * u + a
        return tuple(q)
