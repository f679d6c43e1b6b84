"""Targets that are known where the block before ends: relative ones, MOVE_REL of the rho 3, and those of endless axes.

Source: rho 3 Releases part 1, L1443, L1626, L4175-4180, L11664; the manual shows the statement without its angles: AX-567.
Endless axes: L5598-5644, AX-354.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

from motion.geometry.frames import Pose
from motion.geometry.limits import AxisLimits
from motion.kinematics.base import FREE, Joints
from motion.kinematics.endless import within
from motion.planner.robot import Machine
from motion.program.blocks import Block, Interpolation, JointTarget, PoseTarget, Shift, Target
from motion.program.errors import BlockError

KINDS = (Interpolation.PTP, Interpolation.LINEAR)
NOT_HERE = "a relative target is one of ptp and linear blocks"


def resolved(block: Block, position: Joints, machine: Machine) -> Block:
    """The block with the target its shift leads to from where the axes are.  BlockError: numbers that are none, or too many."""
    shift = block.shift
    if shift is None or block.kind not in KINDS:
        return block
    check_shift(shift)
    if shift.angles is None:
        if len(shift.values) != machine.axes:
            raise BlockError(f"{len(shift.values)} joint values, the robot has {machine.axes} axes", code=154, source="VAL 3")
        return replace(block, target=JointTarget(_added(shown(position, machine.limits), shift.values)), shift=None)
    extra = moved_extra(shift, shown(position[machine.arm :], machine.limits[machine.arm :]))
    target: Target = JointTarget(
        (*shown(position[: machine.arm], machine.limits), *extra)
    )  # the dummy block: nothing turned about and back
    if any(shift.values):
        here = block.frame.pose.inverse() @ machine.forward(position) @ block.tool.pose
        target = PoseTarget(moved(shift, here), FREE, extra)
    return replace(block, target=target, shift=None)


def unwound(block: Block, position: Joints, machine: Machine) -> Block:
    """Unwind endless axes, which count continuously inside the planner: each travels from its position within the modulo to the programmed
    number, a full turn or more if the numbers require it.
    """
    target, limits = block.target, machine.limits
    if not any(axis.modulo for axis in limits):
        return block
    if isinstance(target, JointTarget):
        return replace(block, target=JointTarget(_unwound(target.q, position, limits)))
    if not target.extra:
        return block
    return replace(block, target=replace(target, extra=_unwound(target.extra, position[machine.arm :], limits[machine.arm :])))


def _unwound(wanted: Sequence[float], position: Sequence[float], limits: Sequence[AxisLimits]) -> tuple[float, ...]:
    if len(wanted) != len(limits):
        return tuple(wanted)  # the reader of the result reports that
    rows = zip(wanted, position, limits, strict=True)
    return tuple(here + value - within(here, axis.modulo) if axis.modulo else value for value, here, axis in rows)


def shown(places: Sequence[float], limits: Sequence[AxisLimits]) -> tuple[float, ...]:
    """Places of axes as programs name them: endless ones within their modulo."""
    return tuple(within(place, axis.modulo) if axis.modulo else place for place, axis in zip(places, limits, strict=False))


def moved(shift: Shift, here: Pose) -> Pose:
    """A pose with the numbers of a shift added to its own; orientations that do not change keep every digit."""
    assert shift.angles is not None
    x, y, z = _added(here.position, shift.values[:3])
    turn = shift.values[3:]
    if not any(turn):
        return Pose((x, y, z), here.rotation)
    first, second, third = _added(shift.angles.to_angles(here.rotation), turn)
    return Pose((x, y, z), shift.angles.to_rotation(first, second, third))


def moved_extra(shift: Shift, position: Sequence[float]) -> tuple[float, ...]:
    """Return the additional axes after the block, from their displayed positions.  Raise BlockError unless there is one number for each."""
    if len(shift.extra) not in (0, len(position)):
        raise BlockError(f"{len(shift.extra)} values of additional axes, the robot has {len(position)}", code=154, source="VAL 3")
    return _added(position, shift.extra or (0.0,) * len(position))


def check_shift(shift: Shift) -> None:
    """Six numbers for a pose, and all of them finite; BlockError."""
    if shift.angles is not None and len(shift.values) != 6:
        raise BlockError(f"{len(shift.values)} values of a relative pose, six are needed", code=154, source="VAL 3")
    if not all(map(math.isfinite, (*shift.values, *shift.extra))):
        raise BlockError("a value is not a finite number", code=154, source="VAL 3")


def check_absolute(block: Block) -> None:
    """A block whose shift nothing has turned into a target is none of those that may have one: BlockError."""
    if block.shift is not None:
        raise BlockError(NOT_HERE)


def _added(one: Sequence[float], other: Sequence[float]) -> tuple[float, ...]:
    return tuple(a + b for a, b in zip(one, other, strict=True))
