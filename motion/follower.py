"""Runs a chain of timed pieces: time along the path in its hands, forward and back (design 6; motion.md goals 9, 10).

tau is the time at full speed, omega = dtau/dt the share of it that is driven, u = d omega/dt, c = du/dt.  With the pieces' own
derivatives by tau every axis has the acceleration omega^2 q'' + u q' and the jerk omega^3 q''' + 3 omega u q'' + c q'.  |omega| <= 1 with
u = 0 is legal anywhere, because full speed is; what needs care is changing it.  So the follower always holds a way back: it takes the
strongest c for this period from which u can be brought to 0 again, in a straight ramp, with every axis inside its limits all the way,
and without overshooting the wanted omega.  Retrace is omega < 0: the same path, the same limits.
"""

import functools
from collections import deque
from collections.abc import Sequence
from itertools import pairwise
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motion.errors import PieceError
from motion.timed import TimedPiece

Array = NDArray[np.float64]
HISTORY = 1024  # pieces kept behind the present one, for retrace
WAITING = 1024  # pieces that may wait
FIT, FIT_SPEED, FIT_ACCEL = 1e-9, 1e-6, 1e-4  # steps allowed where pieces meet: m or rad, shares of 1 + value
STEPS = (1.0, 0.8, 0.6, 0.4, 0.2, 0.08, 0.0)  # of the strongest c
RAMPS = (1.02, 1.4, 2.0, 3.0, 5.0)  # of the shortest time in which u could come to 0
PLACE, FEWEST, MOST = 1.5, 8, 120  # a way back is looked at every so many steps of the track; number of places
ACCEL_TOP, JERK_TOP = 0.998, 1.01  # shares of the limits allowed while omega changes
STILL = 1e-9  # share of the limits below which the path itself stands: omega may be anything


class Progress(NamedTuple):
    """Set values of one period."""

    q: dict[int, tuple[float, float]]  # axis -> position, speed
    piece_id: int
    block: int
    way: float  # m along the path, as the pieces count it
    done_id: int
    at_end: bool
    at_start: bool
    still: bool  # omega and u are 0


class _Track:
    """Derivatives of all columns on an even grid of tau, as shares of the limits; grows at the end, can be cut there."""

    def __init__(self, columns: int, step: float, window: float) -> None:
        self.step, self.count = step, 0
        self._window = window  # over which the acceleration's change is told: what a judge of the set values sees
        self._store = np.zeros((1024, 5, columns))

    def cut(self, tau: float) -> None:
        """Forget what lies behind tau."""
        self.count = min(self.count, int(tau / self.step) + 1)

    def prepared(self, piece: TimedPiece, begin: float, first: int, where: Sequence[int]) -> Array:
        """Rows from `first` to the piece's end; where: column of each of the piece's columns."""
        last = int((begin + piece.duration) / self.step) + 1
        grid = np.arange(first, last) * self.step - begin
        rows = np.zeros((len(grid), 5, self._store.shape[2]))
        if len(grid) == 0:
            return rows
        accel, jerk = np.array(piece.accel), np.array(piece.jerk)
        slope, second = _derivatives(piece, np.clip(grid + 0.5 * self.step, 0.0, piece.duration))
        window = min(self._window, piece.duration)
        late = np.clip(grid + 0.5 * (self.step + window), window, piece.duration)
        early = late - window  # at its ends a piece is judged by itself alone
        third = (_derivatives(piece, late)[1] - _derivatives(piece, early)[1]) / (late - early)[:, None]
        accel = np.maximum(accel, np.abs(second))  # full speed itself is legal, whatever rounding says
        jerk = np.maximum(jerk, np.abs(third))
        for k, values in enumerate((slope / accel, second / accel, slope / jerk, second / jerk, third / jerk)):
            rows[:, k, list(where)] = values
        return rows

    def append(self, rows: Array) -> None:
        """Rows that `prepared` made for what comes next."""
        last = self.count + len(rows)
        while last > len(self._store):
            self._store = np.concatenate([self._store, np.zeros_like(self._store)])
        self._store[self.count : last] = rows
        self.count = last

    def at(self, tau: Array) -> Array:
        """(..., 5, columns)."""
        index = np.minimum(np.maximum((tau * (1.0 / self.step)).astype(np.intp), 0), max(self.count - 1, 0))
        found: Array = self._store[index]
        return found


