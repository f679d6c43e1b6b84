"""Which axes of a cell are a lane together.  Pure, and apart from the lanes: who only counts them does not load the motion core."""

from collections.abc import Sequence

from gateway.pure.image.records.cell import EVERY_AXIS


def masks_of(kinematics: Sequence[int], *, one: bool) -> list[int]:
    """Axes (bit n-1 = axis n) of each lane, in the order of the kinematics; kinematics: number of the robot of each axis, 0: none.

    `one`: belts and corrections belong to the entire cell, and all its axes are in one lane.
    """
    if one or len(set(kinematics)) < 2:
        return [EVERY_AXIS]
    numbers = sorted(set(kinematics), key=lambda number: (number == 0, number))
    return [sum(1 << n for n, own in enumerate(kinematics) if own == number) for number in numbers]
