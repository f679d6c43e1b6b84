"""Run a chain of timed pieces: control the time along the path, forward and back (design 6; motion.md goals 9, 10).

tau is the time at full speed, omega = dtau/dt the share of it that is driven, u = d omega/dt, c = du/dt.
by tau are kept in a track (motion.timing.track); c is computed from it (motion.timing.change), so that every axis keeps its limits
while omega changes.  Retrace is omega < 0: the same path, the same limits.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice, pairwise
from math import ceil
from typing import NamedTuple

from motion.errors import LatePieceError, PieceError
from motion.execution.chain import Tail, TimedChain
from motion.execution.timed import Quintic, TimedPiece
from motion.timing.change import MOST, Change
from motion.timing.foresight import Foresight
from motion.timing.guard import correction
from motion.timing.track import Rows, Track

HISTORY = 1024  # completed pieces kept for retrace
WAITING = 1536  # pieces that may wait: one law after two seconds of others
LONGEST_S = 4e-3  # a period longer than this is driven in equal parts: of what lies between places further apart a change knows too little
ROUNDING = 1e-9
PAST = 3  # periods a third difference looks back
FORGOTTEN = 8  # pieces of the history dropped at most with a piece that comes: the work of a period stays bounded
BRAKING_S = 2.0  # before the end of the history going back is stopped: nowhere else does a path begin at speed
NEAR = 4  # pieces examined before a new one: together at least four periods
FIT, FIT_SPEED, FIT_ACCEL = 1e-9, 1e-6, 1e-4  # steps allowed where pieces meet: m or rad, shares of 1 + value


class Progress(NamedTuple):
    """Set values of one period."""

    axes: tuple[int, ...]  # of the piece
    places: list[float]  # of these axes, then of the way along the path, as the pieces count it
    speeds: list[float]  # of the same columns
    piece_id: int
    block: int
    done_id: int
    at_end: bool
    at_start: bool
    still: bool  # omega and u are 0

    @property
    def q(self) -> dict[int, tuple[float, float]]:
        """axis -> position, speed."""
        return {axis: (place, speed) for axis, place, speed in zip(self.axes, self.places, self.speeds, strict=False)}

    @property
    def way(self) -> float:
        """m along the path."""
        return self.places[-1]


_Held = tuple[float, float, float, float, tuple[Quintic, ...]]  # begin and end of a piece, of an interval in it, and its row
NOWHERE: _Held = (0.0, 0.0, 0.0, 0.0, ())


@dataclass(slots=True)
class _Place:
    """Where tau is in the chain."""

    index: int = 0  # of the piece under way
    interval: int = 0  # of that piece
    held: _Held = NOWHERE  # what was sampled last


class Follower:
    """See the module.  Raises PieceError on pieces that cannot follow, never in step()."""

    def __init__(self, axes: int, period_s: float, foresight: type[Foresight] = Foresight) -> None:
        self._axes, self._parts = axes, max(ceil(period_s / LONGEST_S - ROUNDING), 1)
        self._h = h = period_s / self._parts
        self._chain, self._tail = TimedChain(), Tail()
        self._at = _Place()
        self._track = Track(axes + 1, h)
        self._law = Change(self._track, h, foresight)
        self._tau = 0.0
        self._omega = self._u = 0.0
        self._done = 0
        self._places: list[float] = []  # of every column of the piece, where tau is now
        self._slopes: list[float] = []  # by tau
        self._past: deque[list[float]] = deque(maxlen=PAST)  # positions of the periods before, of the columns of the present piece

    # ---- loading -------------------------------------------------------------------------------------------------------
    @property
    def tau(self) -> float:
        """Time at full speed since the chain began."""
        return self._tau

    @property
    def omega(self) -> float:
        """Share of full speed now; negative: going back."""
        return self._omega

    @property
    def waiting(self) -> int:
        """Number of pieces after the current one."""
        return max(len(self._chain.pieces) - self._at.index - 1, 0)

    @property
    def pending(self) -> list[TimedPiece]:
        """Of a tail that is not complete yet."""
        return list(self._tail.pieces)

    @property
    def ahead(self) -> list[TimedPiece]:
        """The current piece, the pieces after it, and the pending tail."""
        return [*islice(self._chain.pieces, self._at.index, None), *self._tail.pieces]

    @property
    def last(self) -> TimedPiece | None:
        """The piece everything committed ends with."""
        return self._chain.last

    def load(self, piece: TimedPiece) -> None:
        """Run this piece when those before it are done.  It counts from the moment the tail it belongs to ends at rest."""
        if piece.new_tail:
            self._tail.drop()
        else:
            self._check_join(self._tail.pieces[-1] if self._tail.pieces else self.last, piece)
        if len(self._tail.pieces) + 1 + self.waiting > WAITING:
            self._tail.drop()
            raise PieceError(f"piece {piece.id}: {WAITING} pieces are waiting already")
        self._prepare(piece)
        if piece.ends_at_rest:
            self._commit(*self._tail.take())

    def uncommit(self) -> None:
        """The tail that is not complete is dropped; nothing of it has begun."""
        self._tail.drop()

    def _prepare(self, piece: TimedPiece) -> None:
        """Do the slow part of the work for one piece."""
        chain, pending = self._chain, self._tail.pieces
        begin, at = self._tail.next, len(chain.pieces)
        if not pending:
            if piece.new_tail:
                at = chain.place_of(piece.id)
            begin = chain.begins[at] if at < len(chain.pieces) else chain.end
        elif pending[0].new_tail and len(pending) < NEAR:
            at = chain.place_of(pending[0].id)
        before = [*reversed(pending[-NEAR:]), *(chain.pieces[k] for k in range(at - 1, max(at - NEAR, 0) - 1, -1))]
        piece.quintics  # noqa: B018 - worked out here, not in the middle of the piece
        self._track.rate(piece)
        self._law.prepare()
        rows = self._track.prepared(piece, before[:NEAR], begin, (*piece.axes, self._axes), self._law.apart)
        self._tail.add(piece, rows, begin)

    def _commit(self, tail: list[TimedPiece], rows: list[Rows]) -> None:
        if tail[0].new_tail:
            self._cut(tail[0])
        self._law.disturbed()
        self._at.held = NOWHERE
        for piece, table in zip(tail, rows, strict=True):
            self._chain.append(piece)
            self._track.append(table)
        for _ in range(min(self._at.index - HISTORY, FORGOTTEN * len(tail))):
            self._chain.forget()
            self._track.forget()
            self._at.index -= 1

    def _cut(self, first: TimedPiece) -> None:
        """Drop the waiting pieces from this id on; they must not have begun."""
        chain, here = self._chain, self._at.index
        at = chain.place_of(first.id)
        if at < len(chain.pieces) and (at < here or (at == here and self._tau > chain.begins[at])):
            raise LatePieceError(f"piece {first.id}: is too late to replace what has begun")
        self._check_join(chain.pieces[at - 1] if at else None, first)
        while len(chain.pieces) > at:
            chain.pop()
            self._track.pop()

    def _check_join(self, before: TimedPiece | None, piece: TimedPiece) -> None:
        if before is None:
            states: dict[int, tuple[float, ...]] = {}
        else:
            states = {axis: before.nodes[-1][3 * k : 3 * k + 3] for k, axis in enumerate(before.axes)}
            if piece.id <= before.id:
                raise PieceError(f"piece {piece.id}: follows piece {before.id}, ids must rise")
        for k, axis in enumerate(piece.axes):
            q, v, a = piece.nodes[0][3 * k : 3 * k + 3]
            p, w, b = states.pop(axis, (q, 0.0, 0.0))
            if abs(q - p) > FIT or abs(v - w) > FIT_SPEED * (1 + abs(w)) or abs(a - b) > FIT_ACCEL * (1 + abs(b)):
                raise PieceError(f"piece {piece.id}: axis {axis} continues at {q, v, a}, it ended at {p, w, b}")
        if any(abs(state[1]) > FIT_SPEED for state in states.values()):
            raise PieceError(f"piece {piece.id}: an axis that still moves has no part in it")

    # ---- running -------------------------------------------------------------------------------------------------------
    def step(self, wanted: float) -> Progress:
        """One period further; wanted: share of full speed, -1 .. 1."""
        if wanted < 0.0 and self._forgotten:
            wanted = 0.0
        self._part(wanted)
        for _ in range(self._parts - 1):
            if self._tau < self._chain.end and (self._tau > 0.0 or self._omega >= 0.0):
                self._part(wanted)
        return self._progress()

    def _part(self, wanted: float) -> None:
        """Of a period; all of it where it is short."""
        past = self._past
        if self._omega == wanted and self._u == 0.0:
            self._tau += self._omega * self._h
            self._track.foresee(self._tau, self._omega)
            self._sample()
        else:
            self._change(wanted)
            self._sample()
            if len(past) == PAST and self._correct():
                self._sample()
        past.append(self._places)

    @property
    def _forgotten(self) -> bool:
        """Return whether the oldest kept piece is near although the path began before it."""
        oldest = self._chain.begins[0]
        return oldest > 0.0 and self._tau < oldest + BRAKING_S

    @property
    def within(self) -> float:
        """Time at full speed since the piece under way began."""
        begins = self._chain.begins
        return self._tau - begins[self._at.index] if begins else 0.0

    @property
    def _begins_here(self) -> bool:
        """The path begins or ends at rest at this very place: any omega may be the first one."""
        tau, begins, here = self._tau, self._chain.begins, self._at.index
        if tau in (0.0, self._chain.end):
            return True
        at = next((k for k in (here, here + 1) if k < len(begins) and begins[k] == tau), None)
        node = self._chain.pieces[at].nodes[0] if at is not None else ()
        return at is not None and all(abs(v) <= FIT and abs(a) <= FIT for v, a in zip(node[1::3], node[2::3], strict=True))

    def _change(self, wanted: float) -> None:
        """One period of a change of speed, towards the wanted omega."""
        h, w, u = self._h, self._omega, self._u
        forward = self._track.step if wanted >= 0 else -self._track.step
        at_rest = self._track.at_rest(self._tau) and self._track.at_rest(self._tau + forward)
        if at_rest or (w == 0.0 and self._begins_here):
            self._omega, self._u = wanted, 0.0
            self._tau += wanted * h
            self._law.forget()
            return
        c = self._law.step(self._tau - h * (w + 0.5 * h * u), w, u, wanted)
        w, u = min(max(w + h * (u + h * c / 2), -MOST), MOST), u + h * c
        self._tau += h * (w + 0.5 * h * u)
        left = wanted - w
        inside = left * u >= 0.0 and 2 * abs(left) <= abs(u) * h
        if abs(u) / h + (0.0 if inside else 2 * abs(left) / h**2) <= self._law.room:
            w, u = wanted, 0.0  # lands inside the next period
            self._law.forget()
        self._omega, self._u = w, u

    # ---- sampling ------------------------------------------------------------------------------------------------------
    def _locate(self) -> _Held:
        """Piece and interval of the present tau."""
        chain, at, tau = self._chain, self._at, self._tau
        pieces, begins = chain.pieces, chain.begins
        if not begins[0] <= tau <= chain.end:
            tau = self._tau = min(max(tau, begins[0]), chain.end)
        last = len(pieces) - 1
        while at.index < last and tau >= begins[at.index + 1]:
            self._done = pieces[at.index].id
            self._enter(at.index + 1)
        while at.index > 0 and tau < begins[at.index]:
            self._enter(at.index - 1)
            self._done = pieces[at.index - 1].id if at.index else 0
        piece, begin, k = pieces[at.index], begins[at.index], at.interval
        till, times, u = begins[at.index + 1] if at.index < last else chain.end, piece.times, tau - begin
        while k < len(times) - 2 and u >= times[k + 1]:
            k += 1
        while k > 0 and u < times[k]:
            k -= 1
        at.interval = k
        at.held = begin, till, times[k], times[k + 1], piece.quintics[k]
        return at.held

    def _enter(self, index: int) -> None:
        """Another piece is under way."""
        pieces, here = self._chain.pieces, self._at.index
        before, after = pieces[min(index, here)], pieces[max(index, here)]
        if before.mask != after.mask or abs(before.nodes[-1][-3] - after.nodes[0][-3]) > FIT:
            self._past.clear()  # other axes, or another path: the way begins anew, at rest
        self._at.index, self._at.interval = index, 0

    def _sample(self) -> None:
        """Position and slope by tau of every column of the piece, where tau is now."""
        begin, till, first, last, row = self._at.held
        if not (begin <= self._tau < till and first <= self._tau - begin < last):
            begin, _, first, _, row = self._locate()
        u = self._tau - begin - first
        self._places, self._slopes = places, slopes = [], []
        for f, e, d, c, b, a in row:  # appended: a comprehension costs a call
            places.append(((((f * u + e) * u + d) * u + c) * u + b) * u + a)
            slopes.append((((5.0 * f * u + 4.0 * e) * u + 3.0 * d) * u + 2.0 * c) * u + b)

    def _correct(self) -> bool:
        """Move tau a little where the set values would leave the limits; whether it was moved."""
        h, piece = self._h, self._chain.pieces[self._at.index]
        three, two, one = self._past
        rows = zip(self._places, self._slopes, one, two, three, piece.accel, piece.jerk, strict=True)
        more = correction(list(rows), self._omega, self._u, h)
        if more == 0.0:
            return False
        more = self._law.bounded(self._u, more)
        self._law.disturbed()
        self._u += h * more
        self._omega = min(max(self._omega + 0.5 * h * h * more, -MOST), MOST)
        self._tau += h * h * h * more
        return True

    def _progress(self) -> Progress:
        chain, index, tau = self._chain, self._at.index, self._tau
        piece = chain.pieces[index]
        at_end = tau >= chain.end and index == len(chain.pieces) - 1
        if at_end:
            self._done, self._u, self._omega = piece.id, 0.0, 0.0
        if tau <= 0.0 and self._omega < 0.0:
            self._u = self._omega = 0.0
        w = self._omega + self._h * self._u  # where the set value is: a period ahead of what was decided
        still = self._omega == 0.0 and self._u == 0.0
        speeds: list[float] = []
        for slope in self._slopes:
            speeds.append(slope * w)
        at_start = tau <= 0.0 or (still and self._forgotten)
        return Progress(piece.axes, self._places, speeds, piece.id, piece.block, self._done, at_end, at_start, still)


def joined(pieces: Sequence[TimedPiece]) -> bool:
    """Return whether each piece continues the previous one; a planner checks this before it commits."""
    probe = Follower(max(max(piece.axes) for piece in pieces) + 1, 1e-3)
    try:
        for before, after in pairwise(pieces):
            probe._check_join(before, after)
    except PieceError:
        return False
    return True
