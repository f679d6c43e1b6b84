"""Interruptible axes: drive-on signals per axis, position tracking, position acceptance.

Source: rho 3 Releases part 1, section 3 (L1290-1345, L1500-1524).  The group signal (RC input 66) switches all axes; the signals
of single axes (192..211) act only while it is 0.  An axis without its signal is out of the loop: its set position follows the
actual one and no servo error arises.  Switching on needs a standing kinematic, and while a program runs a MOVE UNTIL before the
next block.  Position acceptance after a change of the coordinate system is the option flag of P306 (L1404-1406): AX-412.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from motion.axes.errors import DRIVE_ON_NOT_ALLOWED, DRIVE_ON_NOT_AVAILABLE, AxisError
from motion.errors import MotionError

MOVES = 1e-9  # m or rad: an axis whose set value changes by less does not take part


@dataclass(slots=True)
class DriveOn:
    """The axes of one kinematic.  `update` once a cycle; `check_move` before a block or a jog starts."""

    axes: int
    on: list[bool] = field(init=False)
    unaccepted: set[int] = field(init=False, default_factory=set)  # switched on again, position not yet taken over

    def __post_init__(self) -> None:
        self.on = [False] * self.axes

    def update(
        self,
        group: bool,
        single: Sequence[bool],
        set_values: Sequence[float],
        actual: Sequence[float],
        *,
        moving: bool,
        program: bool,
        locked: Sequence[bool] = (),
    ) -> tuple[float, ...]:
        """Return the set positions (axes,) to continue with: actual positions for axes out of the loop and for an axis just switched on.

        moving: any axis of the kinematic moves; program: one is active; locked: axes that `motion.axes.disabled` took out.
        Raises AxisError DRIVE ON not allowed when an axis is to come back while the kinematic moves; it then stays off.
        """
        if not len(single) == len(set_values) == len(actual) == self.axes:
            raise MotionError(f"{len(single)} signals, {len(set_values)} set and {len(actual)} actual values for {self.axes} axes")
        wanted = [(group or bool(signal)) and not (locked and locked[n]) for n, signal in enumerate(single)]
        refused = [n for n in range(self.axes) if wanted[n] and not self.on[n]] if moving else []
        result = []
        for n in range(self.axes):
            joins = wanted[n] and not self.on[n] and n not in refused
            result.append(set_values[n] if self.on[n] and wanted[n] else actual[n])
            if self.on[n] and not wanted[n] and program:
                self.unaccepted.add(n)
            self.on[n] = joins or (self.on[n] and wanted[n])
        if refused:
            raise AxisError(DRIVE_ON_NOT_ALLOWED, refused[0] + 1, "the axes of the kinematic must be at rest")
        return tuple(result)

    def accept(self, *, until: bool) -> None:
        """A block took the actual positions over.  until: it was MOVE UNTIL or MOVE_REL UNTIL; MOVE TO @POS does not count."""
        if until:
            self.unaccepted = {n for n in self.unaccepted if not self.on[n]}

    def check_move(self, start: Sequence[float], *way: Sequence[float], until: bool = False) -> None:
        """Raises AxisError for the first axis that would move without drive-on; start and way: joint positions, after the
        transformation, so a move in world coordinates is judged by the axes it really needs.

        until: the block is a MOVE UNTIL, the one that may run (and accept the position) with axes switched on again.
        """
        for n in range(self.axes):
            moves = any(abs(point[n] - start[n]) > MOVES for point in way)
            if moves and not self.on[n]:
                raise AxisError(DRIVE_ON_NOT_AVAILABLE, n + 1)
        back = sorted(n for n in self.unaccepted if self.on[n])
        if back and not until:
            raise AxisError(DRIVE_ON_NOT_AVAILABLE, back[0] + 1, "its position was not accepted by MOVE UNTIL since it came back")

    def program_ended(self) -> None:
        """Nothing is left to accept: the next program starts from where the axes are."""
        self.unaccepted.clear()
