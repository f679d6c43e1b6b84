"""What of a program's path was handed to the cycle, and where on it the follower may be.  Pure."""

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from gateway.pure.image.records.planner import AHEAD
from motion.execution.follower import HISTORY
from motion.execution.timed import TimedPiece

SEEN_S = 0.0129  # longest piece that counts as completed while it runs: the planner sees the axes about a period late
LAST_S = 0.1  # of a path: a piece nearer to its end may have been the last one seen
UNSEEN = 100  # turns after which pieces count as run that the cycle was never seen on: they were shorter than a turn


@dataclass
class Chain:
    """Pieces of the current part, and when each begins: tau, at full speed since the part began.  last_id: of the last piece handed on;
    spare: of the next one: ids keep rising over jobs, so a chain never meets an older number.
    """

    last_id: int = 0
    spare: int = 1
    _begins: dict[int, float] = field(default_factory=dict)
    _passed: dict[int, int] = field(default_factory=dict)  # piece -> blocks that are over where it begins
    _ways: dict[int, TimedPiece] = field(default_factory=dict)  # those that last longer than SEEN_S
    _now: int = 0  # piece the cycle is on: before `_at` while it goes back
    _blocks: dict[int, int] = field(default_factory=dict)  # of this job, piece -> block it begins in
    _over: int = 0
    _at: int = 0  # last piece the cycle was seen on; 0: the part has not begun
    _rest: float | None = None  # tau at which it ran out, until it continues
    sent: int = 0  # record of the ring that it ends with
    _unseen: int = 0  # turns since pieces were handed on after a rest while the cycle was seen on none of them

    def begin(self) -> None:
        """A part, or none."""
        self._begins.clear()
        self._passed.clear()
        self._ways.clear()
        self._over = 0
        self._at, self._rest = 0, None

    def began(self) -> None:
        """Begin a job: the path run before is not available for retrace."""
        self._blocks.clear()
        self._now = 0
        self.begin()

    def add(self, made: TimedPiece, tau: float, passed: int = 0, before: int = 0) -> None:
        """Add a piece; passed: number of blocks completed before it.  A new tail replaces the pieces from its number on."""
        if made.new_tail:
            self._drop(number for number in list(self._begins) if number >= made.id)
        self._begins[made.id] = tau
        self._passed[made.id] = passed
        if made.duration > SEEN_S:
            self._ways[made.id] = made
        self._blocks[made.id] = before + passed + 1
        while len(self._blocks) > HISTORY + 2 * AHEAD:
            del self._blocks[next(iter(self._blocks))]
        self.last_id, self.spare = made.id, made.id + 1

    def tau(self, piece: int, end: float, *, waits: bool = False) -> float:
        """Where the follower may be at the latest: the end of the piece under way (0: none is), or of all there is (`end`) when it has run
        out.  waits: some of the pieces are in the ring as yet, so it has not."""
        piece = max(piece, self._at) if piece else 0  # also while it goes back
        if piece in self._begins:
            self._at, self._rest, self._unseen = piece, None, 0
            return self._begins.get(piece + 1, end)
        if self._at and not piece and (self._rest is None or self._at < self.last_id):
            if not waits:
                self._runs_out(end)
            if self._rest is None:
                return self._begins.get(self._at + 1, end)
        return 0.0 if self._rest is None else self._rest

    def near_to(self, tau: float, piece: int, places: Sequence[float], way: float) -> float:
        """tau() of a piece, on a long one no more than SEEN_S ahead of where the axes are.  places: of the axes of the cell; way: as the
        piece counts it."""
        made = self._ways.get(piece) if piece == self._at else None
        return tau if made is None else min(tau, self._begins[piece] + _time_at(made, places, way) + SEEN_S)

    def _runs_out(self, end: float) -> None:
        """The cycle is on no piece: all that was handed on is run, or it has not got the next one yet."""
        last = self._rest is None and (self._at == self.last_id or end - self._begins.get(self._at, end) <= LAST_S)
        self._unseen += 1
        if last or self._unseen > UNSEEN:
            self._at, self._rest, self._unseen = self.last_id, end, 0

    def sees(self, piece: int) -> None:
        """The cycle is on this piece; 0: at rest at the end of what it has."""
        self._now = piece

    @property
    def back(self) -> bool:
        """Return whether the cycle is on a piece that it had already completed."""
        return 0 < self._now < (self._at or next(iter(self._begins), self.spare) - 1) and self._now in self._blocks

    @property
    def block(self) -> int:
        """That it is in now, while it goes back; 0: not known any more."""
        return self._blocks.get(self._now, 0)

    def near(self, end: float) -> tuple[float, float]:
        """tau between which the cycle rests, that was on the way forward; end: of all there is."""
        at = self._at or min(self._begins, default=0)
        return self._begins.get(at, 0.0), self._begins.get(at + 2, end)

    def passed(self, piece: int, added: int) -> int:
        """Blocks that are over for certain.  added: all of them where nothing of the path is to come, else 0."""
        if piece in self._passed:
            self._over = max(self._over, self._passed[piece])
        elif not piece and self._all_run:
            self._over = max(self._over, added)
        return self._over

    @property
    def _all_run(self) -> bool:
        """All that was handed on is run, and not only what was before it; or nothing had a way."""
        return self._at == self.last_id if self._rest is not None else not self._begins

    @property
    def full(self) -> bool:
        """As many pieces wait as may."""
        return self.ahead >= AHEAD

    @property
    def ahead(self) -> int:
        """Pieces that are not run yet."""
        first = next(iter(self._begins), None)  # they rise by one each, up to the last one
        return 0 if first is None else max(self.last_id - max(self._at, first - 1), 0)

    def forget(self) -> None:
        """Forget the pieces that the cycle has completed."""
        while self._begins and (number := next(iter(self._begins))) < self._at - 1:
            self._drop((number,))

    def _drop(self, numbers: Iterable[int]) -> None:
        for number in numbers:
            del self._begins[number]
            del self._passed[number]
            self._ways.pop(number, None)


def _time_at(piece: TimedPiece, places: Sequence[float], way: float) -> float:
    """s since it began, by the way along the path, or the axis that goes furthest; its end where that is not known."""
    column, there = len(piece.axes), way
    if piece.nodes[0][-3] == piece.nodes[-1][-3]:  # joints alone have no way
        column = max(range(column), key=lambda k: abs(piece.nodes[-1][3 * k] - piece.nodes[0][3 * k]))
        if piece.axes[column] >= len(places):
            return piece.duration
        there = places[piece.axes[column]]
    sign = 1.0 if piece.nodes[-1][3 * column] >= piece.nodes[0][3 * column] else -1.0
    nodes, place = piece.nodes, 3 * column
    at = bisect_right(nodes, sign * there, key=lambda node: sign * node[place])
    if at == 0 or at == len(nodes):
        return piece.duration if at else 0.0
    before, after = piece.times[at - 1], piece.times[at]
    low, high = (sign * node[place] for node in nodes[at - 1 : at + 1])
    return before + (after - before) * (sign * there - low) / (high - low)
