"""Drive-on of single axes while a program runs: who is out of the loop, what may move meanwhile, and who may come back.  Pure.

The rules are those of motion.axes.interruptible (rho 3 L1290-1345, L1500-1524, L7918-7945); here they meet drives, pieces and the parts of
a program.  An axis that is out, or back and not accepted, is kept: its set value is its position, whatever the path demands.  AX-393.
"""

from collections.abc import Iterable, Sequence

from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.image.records.cell import EVERY_AXIS
from motion.axes.errors import DRIVE_ON_NOT_AVAILABLE, AxisError
from motion.axes.interruptible import MOVES, DriveOn
from motion.execution.stepper import Sample
from motion.execution.timed import TimedPiece


class DriveOnGate:
    """Of one lane; for the program under way."""

    def __init__(self, axes: Sequence[HeldAxis]) -> None:
        self.kept: set[int] = set()  # axes whose set value stays at their position
        self._axes = axes
        self._rule = DriveOn(len(axes))
        self.mask = EVERY_AXIS  # axes (bit n-1 = axis n) that move together; others are ignored

    @property
    def watches(self) -> bool:
        """Some axis is out of the loop, or its position is not accepted."""
        return bool(self.kept or self._rule.unaccepted)

    def missing_of(self, mask: int) -> int:
        """The first of these axes (from 1) that is out of the loop, or whose position is not accepted; 0: none."""
        return min((n + 1 for n in self.kept | self._rule.unaccepted if mask >> n & 1), default=0)

    # ---- programs ----------------------------------------------------------------------------------------------------
    def begin(self, mask: int) -> bool:
        """A program is ordered: True when its axes follow, except those not commanded on; one at least."""
        own = [axis for n, axis in enumerate(self._axes) if mask >> n & 1]
        self.kept = self._gone()
        self._rule = DriveOn(len(self._axes))
        self._rule.on = [self._usable(n, axis) for n, axis in enumerate(self._axes)]
        return any(axis.drive.follows for axis in own) and all(axis.drive.follows or not axis.wanted for axis in own)

    def over(self) -> None:
        """No program, and the path is at rest: the set values are those of the axes."""
        self.kept.clear()
        self._rule.program_ended()

    def accepting(self) -> None:
        """Begin a part that ends with an input at the actual positions of the axes; axes that are back take part."""
        self.kept = {n for n in self.kept if not (self._rule.on[n] and self._axes[n].drive.follows)}

    def accepted(self) -> None:
        """A part that ends with an input is over: it went on from where the axes really are (MOVE UNTIL)."""
        self._rule.accept(until=True)
        self.kept = {n for n in self.kept if not self._rule.on[n] or n in self._rule.unaccepted}

    # ---- signals -------------------------------------------------------------------------------------------------------
    def leave(self, ahead: Iterable[TimedPiece]) -> int:
        """Axes are not wanted on any more; the first of them (from 1) that one of the committed pieces would move, 0: none."""
        self._update(moving=False)
        gone = self._gone()
        self.kept |= gone
        return next((n + 1 for piece in ahead for n in self._moved(piece) if n in gone), 0)

    def join(self, mask: int) -> None:
        """These axes are to come back; AxisError DRIVE ON not allowed while an axis moves."""
        coming = {n for n, axis in enumerate(self._axes) if mask >> n & 1 and not axis.wanted}
        if not coming:
            return
        self.kept |= coming
        moving = any(axis.speed != 0.0 for n, axis in enumerate(self._axes) if self.mask >> n & 1)
        self._update(moving=moving, coming=coming)
        self._rule.unaccepted |= coming  # also those that were out when the program began

    def _update(self, *, moving: bool, coming: Iterable[int] = ()) -> None:
        axes, new = self._axes, set(coming)
        signals = [n in new or self._usable(n, axis) for n, axis in enumerate(axes)]
        sets = [axis.set for axis in axes]
        self._rule.update(False, signals, sets, sets, moving=moving, program=True)

    def _gone(self) -> set[int]:
        return {n for n, axis in enumerate(self._axes) if not axis.wanted and self.mask >> n & 1}

    def _usable(self, n: int, axis: HeldAxis) -> bool:
        return (axis.wanted and axis.referenced) or not self.mask >> n & 1

    # ---- paths ---------------------------------------------------------------------------------------------------------
    def check(self, piece: TimedPiece, *, until: bool) -> None:
        """AxisError DRIVE ON not avail. for a piece that moves an axis that is out of the loop, or comes while the position of one that
        is back is not accepted; until: the part under way ends with an input."""
        start = [0.0] * len(self._axes)
        way = list(start)
        for n in self._moved(piece):
            if n in self.kept or not (self._axes[n].drive.follows and self._axes[n].referenced):
                raise AxisError(DRIVE_ON_NOT_AVAILABLE, n + 1)
            way[n] = 1.0
        self._rule.check_move(start, way, until=until)

    def _moved(self, piece: TimedPiece) -> list[int]:
        """Axes of the cell that it moves; one that is out of the loop may be as far from where the path has it as it may when it is in
        position."""
        first, found = piece.nodes[0], []
        for k, n in enumerate(piece.axes):
            axis = self._axes[n]
            least = MOVES if axis.wanted else axis.plan.window
            if any(abs(node[3 * k] - first[3 * k]) > least for node in piece.nodes):
                found.append(n)
        return found

    def begin_of(self, piece: TimedPiece) -> list[float]:
        """Return where the path of a piece may begin: the axes' positions; for kept ones the positions that the piece assumes."""
        places = [axis.set for axis in self._axes]
        for axis, place in zip(piece.axes, piece.nodes[0][::3], strict=False):
            if axis in self.kept:
                places[axis] = place
        return places

    def kept_in(self, sample: Sample) -> Sample:
        """The sample with the kept axes where they are."""
        q, qd = list(sample.q), list(sample.qd)
        for n in self.kept:
            q[n], qd[n] = self._axes[n].set, 0.0
        return sample._replace(q=tuple(q), qd=tuple(qd))
