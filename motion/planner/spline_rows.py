"""A row of SPLINE blocks: one curve through all their points; every block keeps its number, its additional axes and its faults."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import inf

from motion.errors import MotionError
from motion.kinematics.base import Joints
from motion.paths.base import PathError
from motion.paths.polynomial import part
from motion.paths.tube import Fitted, fitted
from motion.planner.additional_axes import joining
from motion.planner.block_paths import Leg, base_pose, block_fault, check_joints, extra_of, tcp
from motion.planner.robot import Machine
from motion.program.blocks import Block

Row = Sequence[tuple[int, Block]]  # number and block


def goes_on(row: Row, block: Block) -> bool:
    """Whether the block may belong to the row: a row is the path of one tool."""
    return not row or row[0][1].tool == block.tool


def place_of(block: Block, position: Joints, machine: Machine) -> Joints:
    """(axes,) where the block will end, as far as one point determines it; raises its fault."""
    check_joints(block, machine)
    flange = base_pose(block, position, machine) @ block.tool.pose.inverse()
    return machine.inverse(flange, (*position[: machine.arm], *extra_of(block, position, machine)))


def curve_of(row: Row, start: Joints, machine: Machine) -> Fitted:
    """Return the entire curve.  Raise BlockError with the block for which no curve exists."""
    first = row[0][1]
    points = [tcp(start, first, machine), *(base_pose(block, start, machine) for _, block in row)]
    marks = [first.curving, *(block.curving for _, block in row)]
    try:
        return fitted(
            points,
            [block.curving.tube or inf for _, block in row],
            [m.tension for m in marks],
            [m.orientation_tension for m in marks],
            [1.0, *(block.curving.weight for _, block in row)],
        )
    except PathError as error:
        raise block_fault(error, row[error.interval][0], machine) from error


def legs_of(row: Row, whole: Fitted, start: Joints, machine: Machine) -> Iterator[Leg]:
    """One for each block, in order; of start and end only the additional axes count."""
    arm, ends = machine.arm, whole.ends
    values = [tuple(start[arm:])]
    for number, block in row:
        try:
            values.append(extra_of(block, (*start[:arm], *values[-1]), machine))
        except MotionError as error:
            raise block_fault(error, number, machine) from error
    lengths = [b - a for a, b in pairwise(ends)]
    slopes = _slopes(values, lengths)
    for n, (number, block) in enumerate(row):
        between = (*start[:arm], *values[n]), (*start[:arm], *values[n + 1])
        piece = part(whole.curve, ends[n], ends[n + 1])
        ends_at = [[(value, slope, 0.0) for value, slope in zip(values[k], slopes[k], strict=True)] for k in (n, n + 1)]
        yield Leg(number, block, piece, None, lengths[n], *between, joining(lengths[n], *ends_at))


def _slopes(values: Sequence[Joints], lengths: Sequence[float]) -> list[Joints]:
    """Change of the additional axes by s at each point: the parabola through the neighbours, so that nothing jumps."""
    chords = [
        tuple((b - a) / h for a, b in zip(one, other, strict=True)) for (one, other), h in zip(pairwise(values), lengths, strict=True)
    ]
    inner = [
        tuple((x * after + y * before) / (before + after) for x, y in zip(left, right, strict=True))
        for (left, right), (before, after) in zip(pairwise(chords), pairwise(lengths), strict=True)
    ]
    return [chords[0], *inner, chords[-1]]
