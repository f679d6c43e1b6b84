"""A control of two servo boards with real steppers: what the tests of measuring stand on.

Board 1 holds axes 0 and 1 (incremental) with a probe and 8 high-speed inputs, board 2 axis 2 (absolute) without a probe.  The simulated
drives follow exactly, so the position at any instant is known from the plan itself, apart from the history's interpolation.
"""

from collections.abc import Callable, Sequence
from functools import cache

from motion.execution.pieces import Piece
from motion.execution.ptp import plan_ptp
from motion.execution.stepper import Sample, State, Stepper
from motion.geometry.limits import AxisLimits
from motion.measure.history import History
from motion.measure.inputs import Board, Edge, input_of
from motion.measure.mpos import MeasuredPosition
from motion.measure.until import Bench, MoveUntil, Outcome

P5_NS = 4_000_000
LRTAKT_NS = 1_000_000
FINE_NS = 10_000
BOARDS = {1: Board(frozenset({0, 1}), frozenset({0, 1})), 2: Board(frozenset({2}), frozenset(), probe=False)}
LIMITS = tuple(AxisLimits(f"A{n + 1}", -50.0, 50.0, 1.0, 10.0, 200.0, "mm") for n in range(3))


def bench(axes: Sequence[int] = (0, 1), period_ns: int = P5_NS, limits: Sequence[AxisLimits] = LIMITS) -> Bench:
    mine = tuple(limits[axis] for axis in axes)
    return Bench(tuple(axes), mine, BOARDS, History(3), MeasuredPosition(tuple(axes)), LRTAKT_NS, period_ns * 1e-9)


class Rig:
    """One stepper and the history its axes leave; the clock counts cycles.  The edge is told by an instant, as a drive stamps it."""

    def __init__(self, on: Bench, target: Sequence[float] = (1.0, 0.5, 0.0), limits: Sequence[AxisLimits] = LIMITS) -> None:
        self.bench, self.period_ns = on, round(on.period_s * 1e9)
        self.stepper = Stepper(3, on.period_s)
        self.piece: Piece = plan_ptp((0.0,) * 3, target, limits, mask=7)
        self.now_ns = 0
        self.samples: list[Sample] = []
        self.truth: list[tuple[float, ...]] = []
        on.history.add(0, (0.0,) * 3, (0.0,) * 3)

    def until(self, channel: int, value: bool = True, distance: Callable[[], float] = lambda: 0.0) -> MoveUntil:
        return MoveUntil(self.bench, self.stepper, input_of(channel), value, distance)

    def cycle(self, move: MoveUntil, edges: Sequence[Edge] = (), level: bool = False) -> Sample:
        """Positions of this cycle are in the history, then the next set values come."""
        coming = [e for e in edges if self.now_ns - self.period_ns < e.stamp_ns <= self.now_ns]
        sample = move.step(self.now_ns, coming, level)
        self.samples.append(sample)
        self.now_ns += self.period_ns
        self.bench.history.add(self.now_ns, sample.q, sample.qd)
        return sample

    def run(self, move: MoveUntil, edges: Sequence[Edge] = (), most: int = 2000) -> Outcome:
        """To the block's end; RUNNING after `most` cycles."""
        while move.outcome is Outcome.RUNNING and len(self.samples) < most:
            self.cycle(move, edges)
        return move.outcome


@cache
def _track(piece: Piece) -> list[tuple[tuple[float, ...], tuple[float, ...]]]:
    """Positions and speeds every 10 us, by a stepper of its own: nothing of the history is used."""
    stepper = Stepper(3, FINE_NS * 1e-9)
    stepper.load(piece)
    found: list[tuple[tuple[float, ...], tuple[float, ...]]] = [((0.0,) * 3, (0.0,) * 3)]
    while len(found) < 2 or stepper.state is State.RUNNING:
        sample = stepper.step()
        found.append((sample.q, sample.qd))
    return found


def undisturbed(piece: Piece, instant_ns: int) -> tuple[float, ...]:
    """Positions the piece has at an instant when nothing stops it."""
    track = _track(piece)
    q, qd = track[min(instant_ns // FINE_NS, len(track) - 1)]
    return tuple(a + v * (instant_ns % FINE_NS) * 1e-9 for a, v in zip(q, qd, strict=True))
