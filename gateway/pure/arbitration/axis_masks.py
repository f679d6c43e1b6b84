"""Masks of axes: bit n-1 is axis n."""

from collections.abc import Sequence

from gateway.pure.arbitration.jobs import AxisFacts
from gateway.pure.image.records.cell import AxisFlag, CellState


def axes_with(flag: AxisFlag, cell: CellState | None, count: int) -> int:
    """The first `count` axes that have one of these flags set; none where nothing was published yet."""
    if cell is None:
        return 0
    wanted, mask, place = int(flag), 0, 1
    for axis in cell.axes[:count]:
        if int(axis.flags) & wanted:  # plain numbers: arithmetic of enum flags costs a microsecond each
            mask |= place
        place <<= 1
    return mask


def names_of(axes: Sequence[AxisFacts], mask: int) -> str:
    """Their names, as a message lists them."""
    return ", ".join(axis.name for n, axis in enumerate(axes) if mask >> n & 1)