def _derivatives(piece: TimedPiece, tau: Array) -> tuple[Array, Array]:
    """First and second derivatives of all columns, (n, columns)."""
    times = np.array(piece.times)
    index = np.clip(np.searchsorted(times, tau, side="right") - 1, 0, len(times) - 2)
    rows = np.array(piece.quintics)[index]
    u = (tau - times[index])[:, None]
    f, e, d, c, b = (rows[:, :, k] for k in range(5))
    first = (((5 * f * u + 4 * e) * u + 3 * d) * u + 2 * c) * u + b
    second = ((20 * f * u + 12 * e) * u + 6 * d) * u + 2 * c
    return first, second


class Follower:
    """See the module.  Raises PieceError on pieces that cannot follow, never in step()."""

    def __init__(self, axes: int, period_s: float, grid_s: float | None = None) -> None:
        self._axes, self._h = axes, period_s
        self._pieces: deque[TimedPiece] = deque()
        self._begins: deque[float] = deque()
        self._index = 0  # of the piece under way
        self._interval = 0
        self._track = _Track(axes + 1, grid_s or min(0.5 * period_s, 2e-3), period_s)
        self._pending: list[TimedPiece] = []
        self._rows: list[Array] = []  # of the pending pieces: worked out as they come, so that taking a long tail costs little
        self._next = (0.0, 0)  # tau and row at which the next pending piece begins
        self._tau = 0.0
        self._omega = self._u = 0.0
        self._ramp = 0.0  # s in which u comes to 0 on the way back that is held
        self._end = 0.0
        self._done = 0
        self._way = 0.0
        self._share, self._last_wanted = 0, 0.0  # number in STEPS that was good, and for which wanted omega

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
        """Pieces behind the one under way."""
        return max(len(self._pieces) - self._index - 1, 0)

    @property
    def last(self) -> TimedPiece | None:
        """The piece everything committed ends with."""
        return self._pieces[-1] if self._pieces else None

    def load(self, piece: TimedPiece) -> None:
        """Run this piece when those before it are done.  It counts from the moment the tail it belongs to ends at rest."""
        if piece.new_tail:
            self._pending, self._rows = [], []
        else:
            self._check_join(self._pending[-1] if self._pending else self.last, piece)
        if len(self._pending) + 1 + self.waiting > WAITING:
            self._pending, self._rows = [], []
            raise PieceError(f"piece {piece.id}: {WAITING} pieces are waiting already")
        self._prepare(piece)
        if piece.ends_at_rest:
            tail, rows, self._pending, self._rows = self._pending, self._rows, [], []
            self._commit(tail, rows)

    def _prepare(self, piece: TimedPiece) -> None:
        """Everything that takes time, one piece at a time."""
        if not self._pending:
            at = next((k for k, one in enumerate(self._pieces) if one.id >= piece.id), None) if piece.new_tail else None
            begin = self._end if at is None else self._begins[at]
            count = self._track.count
            self._next = (begin, count if at is None else min(count, int(begin / self._track.step) + 1))
        begin, first = self._next
        piece.quintics  # noqa: B018 - worked out here, not in the middle of the piece
        rows = self._track.prepared(piece, begin, first, (*piece.axes, self._axes))
        self._pending.append(piece)
        self._rows.append(rows)
        self._next = (begin + piece.duration, first + len(rows))

    def _commit(self, tail: list[TimedPiece], rows: list[Array]) -> None:
        if tail[0].new_tail:
            self._cut(tail[0])
        for piece, table in zip(tail, rows, strict=True):
            self._begins.append(self._end)
            self._pieces.append(piece)
            self._track.append(table)
            self._end += piece.duration
        while self._index > HISTORY:
            self._pieces.popleft()
            self._begins.popleft()
            self._index -= 1

    def _cut(self, first: TimedPiece) -> None:
        """Drop the waiting pieces from this id on; they must not have begun."""
        at = next((k for k, piece in enumerate(self._pieces) if piece.id >= first.id), len(self._pieces))
        if at < len(self._pieces) and (at < self._index or (at == self._index and self._tau > self._begins[at])):
            raise PieceError(f"piece {first.id}: comes too late to replace what has begun")
        self._check_join(self._pieces[at - 1] if at else None, first)
        while len(self._pieces) > at:
            self._pieces.pop()
            self._end = self._begins.pop()
        self._track.cut(self._end)

    def _check_join(self, before: TimedPiece | None, piece: TimedPiece) -> None:
        if before is None:
            states: dict[int, tuple[float, ...]] = {}
        else:
            states = {axis: before.nodes[-1][3 * k : 3 * k + 3] for k, axis in enumerate(before.axes)}
            if piece.id <= before.id:
                raise PieceError(f"piece {piece.id}: comes behind piece {before.id}, ids must rise")
        for k, axis in enumerate(piece.axes):
            q, v, a = piece.nodes[0][3 * k : 3 * k + 3]
            p, w, b = states.pop(axis, (q, 0.0, 0.0))
            if abs(q - p) > FIT or abs(v - w) > FIT_SPEED * (1 + abs(w)) or abs(a - b) > FIT_ACCEL * (1 + abs(b)):
                raise PieceError(f"piece {piece.id}: axis {axis} goes on at {q, v, a}, it was left at {p, w, b}")
        if any(abs(state[1]) > FIT_SPEED for state in states.values()):
            raise PieceError(f"piece {piece.id}: an axis that still moves has no part in it")

    # ---- running -------------------------------------------------------------------------------------------------------
    def step(self, wanted: float) -> Progress:
        """One period further; wanted: share of full speed, -1 .. 1."""
        if self._omega != wanted or self._u != 0.0:
            self._change(wanted)
        else:
            self._tau += self._omega * self._h
        self._tau = min(max(self._tau, 0.0), self._end)
        return self._progress()

    @property
    def within(self) -> float:
        """Time at full speed since the piece under way began."""
        return self._tau - self._begins[self._index] if self._begins else 0.0

    def _change(self, wanted: float) -> None:
        """c for this period, towards the wanted omega."""
        h, w, u = self._h, self._omega, self._u
        now = self._track.at(np.array([self._tau]))[0]
        ahead = self._track.at(np.array([self._tau + self._track.step * (1 if wanted >= 0 else -1)]))[0]
        if max(np.abs(now[:2]).max(), np.abs(ahead[:2]).max()) < STILL or (self._tau in (0.0, self._end) and w == 0.0):
            self._omega, self._u = wanted, 0.0
            self._tau += wanted * h
            return
        c, self._ramp = self._strongest(wanted, now)
        self._tau += h * (w + h * (u / 2 + h * c / 6))
        self._omega, self._u = min(max(w + h * (u + h * c / 2), -1.0), 1.0), u + h * c
        left = wanted - self._omega
        landing = left * self._u >= 0.0 and 2 * abs(left) < abs(self._u) * h
        rest = w**3 * now[4] + 3 * w * u * now[3] - self._u / h * now[2]
        if (landing and float(np.abs(rest).max()) <= JERK_TOP) or abs(left) < 1e-9 > abs(self._u) * h:
            self._omega, self._u = wanted, 0.0  # the landing ends inside the next period
        elif abs(self._u) < 1e-12:
            self._u = 0.0

    def _strongest(self, wanted: float, now: Array) -> tuple[float, float]:
        """(c, seconds u takes to 0 afterwards): the strongest of which the way back is certain; else the least bad one."""
        h, w, u, back = self._h, self._omega, self._u, self._ramp
        q1 = float(np.abs(now[2]).max())
        full = min(JERK_TOP / max(q1, 1e-9), 2.0 / h**2)  # c that would take the whole jerk of the busiest axis
        towards = 1.0 if wanted > w + 0.5 * u * back else -1.0
        low, high = self._room(now)
        edge = min(max((high if towards > 0 else low) * towards, 0.0), full) * towards
        if wanted != self._last_wanted:
            self._last_wanted, self._share = wanted, 0
        self._share = max(self._share - 2, 0)  # what was good a period ago is about what is good now
        for number in range(self._share, len(STEPS) + 1):
            self._share = number
            held = number == len(STEPS)
            choices = self._held(wanted) if held else self._ramps(edge * STEPS[number], wanted, towards, full)
            if not choices:
                continue
            strain = self._strain(choices)
            for k, choice in enumerate(choices):
                if strain[k] <= 1.0:
                    return choice
        left = max(back, h)  # by rounding none is certain: the way back that was, and not one that puts it off
        return -u / left, left - h

    def _ramps(self, c: float, wanted: float, towards: float, full: float) -> list[tuple[float, float]]:
        """Ways back after one period with c: none that overshoots the wanted omega, and the one that lands on it."""
        h, w, u = self._h, self._omega, self._u
        u1, w1 = u + h * c, w + h * (u + h * c / 2)
        if u1 == 0.0:
            return [(c, 0.0)]
        land = 2 * (wanted - w1) / u1 if u1 * towards > 0 else inf
        shortest = max(abs(u1) / full, h)  # c is constant over a period: nothing ends inside one
        choices = [(c, r) for r in (shortest * k for k in RAMPS) if r <= land]
        if 0.0 <= land <= shortest * RAMPS[-1] * 2:
            choices.append((c, land))
        return choices

    def _held(self, wanted: float) -> list[tuple[float, float]]:
        """Ways back that begin at once: landing on the wanted omega, and the one held before."""
        h, u = self._h, self._u
        if u == 0.0:
            return [(0.0, 0.0)]
        landing = 2 * (wanted - self._omega) / u
        return [(-u / r, max(r - h, 0.0)) for r in (landing, self._ramp) if r >= h * (1 - 1e-9)]

    def _room(self, now: Array) -> tuple[float, float]:
        """Bounds of c from the jerk of every axis here."""
        w, u = self._omega, self._u
        rest = w**3 * now[4] + 3 * w * u * now[3]
        slope = now[2]
        some = np.abs(slope) > 1e-9
        if not some.any():
            return -inf, inf
        one, two = (-JERK_TOP - rest[some]) / slope[some], (JERK_TOP - rest[some]) / slope[some]
        low, high = float(np.minimum(one, two).max()), float(np.maximum(one, two).min())
        return min(low, high), max(low, high)

    def _strain(self, choices: Sequence[tuple[float, float]]) -> Array:
        """For each (c for one period, then u to 0 within the ramp) the largest share of a limit on the whole way; <= 1 is good.

        Written for few calls of numpy: it decides what a step costs while speed changes.
        """
        h, w, u, tau = self._h, self._omega, self._u, self._tau
        table = np.array(choices)
        c, ramp = table[:, :1], table[:, 1:]
        u1, w1, tau1 = u + h * c, w + h * (u + h / 2 * c), tau + h * (w + h * (u / 2 + h / 6 * c))
        fall = -u1 / np.maximum(ramp, 1e-9) * (ramp > 0.0)
        places = int(min(max(float(ramp.max()) / (PLACE * self._track.step), FEWEST), MOST))
        shape = (len(choices), places + 2)
        rates = np.empty((3, *shape))  # u, omega, c
        taus = np.empty(shape)
        t = ramp * _shares(places)
        gone = fall * t
        rates[0, :, 2:] = u1 + gone
        rates[1, :, 2:] = w1 + t * (u1 + 0.5 * gone)
        rates[2, :, 2:] = fall
        taus[:, 2:] = tau1 + t * (w1 + t * (u1 / 2 + gone / 6))
        rates[0, :, 0:1], rates[0, :, 1:2] = u + 0.5 * h * c, u1
        rates[1, :, 0:1], rates[1, :, 1:2] = w + 0.5 * h * (u + 0.25 * h * c), w1
        rates[2, :, :2] = c
        taus[:, 0], taus[:, 1:2] = tau + 0.5 * h * w, tau1
        rows = self._track.at(taus)
        u_, w_, c_ = rates[0][:, :, None], rates[1][:, :, None], rates[2][:, :, None]
        square = w_ * w_
        accel = np.abs(square * rows[:, :, 1] + u_ * rows[:, :, 0]).reshape(shape[0], -1).max(axis=1)
        jerk = np.abs(w_ * (square * rows[:, :, 4] + (3 * u_) * rows[:, :, 3]) + c_ * rows[:, :, 2]).reshape(shape[0], -1).max(axis=1)
        strain = np.maximum(accel / ACCEL_TOP, jerk / JERK_TOP)
        strain[np.abs(w1 + 0.5 * u1 * ramp)[:, 0] > 1.0 + 1e-9] = 9.0
        return np.asarray(strain)

    # ---- sampling ------------------------------------------------------------------------------------------------------
    def _progress(self) -> Progress:
        pieces, begins = self._pieces, self._begins
        while self._index < len(pieces) - 1 and self._tau >= begins[self._index + 1]:
            self._done = pieces[self._index].id
            self._index, self._interval = self._index + 1, 0
        while self._index > 0 and self._tau < begins[self._index]:
            self._index -= 1
            self._interval, self._done = 0, pieces[self._index - 1].id if self._index else 0
        piece = pieces[self._index]
        at_end = self._tau >= self._end and self._index == len(pieces) - 1
        if at_end:
            self._done, self._u, self._omega = piece.id, 0.0, 0.0
        if self._tau <= 0.0 and self._omega < 0.0:
            self._u = self._omega = 0.0
        u = self._tau - begins[self._index]
        times, k = piece.times, self._interval
        while k < len(times) - 2 and u >= times[k + 1]:
            k += 1
        while k > 0 and u < times[k]:
            k -= 1
        self._interval = k
        return Progress(
            *self._values(piece, k, u - times[k]),
            piece.id,
            piece.block,
            self._way,
            self._done,
            at_end,
            self._tau <= 0.0,
            self._omega == 0.0 and self._u == 0.0,
        )

    def _values(self, piece: TimedPiece, interval: int, u: float) -> tuple[dict[int, tuple[float, float]]]:
        rows, omega = piece.quintics[interval], self._omega
        values: dict[int, tuple[float, float]] = {}
        for axis, (f, e, d, c, b, a) in zip(piece.axes, rows, strict=False):
            values[axis] = (
                ((((f * u + e) * u + d) * u + c) * u + b) * u + a,
                ((((5 * f * u + 4 * e) * u + 3 * d) * u + 2 * c) * u + b) * omega,
            )
        f, e, d, c, b, a = rows[-1]
        self._way = ((((f * u + e) * u + d) * u + c) * u + b) * u + a
        return (values,)


@functools.cache
def _shares(places: int) -> Array:
    """(1, places) rising to 1."""
    return np.linspace(1.0 / places, 1.0, places)[None, :]


def joined(pieces: Sequence[TimedPiece]) -> bool:
    """Whether each piece goes on as the one before it ends: what a planner checks before it commits."""
    probe = Follower(max(max(piece.axes) for piece in pieces) + 1, 1e-3)
    try:
        for before, after in pairwise(pieces):
            probe._check_join(before, after)
    except PieceError:
        return False
    return True
