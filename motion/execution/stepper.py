"""The stepper: one sample per SYNC, it controls the time along the path (design 6; goals 9, 10, 15).

It owns (s, sdot, sddot).  A load, an override change, stop, resume and abandon re-plan s(t) from the present state with
all limits of the piece; between them the plan is only sampled.  Call step() once per SYNC that is sent: a skipped SYNC
delays the path and never stretches a step.  Pure: period in, samples out.

Pieces of polynomials (one PTP each) run here; chains of timed pieces run in motion.execution.follower, with the same states and orders,
and can be retraced.  One kind follows the other at rest.
"""

from collections import deque
from collections.abc import Sequence
from enum import Enum, auto
from typing import NamedTuple

from motion.errors import MotionError, PieceError
from motion.execution.follower import FIT, Follower
from motion.execution.piece_run import PieceRun
from motion.execution.pieces import MAX_AXES, Piece
from motion.execution.run_on import RunOn
from motion.execution.timed import TimedPiece
from motion.timing.foresight import Foresight

QUEUE = 8  # pieces that may wait after the running one


class State(Enum):
    """What the path does; an override of 0 holds it in RUNNING."""

    IDLE = auto()  # no piece
    RUNNING = auto()
    STOPPING = auto()  # on the path, by stop() or abandon()
    STOPPED = auto()  # at rest on the path; resume() continues, abandon() drops the rest


IDLE, RUNNING, STOPPING, STOPPED = State  # a name in an Enum is looked up slowly, and these are in every period


class Sample(NamedTuple):
    """Set values for one SYNC."""

    q: tuple[float, ...]  # (axes,) m or rad
    qd: tuple[float, ...]  # (axes,) per s
    piece_id: int  # piece under way; 0: none
    s: float  # on that piece
    state: State
    done_id: int  # piece that ended last; stays until the next one ends; 0: none yet


