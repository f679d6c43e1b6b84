"""LINEAR without transformation (rho 3 RTYP 0): straight in the axes, the programmed speed that of the main axes (AX-588).

Source: rho 3 Releases part 1, TO04 section 11, L5598-5644: main axes (P303 0, 3) make the path and its speed, manual axes (1, 4) go along
in the same time.  Lengths of linear main axes are the way of the path, angles of turning ones its turning.
"""

from collections.abc import Sequence
from math import hypot

from motion.geometry.units import Kind, kind_of
from motion.kinematics.base import Joints
from motion.kinematics.identity import Identity
from motion.paths.joints import JointPath, joint_path
from motion.planner.robot import Machine
from motion.program.blocks import Block, Interpolation, JointTarget

NO_WAY = 1e-12


def along_axes(block: Block, position: Joints, machine: Machine) -> bool:
    """Whether a block is LINEAR to places of axes that have no transformation, and more of them move than the path of a tool shows."""
    if block.kind is not Interpolation.LINEAR or not isinstance(block.target, JointTarget) or not isinstance(machine.kinematics, Identity):
        return False
    shown = machine.kinematics.cartesian
    return any(n not in shown or machine.limits[n].manual for n in _moving(position, block.target.q))


def _moving(start: Joints, end: Joints) -> list[int]:
    return [n for n, (a, b) in enumerate(zip(start, end, strict=False)) if abs(b - a) >= NO_WAY]


def axes_line(start: Joints, end: Joints, machine: Machine) -> JointPath:
    """The straight line of the axes with its way and turning.  Its parameter is the way of its main axes: what goes straight on through a
    passed point keeps its speed there, however the others change."""
    travel = [b - a for a, b in zip(start, end, strict=True)]
    way, turn = main_rates(travel, machine)
    length = way or turn
    axes = [(a, change / length) for a, change in zip(start, travel, strict=True)]
    return joint_path([0.0, length], [[*axes, (0.0, way / length), (0.0, turn / length)]])


def main_rates(changes: Sequence[float], machine: Machine) -> tuple[float, float]:
    """Way of the linear and turning of the rotary main axes where all axes change so; of manual ones where no other moves."""
    moving = [n for n, change in enumerate(changes) if abs(change) >= NO_WAY]
    mains = [n for n in moving if not machine.limits[n].manual] or moving
    way, turn = (hypot(*(changes[n] for n in mains if kind_of(machine.limits[n].unit) is kind)) for kind in (Kind.LINEAR, Kind.ROTARY))
    return way, turn
