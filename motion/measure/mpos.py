"""@MPOS: the joint position of the last measurement of a kinematic.

Source: rho 3 Releases part 1, L1128-1140, L1257-1266, L7617-7658.  Kept until the next measurement; not occupied until the active
program measured; components of axes on other servo boards are not occupied.  Reading what is not occupied: "point not defined".
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from motion.errors import MotionError
from motion.measure.errors import POINT_NOT_DEFINED, ProgramFault
from motion.measure.history import History
from motion.measure.inputs import Board, InputKind, MeasuringInput, stored_at


@dataclass(slots=True)
class MeasuredPosition:
    """@MPOS of one kinematic.  axes: numbers (from 0) of its axes in the control, in the order of its joint points."""

    axes: tuple[int, ...]
    _values: tuple[float | None, ...] = field(init=False)

    def __post_init__(self) -> None:
        self.program_started()

    def program_started(self) -> None:
        """What an earlier program measured is not this one's (L1132)."""
        self._values = (None,) * len(self.axes)

    @property
    def occupied(self) -> bool:
        """Whether all components may be read."""
        return None not in self._values

    def take(self, values: Sequence[float | None]) -> None:
        """A measurement; None: an axis that is not on the board of the input."""
        if len(values) != len(self.axes):
            raise MotionError(f"{len(values)} measured positions for {len(self.axes)} axes")
        self._values = tuple(values)

    def read(self) -> tuple[float, ...]:
        """Return the complete point.  Raise ProgramFault point not defined when a component is not occupied."""
        return tuple(self.component(n) for n in range(len(self.axes)))

    def component(self, number: int) -> float:
        """One component (from 0)."""
        value = self._values[number]
        if value is None:
            raise ProgramFault(POINT_NOT_DEFINED, f"@MPOS component {number + 1}")
        return value


def measured(
    at: MeasuringInput, edge_ns: int, cycle_ns: int, axes: Sequence[int], boards: Mapping[int, Board], history: History
) -> tuple[float | None, ...] | None:
    """Return the positions of these axes at an edge of this input, m or rad.

    A component is None for axes on other boards and for edges older than the kept history.

    The result is None when an instant to store is later than the newest positions: ask again next cycle.  history: all axes of the control.
    """
    board = boards[at.board] if at.board else None
    found: list[float | None] = []
    for axis in axes:
        if board is not None and axis not in board.axes:
            found.append(None)
            continue
        kind = InputKind.HIGH_SPEED if at.kind is InputKind.NORMAL else at.kind
        stamp = stored_at(kind, edge_ns, cycle_ns, board is None or axis in board.incremental)
        if history.newest_ns is None or history.oldest_ns is None or stamp > history.newest_ns:
            return None
        found.append(history.at(stamp)[axis] if stamp >= history.oldest_ns else None)
    return tuple(found)