class Stepper:
    """See the module.  Raises only on what its caller does wrong (MotionError, PieceError), never in step()."""

    def __init__(self, axes: int, period_s: float, position: Sequence[float] | None = None, foresight: type[Foresight] = Foresight) -> None:
        if not (1 <= axes <= MAX_AXES and 0 < period_s < 1):
            raise MotionError(f"{axes} axes (1 .. {MAX_AXES}), period {period_s} s (0 .. 1) do not fit")
        self._period, self._foresight = period_s, foresight
        self._q = [0.0] * axes if position is None else list(position)
        self._still = (0.0,) * axes
        self._queue: deque[Piece] = deque()
        self._run = PieceRun(period_s)
        self._override = 1.0
        self._state = IDLE
        self._abandon = False
        self._done = 0
        self._follower: Follower | None = None  # of the last chain of timed pieces; kept at its end, for retrace
        self._direction = 1  # of the chain; -1: retrace
        self._past: RunOn | None = None  # the way past the edge of a probe
        if len(self._q) != axes:
            raise MotionError(f"{len(self._q)} positions for {axes} axes")

    @property
    def period(self) -> float:
        """s."""
        return self._period

    def fresh(self, position: Sequence[float]) -> "Stepper":
        """Another one for the same axes, which rest there."""
        return Stepper(len(self._q), self._period, position, self._foresight)

    @property
    def state(self) -> State:
        """As in the last sample, or as changed by a call since."""
        return self._state

    @property
    def override(self) -> float:
        """0 .. 1, of the programmed speed."""
        return self._override

    @property
    def queued(self) -> int:
        """Number of pieces that wait after the running one."""
        return len(self._queue) + (self._follower.waiting if self._follower else 0)

    @property
    def remaining(self) -> float:
        """Way left on the running piece, in its s."""
        return self._run.remaining

    @property
    def within(self) -> float:
        """Time at full speed since the timed piece under way began."""
        return self._follower.within if self._follower else 0.0

    @property
    def ahead(self) -> list[TimedPiece]:
        """Timed pieces that are not run to their end yet."""
        if self._follower is None:
            return []
        return self._follower.pending if self._state is IDLE else self._follower.ahead

    def place(self, position: Sequence[float]) -> None:
        """The axes are here (after enabling, referencing); only without a piece."""
        if self._state is not IDLE or self._run.piece or self._queue:
            raise MotionError(f"the position can be set only while idle, the stepper is {self._state.name}")
        if len(position) != len(self._q):
            raise MotionError(f"{len(position)} positions for {len(self._q)} axes")
        if self._follower and list(position) != self._q:
            self._follower = None  # something else moved the axes: retrace is impossible
        self._q = list(position)

    def place_for(self, piece: Piece) -> None:
        """place() at the start of a piece; axes outside its mask stay."""
        position = list(self._q)
        for axis, value in zip(piece.axes, piece.start(), strict=True):
            position[axis] = value
        self.place(position)

    def load(self, piece: Piece | TimedPiece) -> None:
        """Queue this piece after the running one.  Raise PieceError when it does not continue the path."""
        if isinstance(piece, TimedPiece):
            self._load_timed(piece)
            return
        if self._past is not None:
            raise PieceError(f"piece {piece.id}: the axes run on past an edge, load it at rest")
        if self._follower and self._state is not IDLE:
            raise PieceError(f"piece {piece.id}: a chain of timed pieces is under way, load it at rest")
        self._follower = None
        if not piece.ends_at_rest:
            raise PieceError(f"piece {piece.id}: does not end at rest; only timed pieces may join while moving (AX-103)")
        if self._abandon:
            raise PieceError(f"piece {piece.id}: the path is being abandoned, load again at rest")
        if len(self._queue) >= QUEUE:
            raise PieceError(f"piece {piece.id}: {QUEUE} pieces are waiting already")
        if piece.axes[-1] >= len(self._q):
            raise PieceError(f"piece {piece.id}: axis {piece.axes[-1]} of its mask does not exist, there are {len(self._q)}")
        self._check_fit(piece)
        self._queue.append(piece)
        if self._state is IDLE:
            self._state = RUNNING

    def _load_timed(self, piece: TimedPiece) -> None:
        if self._abandon or self._run.piece or self._queue or self._past is not None:
            raise PieceError(f"piece {piece.id}: another piece is under way or being abandoned, load it at rest")
        if piece.axes[-1] >= len(self._q):
            raise PieceError(f"piece {piece.id}: axis {piece.axes[-1]} of its mask does not exist, there are {len(self._q)}")
        if self._follower is None or (self._state is IDLE and self._follower.last is not None and piece.id <= self._follower.last.id):
            self._check_fit(piece)
            self._follower = Follower(len(self._q), self._period, self._foresight)
        self._follower.load(piece)
        if self._state is IDLE and piece.ends_at_rest:
            self._state, self._direction = RUNNING, 1

    def begin_anew(self) -> None:
        """Forget the path run so far, which ends retrace.  Call only at rest."""
        if self._state is IDLE:
            self._follower = None

    @property
    def has_path(self) -> bool:
        """There is one to go back along, from rest."""
        return self._follower is not None and not self._abandon

    def retrace(self) -> None:
        """Go back along the chain of timed pieces, to its start at most; from rest.  resume() goes forward again."""
        if self._follower is None or self._state not in (STOPPED, IDLE) or self._abandon:
            raise MotionError(f"there is no path to retrace, the stepper is {self._state.name}")
        self._state, self._direction = RUNNING, -1

    @property
    def backward(self) -> bool:
        """It goes, or went last, back along its path."""
        return self._direction < 0

    def set_override(self, value: float) -> None:
        """0 .. 1 of the programmed speed; 0 holds on the path."""
        if not 0.0 <= value <= 1.0:
            raise MotionError(f"override {value} is outside 0 .. 1")
        self._run.stale = self._run.stale or value != self._override
        self._override = value

    def stop(self) -> None:
        """Stop on the path as fast as the limits allow; the remainder waits for resume() or abandon()."""
        if self._state is RUNNING:
            self._state, self._run.stale = STOPPING, True

    def resume(self) -> None:
        """Go on after stop(), also while still stopping, and forward again while retracing; nothing after abandon()."""
        if self._state is RUNNING:
            self._direction = 1
        if self._state in (STOPPING, STOPPED) and not self._abandon:
            self._state, self._run.stale, self._direction = RUNNING, True, 1

    def abandon(self) -> None:
        """Stop on the path, then drop the rest of the piece and everything that waits."""
        if self._state is IDLE:
            return
        self._abandon = True
        self.stop()
        if self._state is STOPPED:
            self._drop()

    def run_on(self, target: Sequence[float], speed: float) -> None:
        """The path is left here: straight to `target` (m or rad of every axis) at `speed` (per s, over all axes) at the present override,
        with no ramp at either end (rho 3 L6766-6768).  stop(), and an override of 0, rest at once; a speed of 0 goes nowhere."""
        self._drop()
        if speed > 0.0 and list(target) != list(self._q):
            self._past = RunOn(list(self._q), list(target), speed * self._period, self._override)
            self._state, self._direction = RUNNING, 1

    def uncommit(self) -> None:
        """Remove timed pieces whose tail does not end at rest yet; committed pieces run."""
        if self._follower is not None:
            self._follower.uncommit()

    def step(self) -> Sample:
        """The next sample, one period further."""
        if self._follower is not None and self._state is not IDLE:
            return self._follow(self._follower)
        if self._past is not None:
            return self._go_past(self._past)
        run = self._run
        if run.piece is None and self._state is not IDLE:
            self._next_piece()
        if run.piece is None:
            return Sample(tuple(self._q), self._still, 0, 0.0, self._state, self._done)
        run.step(run.piece, self._override, running=self._state is RUNNING)
        if self._state is STOPPING and run.at_rest:
            self._state = STOPPED
        return self._sample(run.piece)

    def _follow(self, follower: Follower) -> Sample:
        """One period of the chain."""
        wanted = self._direction * self._override if self._state is RUNNING else 0.0
        axes, places, speeds, piece_id, _, done, at_end, at_start, still = follower.step(wanted)
        if len(axes) == len(self._q):
            self._q, qd = places[:-1], speeds[:-1]
            q = self._q
        else:
            q, qd = self._q, list(self._still)
            for k, axis in enumerate(axes):
                q[axis], qd[axis] = places[k], speeds[k]
        self._done = done or self._done
        if at_end and self._direction > 0:
            self._state = IDLE
        elif still and self._state is STOPPING:
            self._state = STOPPED
        elif at_start and self._direction < 0 and self._state is RUNNING:
            self._state, self._direction = STOPPED, 1
        if self._abandon and self._state in (STOPPED, IDLE):
            self._drop()
        return Sample(tuple(q), tuple(qd), piece_id, places[-1], self._state, self._done)

    def _go_past(self, past: RunOn) -> Sample:
        """One period past the edge."""
        if self._state is STOPPING:
            self._state = STOPPED
        if self._abandon:
            self._drop()
        before, qd = self._q, self._still
        if self._state is RUNNING and self._override > 0.0:
            share = self._override / past.override if past.override > 0.0 else 1.0
            self._q = list(past.step(min(share, 1.0)))
            qd = tuple((b - a) / self._period for a, b in zip(before, self._q, strict=True))
            if past.arrived:
                self._drop()
        return Sample(tuple(self._q), qd, 0, 0.0, self._state, self._done)

    def _check_fit(self, piece: Piece | TimedPiece) -> None:
        """Each axis of the piece must start where it will be by then."""
        positions = dict(enumerate(self._q))
        for earlier in (*([self._run.piece] if self._run.piece else []), *self._queue):
            positions.update(zip(earlier.axes, earlier.end(), strict=True))
        for axis, value in zip(piece.axes, piece.start(), strict=True):
            if not abs(value - positions[axis]) <= FIT:
                raise PieceError(f"piece {piece.id}: starts at {value} on axis {axis}, which will be at {positions[axis]}")

    def _next_piece(self) -> None:
        if self._state is STOPPING:  # the piece ended before the stop could
            self._state = STOPPED
        if self._abandon:
            self._drop()
        if self._state is not RUNNING:
            return
        if not self._queue:
            self._state = IDLE
            return
        piece = self._queue.popleft()
        self._run.begin(piece)

    def _sample(self, piece: Piece) -> Sample:
        qd = list(self._still)
        s, arrived = self._run.place(piece, self._q, qd)
        if arrived:
            self._finish(piece)
        elif self._abandon and self._state is STOPPED and self._run.at_rest:
            self._drop()
        return Sample(tuple(self._q), tuple(qd), piece.id, s, self._state, self._done)

    def _finish(self, piece: Piece) -> None:
        """Come to rest at the end, report it, and release the place for the next piece."""
        self._done, self._run.piece = piece.id, None
        if self._abandon:
            self._drop()
        elif not self._queue:
            self._state = IDLE

    def _drop(self) -> None:
        self._queue.clear()
        self._follower, self._past = None, None
        self._run.piece, self._state, self._abandon = None, IDLE, False
