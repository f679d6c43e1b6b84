"""Motions that are too long without a stop, found before anything moves.  AX-606."""

from collections.abc import Iterable, Iterator, Sequence

from motion.errors import MotionError
from motion.planner.commit import MOST, timed_pieces
from motion.planner.planner import Planner
from motion.planner.quick_law import swift, width_s
from motion.planner.robot import Machine
from motion.planner.runs import Run, make_run
from motion.planner.stretch import Stretch
from motion.planner.team import Team
from motion.program.blocks import Shape
from motion.program.errors import BlockError

FAR = 0.5  # of the pieces a law may have: one of which the quick law has fewer is not made


def too_long(stretches: Iterable[Stretch], robots: Machine | Team) -> list[BlockError]:
    """One for each motion from rest to rest that a planner would not hand on, in its words, with the block its pieces end in; and for one
    that has no law.  As it is run at the programmed speed and full override."""
    return [fault for row in _rows(stretches) if _may_be(make_run(row, robots)) and (fault := _planned(row, robots)) is not None]


def _rows(stretches: Iterable[Stretch]) -> Iterator[list[Stretch]]:
    """From rest to rest."""
    row: list[Stretch] = []
    for stretch in stretches:
        row.append(stretch)
        if stretch.stop:
            yield row
            row = []
    if row:
        yield row


def _may_be(run: Run) -> bool:
    """Return whether the law itself must be examined: making it lasts about as long as running it."""
    if any(stretch.source.pace.time is not None or stretch.source.shape is Shape.SIN2 for stretch in run.stretches):
        return True  # slower than the quick law, and quickly made
    try:
        return len(timed_pieces(*run.driven, swift(run.path, run.limits, width_s(run.limits)).law)) > FAR * MOST
    except MotionError:
        return True


def _planned(row: Sequence[Stretch], robots: Machine | Team) -> BlockError | None:
    """Return the fault that a planner reports while the row is run."""
    planner = Planner(robots, (0.0,) * robots.axes)
    planner.given(row)
    try:
        while any(planner.begin(max(planner.end - ahead, 0.0), hurry=True) for ahead in (0.5 * planner.ahead_s, 0.0)):
            while not planner.work():
                pass
            planner.take()
    except MotionError as error:
        return error if isinstance(error, BlockError) else BlockError(str(error), block=row[0].block)
    return None
