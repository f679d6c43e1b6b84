"""What the tool does against what its blocks ask: set values at 1 ms through the forward kinematics, nothing of the planner's own."""

import math
import random
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from hil_tests.lab.cells.arms import Array, robot
from motion.geometry.frames import NO_ROTATION, Pose, product, transposed
from motion.geometry.orientation import rotation_vector
from motion.planner.arm import Arm
from motion.planner.robot import Machine
from motion.planner.trace import route_of, trace
from motion.program.blocks import Blend, Block, Interpolation, Pace, PoseTarget, Program, Rounding

PERIOD_S = 1e-3
Forward = Callable[[Sequence[float]], Pose]  # another's kinematics
Found = tuple[float, float, float]  # largest share of the programmed path speed, turning speed, acceleration along the path


def sampled(program: Program, forward: Forward | None = None) -> Found:
    """On paper, the whole program known."""
    machine = robot(program.robot)
    found = route_of(program, machine)
    assert not found.faults, found.faults
    way = trace(found.stretches, machine)
    return excess(program.blocks, forward or machine.forward, way.q, [int(b) for b in way.block])


def driven(program: Program, ahead: int) -> Found:
    """Run with no more than `ahead` blocks waiting."""
    return streamed(program.blocks, robot(program.robot), program.start, ahead)


def streamed(blocks: Sequence[Block], machine: Machine, start: Sequence[float], ahead: int) -> Found:
    """The same for blocks by themselves."""
    left, arm = list(blocks), Arm(machine, start, PERIOD_S)
    rows, numbers = [arm.joints], [1]
    while left or not (arm.place().waiting == 0 and arm.resting):
        while left and arm.planner.waiting < ahead:
            arm.add(left.pop(0))
            if not left:
                arm.finish()
        rows.append(arm.step())
        numbers.append(arm.place().block)
        assert len(rows) < 30_000
    return excess(blocks, machine.forward, np.array(rows), numbers)


def excess(blocks: Sequence[Block], forward: Forward, q: Array, numbers: Sequence[int]) -> Found:
    """q: (n, axes); numbers: the block at each.  An interval between two blocks is held against the faster of both."""
    own = [blocks[min(max(number, 1), len(blocks)) - 1] for number in numbers]
    flanges = [forward([float(v) for v in row]) for row in q]
    # where a block with another tool begins: of both tools the slower one
    pairs = [
        [(a @ block.tool.pose, b @ block.tool.pose) for block in two] for (a, b), two in zip(pairwise(flanges), pairwise(own), strict=True)
    ]
    speed = np.array([min(math.dist(a.position, b.position) for a, b in each) for each in pairs]) / PERIOD_S
    turn = np.array([min(_between(a, b) for a, b in each) for each in pairs]) / PERIOD_S
    change = np.diff(speed) / PERIOD_S
    tops = [[_asked(block, name) for block in own] for name in ("path_speed", "turn_speed", "path_accel", "path_decel")]
    found = []
    for values, top in zip((speed, turn, np.maximum(change, 0.0), np.maximum(-change, 0.0)), tops, strict=True):
        width = len(top) - len(values) + 1
        allowed = np.max([top[k : k + len(values)] for k in range(width)], axis=0)
        found.append(float(np.max(values / allowed)))
    return found[0], found[1], max(found[2:])


def _asked(block: Block, name: str) -> float:
    value = getattr(block.pace, name)
    path = block.kind is not Interpolation.PTP or name not in ("path_accel", "path_decel")  # which PTP knows not
    return float(value) if value is not None and path else math.inf


def _between(a: Pose, b: Pose) -> float:
    return math.hypot(*rotation_vector(product(transposed(a.rotation), b.rotation)))


def random_blocks(dice: random.Random, count: int = 8) -> list[Block]:
    """Short lines of all speeds, rounded."""
    blocks, (x, y, z) = [], (0.0, 0.0, 0.0)
    for _ in range(count):
        x, y, z = (c + dice.uniform(-0.08, 0.08) for c in (x, y, z))
        size = dice.choice((0.002, 0.01, 0.03))
        accel, decel = dice.choice(((None, None), (None, None), (2.0, 2.0), (2.0, 6.0), (6.0, 2.0), (None, 3.0)))
        pace = Pace(path_speed=dice.choice((0.03, 0.1, 0.3, 1.0, 2.0)), path_accel=accel, path_decel=decel)
        target = PoseTarget(Pose((x, y, z), NO_ROTATION))
        blocks.append(Block(Interpolation.LINEAR, target, pace=pace, blend=Blend(Rounding.CARTESIAN, size, size)))
    return blocks
