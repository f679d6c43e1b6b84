"""MOVE UNTIL: a block that an input ends.

Source: rho 3 Releases part 1, section 2 (L1100-1290); modified form part 2, section 3.2 (L6766-6795).  Call `begin` before the block is
loaded and `step` once a cycle instead of Stepper.step, after the positions of the cycle went into the history.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from math import hypot
from typing import Protocol

from motion.errors import LimitError
from motion.execution.run_on import RunOn
from motion.execution.stepper import Sample, State
from motion.geometry.limits import AxisLimits, check_targets
from motion.geometry.units import to_si
from motion.measure.history import History
from motion.measure.inputs import Board, Edge, InputKind, MeasuringInput
from motion.measure.mpos import MeasuredPosition, measured

STILL = 1e-9  # m/s or rad/s


class Outcome(Enum):
    """State of the block."""

    RUNNING = auto()
    MET = auto()  # the statement after the block is next, @MPOS is occupied
    NOT_MET = auto()  # the end point is reached: the ERROR part is next
    FAULT = auto()  # the axes stopped on the path; `fault` is the program's runtime error


class Path(Protocol):
    """What of motion.execution.stepper.Stepper is used."""

    @property
    def state(self) -> State:
        """What the path does."""
        ...

    def step(self) -> Sample:
        """The next set values."""
        ...

    def abandon(self) -> None:
        """Stop on the path, drop the rest."""
        ...

    def place(self, position: Sequence[float]) -> None:
        """The axes are here."""
        ...


@dataclass(frozen=True, slots=True)
class Bench:
    """What measuring needs of a kinematic.  axes: its axes' numbers in the control, in the order of its joint points; limits: of the axes;
    boards: servo boards by number; cycle_ns: LRTAKT; period_s: P5; history: of all axes of the control."""

    axes: tuple[int, ...]
    limits: tuple[AxisLimits, ...]
    boards: Mapping[int, Board]
    history: History
    mpos: MeasuredPosition
    cycle_ns: int
    period_s: float


@dataclass(slots=True)
class MoveUntil:
    """One such block.  distance: reads SF 42 (mm or deg), asked when the edge comes; only channel 7x0 uses it."""

    bench: Bench
    path: Path
    asked: MeasuringInput
    value: bool = True
    distance: Callable[[], float] = lambda: 0.0
    outcome: Outcome = Outcome.RUNNING
    fault: LimitError | None = field(default=None, init=False)
    _since_ns: int = field(default=0, init=False)
    _hit_ns: int | None = field(default=None, init=False)
    _taken: bool = field(default=False, init=False)
    _last: Sample | None = field(default=None, init=False)
    _run: RunOn | None = field(default=None, init=False)

    def begin(self, level: bool, now_ns: int) -> bool:
        """Return whether the block is to be loaded.  level: present level of the input.

        False: a normal or high-speed input has the value already; nothing moves, and the present position is the measured one (AX-455).  A
        probe must change, whatever its present state.
        """
        self._since_ns = now_ns
        if self.asked.by_edge or level != self.value:
            return True
        self.bench.mpos.take(self._now())
        self._hit_ns, self._taken, self.outcome = now_ns, True, Outcome.MET
        return False

    def step(self, now_ns: int, edges: Sequence[Edge], level: bool = False) -> Sample:
        """Set values of this cycle.  edges: since the last cycle; level: of a normal input."""
        if self.outcome is Outcome.RUNNING and self._hit_ns is None:
            self._look(now_ns, edges, level)
        if self._hit_ns is not None and not self._taken:
            self._measure(self._hit_ns)
        sample = self.path.step()
        if self._run is not None:
            sample = self._shown(sample, self._run.step())
        self._last = sample
        if self.outcome is Outcome.RUNNING and self.path.state is State.IDLE:
            self._ended()
        return sample

    def _look(self, now_ns: int, edges: Sequence[Edge], level: bool) -> None:
        if self.asked.kind is InputKind.NORMAL:
            hit = now_ns if level == self.value else None
        else:
            hit = next((edge.stamp_ns for edge in edges if self._counts(edge)), None)
            hit = None if hit is None else min(hit, now_ns)  # a stamp of the future is a partner's fault, the edge is real
        if hit is None:
            return
        self._hit_ns = hit
        oldest = self.bench.history.oldest_ns
        if self.asked.kind is InputKind.MODIFIED and oldest is not None and hit >= oldest:  # else it stops: from where on is not known
            self._run = self._run_on(hit)
        self.path.abandon()

    def _counts(self, edge: Edge) -> bool:
        """Return whether the edge counts: it must occur while the block is active (L1130)."""
        return edge.channel == self.asked.wire and edge.value == self.value and edge.stamp_ns >= self._since_ns

    def _measure(self, hit_ns: int) -> None:
        bench = self.bench
        values = measured(self.asked, hit_ns, bench.cycle_ns, bench.axes, bench.boards, bench.history)
        if values is not None:
            bench.mpos.take(values)
            self._taken = True

    def _ended(self) -> None:
        """The stepper has nothing left to do."""
        if self._hit_ns is None:
            self.outcome = Outcome.NOT_MET
        elif self._taken and (self._run is None or self._run.arrived):
            if self._run is not None and self._last is not None:
                self.path.place(self._last.q)  # POS is made anew (L6768)
            self.outcome = Outcome.FAULT if self.fault else Outcome.MET

    def _run_on(self, hit_ns: int) -> RunOn | None:
        """From the set values of the last cycle to the distance past the edge, in the direction the axes were going; None, and
        the fault: that place is outside the travel."""
        axes, last = self.bench.axes, self._last
        now = self._now() if last is None else [last.q[axis] for axis in axes]
        speeds = [0.0] * len(axes) if last is None else [last.qd[axis] for axis in axes]
        speed = hypot(*speeds)
        if speed < STILL:
            return RunOn(list(now), list(now), 0.0)
        way = to_si(self.distance(), self.bench.limits[0].unit)
        edge = self.bench.history.at(hit_ns)
        target = [edge[axis] + way * v / speed for axis, v in zip(axes, speeds, strict=True)]
        try:
            check_targets(self.bench.limits, target)
        except LimitError as fault:
            self.fault = fault
            return None
        return RunOn(list(now), target, speed * self.bench.period_s)

    def _now(self) -> tuple[float, ...]:
        newest = self.bench.history.newest_ns
        position = self.bench.history.at(newest) if newest is not None else ()
        return tuple(position[axis] for axis in self.bench.axes)

    def _shown(self, sample: Sample, own: Sequence[float]) -> Sample:
        q, qd = list(sample.q), list(sample.qd)
        for axis, value in zip(self.bench.axes, own, strict=True):
            before = self._last.q[axis] if self._last is not None else value
            q[axis], qd[axis] = value, (value - before) / self.bench.period_s
        return sample._replace(q=tuple(q), qd=tuple(qd))
