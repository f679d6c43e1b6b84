"""Overrides as command sources have ordered them, and a factor on all of them (M1436 of a Reis).  Pure.  Source: AX-1000."""

from gateway.pure.image.records.cell import CellState


class Overrides:
    """Ordered override of each axis; None: ordered by a predecessor, so the value shown by the cycle applies."""

    def __init__(self, axes: int) -> None:
        self._ordered: list[float | None] = [None] * axes
        self._factor: float | None = None

    def ordered(self, axes: int, value: float) -> float:
        """A command source orders `value` for these axes; what the cycle gets."""
        for number in range(len(self._ordered)):
            if axes >> number & 1:
                self._ordered[number] = value
        return value if self._factor is None else value * self._factor

    def multiplied(self, factor: float, cell: CellState) -> list[tuple[int, float]]:
        """A factor; (axes, override) for the cycle.  The first one is in force already, since the cycle outlives its services."""
        before, self._factor = self._factor, factor
        if before is None or before == factor or not cell.generation:
            return []
        groups: dict[float, int] = {}
        for number, ordered in enumerate(self._ordered):
            shown = cell.override_of(1 << number)
            system = (shown / before if before else 0.0) if ordered is None else ordered
            groups[system] = groups.get(system, 0) | 1 << number
        return [(mask, min(system * factor, 1.0)) for system, mask in groups.items()]
