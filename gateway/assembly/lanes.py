"""The lanes of a cell: kinematics that move for themselves (AX-920)."""

from gateway.assembly.programs import kinematic_by_axis
from gateway.pure.cell.cell import Cell
from gateway.pure.cycle.lane_masks import masks_of


def lane_masks(cell: Cell) -> list[int]:
    """Axes (bit n-1 = axis n) of each, as the cycle has them."""
    return masks_of(kinematic_by_axis(cell), one=not move_apart(cell))


def several(cell: Cell) -> bool:
    """It has kinematics with their own feed inputs and override (AX-1787)."""
    return len(cell.robot) > 1 and all(robot.model for robot in cell.robot)


def move_apart(cell: Cell) -> bool:
    """Its kinematics have a lane each."""
    return several(cell) and not cell.belt and cell.alter is None


def robot_axes(cell: Cell) -> dict[str, int]:
    """Axes (bit n-1 = axis n) of each robot with a name."""
    numbers = kinematic_by_axis(cell)
    masks = [sum(1 << n for n, own in enumerate(numbers) if own == number) for number in range(1, len(cell.robot) + 1)]
    return {robot.name: mask for robot, mask in zip(cell.robot, masks, strict=True) if robot.name and mask}


def lanes_of_cell(cell: Cell) -> int:
    """How many a record of the cell has, one for each kinematic also where they are led together; 0: the cell has one."""
    count = len(masks_of(kinematic_by_axis(cell), one=False))
    return count if count > 1 else 0
