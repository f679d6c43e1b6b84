"""Outputs of blocks as places on timed pieces: which piece, and how long after its beginning (blocks.Output)."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from motion.execution.timed import TimedPiece
from motion.planner.runs import Run
from motion.planner.stretch import Kind, Stretch
from motion.program.blocks import Called, Flying, Interpolation, Latching, Output, Recording
from motion.program.errors import BlockError
from motion.timing.law import Law
from motion.timing.limits import WAY

SMALLEST = 1e-12  # m or rad of the path
LOOKS = 4000  # at the way along a run
WHOLE = 1.0 - 1e-9  # of a block: its end is reached


class Mark(NamedTuple):
    """Output `number` becomes `value` this long (s at full speed) after the beginning of a piece."""

    piece: int
    after: float
    number: int
    value: float
    function: Called | None = None  # called here; number and value have no meaning then

    @property
    def member(self) -> int:
        """Of several kinematics the one it is about, from 0."""
        return self.function.member if isinstance(self.function, Flying | Latching | Recording) else 0


def at_rest(each: Called | Output) -> Mark:
    """Return the mark of an action at rest: no piece has this number."""
    _, number, value, function = _done_at(0.0, each)
    return Mark(0, 0.0, number, value, function)


def check_outputs(stretch: Stretch) -> None:
    """An output so far before the end of its block that the block has not begun there: BlockError."""
    block = stretch.source
    for output in block.outputs:
        if output.before and block.kind is Interpolation.PTP:
            raise BlockError(f"output {output.number}: a distance along a PTP block has no meaning", block=stretch.block)
        if output.before > stretch.way + SMALLEST:
            long, before = stretch.way * 1e3, output.before * 1e3
            raise BlockError(f"output {output.number}: {before:g} mm before the end of a block of {long:.3f} mm", block=stretch.block)


def marks_of(run: Run, law: Law, pieces: Sequence[TimedPiece], *, goes_on: bool) -> list[Mark]:
    """Marks on the pieces of one law along the run, in path order.  goes_on: marks at or before its very beginning belong to the pieces
    that it continues.
    """
    places = sorted(_places(run), key=lambda each: each[0])  # at one place as the text has them
    begins = np.concatenate([[0.0], np.cumsum([piece.duration for piece in pieces])])
    marks = []
    for s, number, value, function in places:
        if s > law.s[-1] + SMALLEST or s < law.s[0] or (goes_on and s <= law.s[0] + SMALLEST):
            continue
        tau = _when(law, s)
        index = min(max(int(np.searchsorted(begins, tau, side="left")) - 1, 0), len(pieces) - 1)
        after = min(tau - float(begins[index]), pieces[index].duration)  # the sum of durations rounds
        marks.append(Mark(pieces[index].id, after, number, value, function))
    return marks


def has_marks(run: Run) -> bool:
    """Whether something is done on its way."""
    return next(_places(run), None) is not None


def _places(run: Run) -> Iterator[tuple[float, int, float, Called | None]]:
    """(s on the run, output, value, none) of every output whose block ends on it; (s, 0, 0, function) where a block that calls one begins:
    in the middle of the corner before it, else at its own beginning."""
    for stretch, start in zip(run.stretches, run.starts, strict=True):
        corner = stretch.kind is Kind.CORNER
        begins = stretch.following if corner else stretch.source if stretch.share[0] <= 1.0 - WHOLE else None
        if begins is not None:
            for each in (*begins.carried, *begins.functions):
                yield _done_at(start + (stretch.path.length * 0.5 if corner else 0.0), each)
        for each in stretch.ending:
            yield _done_at(start + stretch.path.length, each)
        outputs = stretch.source.outputs
        if not outputs or not _ends(stretch):
            continue
        end = start + stretch.path.length * (0.5 if stretch.kind is Kind.CORNER else 1.0)
        for output in outputs:
            yield _before(run, end, output.before) if output.before else end, output.number, output.value, None


def _done_at(s: float, each: Called | Output) -> tuple[float, int, float, Called | None]:
    return (s, each.number, each.value, None) if isinstance(each, Output) else (s, 0, 0.0, each)


def _before(run: Run, end: float, distance: float) -> float:
    """s where the tool is so far (m) before its place at s = end."""
    s = np.linspace(0.0, end, max(int(LOOKS * end / run.path.length), 2))
    ways = run.path.at(s)[:, WAY]
    return float(np.interp(ways[-1] - distance, ways, s))


def _when(law: Law, s: float) -> float:
    """Time at which the law is there: not before it."""
    k = min(int(np.searchsorted(law.s, s - SMALLEST, side="left")), len(law.s) - 1)
    if k == 0:
        return 0.0
    share = (s - law.s[k - 1]) / max(law.s[k] - law.s[k - 1], SMALLEST)
    return float(law.step * (k - 1 + min(max(share, 0.0), 1.0)))


def _ends(stretch: Stretch) -> bool:
    """The end of its block lies on it: in the middle of a corner, else at its own end."""
    return stretch.kind is Kind.CORNER or stretch.share[1] >= WHOLE
