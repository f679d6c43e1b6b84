"""Endless axes of a core: at rest their positions are brought back into 0 .. modulo.  Source: rho 3 P303, P311, L5598-5644; AX-568.  Pure.

The drive's increments keep counting; their meaning shifts by full rounds, so nothing moves and no set value changes.
"""

import math
from collections.abc import Sequence

from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.image.records.cell import CellState
from motion.kinematics.endless import within

NEAR = 1e-9  # of a round: a set position so little below the modulo has gone round


class CoreEndless:
    """axes: of all of a core."""

    def __init__(self, axes: Sequence[HeldAxis], state: CellState) -> None:
        self.axes = [(n, axis) for n, axis in enumerate(axes) if axis.plan.modulo]
        self._state = state

    def look(self, mask: int) -> bool:
        """Once a cycle, of axes (bit n-1 = axis n) at rest; True: a set position is another number now."""
        found = False
        for n, axis in self.axes:
            if not mask >> n & 1:
                continue
            modulo = axis.plan.modulo
            rounds = math.floor(axis.set / modulo + NEAR)
            if rounds:
                way, scaling = rounds * modulo, axis.scaling
                axis.scaling = scaling.with_zero(scaling.zero_inc + way * scaling.inc_per_unit)
                axis.set -= way
                shown = self._state.axes[n]
                shown.measured = within(shown.measured, modulo)
                found = True
        return found
