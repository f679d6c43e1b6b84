"""@MPOS of each kinematic of a cell, as the published state shows it: measured_mask, and measured of each axis (AX-594).  Pure."""

from collections.abc import Mapping, Sequence

from gateway.pure.cycle.axis import HeldAxis
from gateway.pure.image.records.cell import CellState


class Measured:
    """Stored measurements; a new one of a kinematic replaces only the previous one of the same kinematic."""

    def __init__(self, state: CellState, axes: Sequence[HeldAxis]) -> None:
        self._state, self._masks = state, dict[int, int]()
        for n, axis in enumerate(axes):
            self._masks[axis.plan.kinematic] = self.of(axis.plan.kinematic) | 1 << n

    def of(self, kinematic: int) -> int:
        """Axes (bit n-1 = axis n) of a kinematic, by its number from 1."""
        return self._masks.get(kinematic, 0)

    def forget(self, mask: int) -> None:
        """A kinematic with one of these axes has measured nothing."""
        for own in self._masks.values():
            self._state.measured_mask &= ~own if own & mask else -1

    def store(self, places: Mapping[int, float]) -> None:
        """Where axes (from 0) of one kinematic were; its others were not measured."""
        mask = sum(1 << n for n in places)
        self.forget(mask)
        for n, place in places.items():
            self._state.axes[n].measured = place
        self._state.measured_mask |= mask
