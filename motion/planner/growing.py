"""Laws of a growing row: quick ones, or refined ones where a quick law is hardly faster than stops in all corners (AX-961).

A quick law extends itself (motion.planner.quick_law).  A refined one changes over into a quick one that begins at rest a little way back;
both are refined together from the change-over on (motion.timing.splice).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motion.errors import MotionError
from motion.planner.committed import Origin, Planned, state_at
from motion.planner.corner_choice import PAUSE_S, stopping
from motion.planner.quick_law import STEP_S, cropped, swift_work, width_s
from motion.planner.robot import Machine
from motion.planner.runs import Run, make_run
from motion.planner.stretch import Stretch
from motion.planner.team import Team
from motion.program.factors import Factors
from motion.timing.law import Law
from motion.timing.refine import past_of, refined_work
from motion.timing.slices import Work
from motion.timing.splice import RUN_UP_S, led_over

Array = NDArray[np.float64]
WORTH = 0.75  # of the time of passing: stops in a row that still grows take less than this, or it is passed (AX-661)
SLOW = 1.25  # of it: where stops take less than this, the law is refined
REFINED_S = 2.0  # of a law at most, from where it begins
LONG_S = 0.4  # a shorter one stays quick: a refined law cannot change over just before its end, a quick one can
SMALLEST = 1e-9
BEHIND_S = 0.1  # after the place where the change-over is complete
NOTHING = "no law continues the present one within its acceleration and jerk"


class Grown(NamedTuple):
    """until: s of the law up to which it was led over from another one; past: s before it; later: stretches that
    were left for another law."""

    run: Run
    law: Law
    origin: Origin
    until: float = 0.0
    past: Array | None = None
    later: tuple[Stretch, ...] = ()

    def paused(self, at: float) -> "Grown":
        """Return a refined law that begins at rest after another one, so that their jerks do not add up (AX-317)."""
        return self._replace(law=self.law.later(PAUSE_S)) if self.origin.led and self.law.at_rest and at > 0.0 else self


class Growing:
    """Of one planner."""

    def __init__(self, machine: Machine | Team, factors: Factors) -> None:
        self._machine, self._factors = machine, factors

    def begun(self, row: Sequence[Stretch], at: float) -> Work[Grown | list[list[Stretch]]]:
        """From rest at tau = `at`; the runs with stops in all corners where these are that much quicker."""
        run = make_run(row, self._machine, self._factors)
        width = width_s(run.limits)
        made = yield from swift_work(run.path, run.limits, width)
        taken = made.law.duration
        stops, seconds = yield from stopping(row, self._machine, SLOW * taken, self._factors)
        if stops and seconds < WORTH * taken:
            return stops
        law = (yield from refined_work(run.path, run.limits, made.law, REFINED_S)) if stops and taken >= LONG_S else None
        return Grown(run, made.law, Origin(made, 0, width)) if law is None else Grown(run, law, Origin(None, 0, width, True)).paused(at)

    def gone_on(self, last: Planned, at: float, row: Sequence[Stretch]) -> Work[Grown]:
        """Continue the last law from tau = `at`.  Raise MotionError where no law continues it."""
        found = yield from self._along(last, at, row)
        before = last.end - at
        stops, seconds = yield from stopping(row, self._machine, SLOW * (found.law.duration - before), self._factors, moving=True)
        slow = bool(stops)
        found = (yield from self._refined(found, slow)).paused(at)
        if stops and seconds < WORTH * (found.law.duration - before):
            first = yield from self._along(last, at, stops[0])
            if first.law.duration + seconds < found.law.duration:
                later = tuple(each for part in stops[1:] for each in part)
                return (yield from self._refined(first, slow)).paused(at)._replace(later=later)
        return found

    def _along(self, last: Planned, at: float, row: Sequence[Stretch]) -> Work[Grown]:
        """A law to start from: one that keeps the limits where the last one is quick."""
        if last.quick is None:
            return (yield from self._led(last, at, row))
        sample = last.first + round((at - last.begin) / STEP_S)
        index = last.run.index(float(last.quick.law.s[sample]) + SMALLEST)
        history, cut = cropped(last.quick.shifted(last.run.starts[index]), sample, last.width)
        run = make_run([*last.run.stretches[index:], *row], self._machine, self._factors)
        made = yield from swift_work(run.path, run.limits, last.width, history, cut)
        law = Law(made.law.s[cut:], made.law.speed[cut:], made.law.accel[cut:], STEP_S, state_at(made.law, cut))
        return Grown(run, law, Origin(made, cut, last.width), law.duration, past_of(made.law, cut * STEP_S))

    def _led(self, last: Planned, at: float, row: Sequence[Stretch]) -> Work[Grown]:
        """The last law, led over into a quick one."""
        before, k = last.law, round((at - last.begin) / last.law.step)
        index = last.run.index(float(before.s[max(k - round(RUN_UP_S / before.step), 0)]) + SMALLEST)
        run = make_run([*last.run.stretches[index:], *row], self._machine, self._factors)
        fresh = yield from swift_work(run.path, run.limits, last.width)
        yield
        before = before.shifted(last.run.starts[index])
        found = led_over(before, k, fresh.law)
        if found is None:
            raise MotionError(NOTHING)
        past = past_of(before, k * before.step)
        return Grown(run, found[0], Origin(None, 0, last.width, True), found[1] + BEHIND_S, past)

    def _refined(self, found: Grown, slow: bool) -> Work[Grown]:
        """slow: all of it; else where it had to be led over alone."""
        if not (slow or found.origin.led):
            return found
        seconds = REFINED_S if slow else found.until
        law = yield from refined_work(found.run.path, found.run.limits, found.law, seconds, found.past)
        if law is not None:
            return found._replace(law=law, origin=Origin(None, 0, found.origin.width, True))
        if found.origin.led:
            raise MotionError(NOTHING)
        return found
