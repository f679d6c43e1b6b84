"""The lanes of a cell: kinematics that move for themselves (AX-920)."""

from gateway.assembly.programs import kinematic_by_axis
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.lane_masks import masks_of


def lane_masks(cell: Cell) -> list[int]:
    """Axes (bit n-1 = axis n) of each, as the cycle has them."""
    return masks_of(kinematic_by_axis(cell), one=bool(cell.belt) or cell.alter is not None)


def lanes_of_cell(cell: Cell) -> int:
    """How many a record of the cell has; 0: one, which is the whole cell."""
    count = len(lane_masks(cell))
    return count if count > 1 else 0
