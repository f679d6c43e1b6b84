"""WC_SYSTEM of the rho 3 for neutral blocks: the workpiece system a block's poses are in, worked into its frame (AX-586).

Source: rho 3 Releases part 1, TO06 section 6, L8795-9070.  World points, LIMIT_MIN and LIMIT_MAX, mirror planes and the switching
positions of SF 1 and SF 2 move with the system; places of axes and the travel of axes do not.
"""

from dataclasses import replace

from motion.geometry.conventions import RHO3
from motion.geometry.frames import IDENTITY, Pose
from motion.outputs.function import Function
from motion.program.blocks import Block, Frame, PoseTarget
from motion.rho3.wc import WC_UR, Assignment

LETTERS = "xyzabc"


def located(block: Block, corrected: str = LETTERS) -> Block:
    """The block with its system inside its frame.  corrected: components that a system corrects (P313), as the letters of RHO3's."""
    system = block.system
    if system is None or system.values == WC_UR.values:
        return block if system is None else replace(block, system=None)
    functions = tuple(replace(each, system=system.values) if isinstance(each, Function) else each for each in block.functions)
    made = replace(block, frame=Frame(block.frame.name, system.pose @ block.frame.pose), functions=functions, system=None)
    if corrected == LETTERS:
        return made

    def kept(point: PoseTarget) -> PoseTarget:
        return replace(point, pose=made.frame.pose.inverse() @ _moved(block.frame.pose @ point.pose, system.pose, corrected))

    target = kept(block.target) if isinstance(block.target, PoseTarget) else block.target
    return replace(made, target=target, via=None if block.via is None else kept(block.via))


def _moved(point: Pose, system: Pose, corrected: str) -> Pose:
    """A point of the system in the original one; components nothing corrects stay as programmed (L8905-8937)."""
    if system == IDENTITY:
        return point
    numbers = [n if letter in corrected else 0 for n, letter in enumerate(LETTERS, 1)]
    first, second, third, fourth, fifth, sixth = numbers
    moved = Assignment((first, second, third, fourth, fifth, sixth)).put(RHO3.values(point), system @ point)
    return RHO3.pose(moved)
