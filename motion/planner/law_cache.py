"""Laws that were made for a comparison and are asked for again: found by the stretches they run along."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from motion.errors import MotionError
from motion.planner.quick_law import swift_work, width_s
from motion.planner.runs import Run
from motion.planner.sine_square_laws import shaped_law
from motion.planner.straight import straight_law
from motion.program.factors import Factors
from motion.timing.jerk import jerk_limited_work
from motion.timing.law import Law
from motion.timing.slices import Work

KEPT = 64  # laws; more than the comparison of one row makes


@dataclass(frozen=True)
class KnownLaws:
    """Of one machine.  The same stretches under the same factors have the same law."""

    _made: deque[tuple[Run, Factors, Law]] = field(default_factory=lambda: deque(maxlen=KEPT))

    def law(self, run: Run, factors: Factors) -> Work[Law]:
        """From rest to rest: closed form where all axes move straight, else near the time optimum.  Where axes swing its search begins at
        the quick law, which keeps the limits there."""
        for known, under, law in self._made:
            if under == factors and _same(known, run):
                return law
        law = shaped_law(run) or straight_law(run) or (yield from _sought(run))
        self._made.append((run, factors, law))
        return law

    def seconds(self, factors: Factors) -> Callable[[Run], Work[float]]:
        """Return the function for the duration of runs."""

        def taken(run: Run) -> Work[float]:
            return (yield from self.law(run, factors)).duration

        return taken

    def forget(self) -> None:
        """The path they belong to is dropped."""
        self._made.clear()


def _sought(run: Run) -> Work[Law]:
    try:
        begin = (yield from swift_work(run.path, run.limits, width_s(run.limits))).law if run.even else None
    except MotionError:
        begin = None
    return (yield from jerk_limited_work(run.path, run.limits, begin=begin))


def _same(one: Run, two: Run) -> bool:
    pairs = zip(one.stretches, two.stretches, strict=False)
    return len(one.stretches) == len(two.stretches) and all(a is b for a, b in pairs)
