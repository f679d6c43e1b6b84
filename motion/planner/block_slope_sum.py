"""Block slope of one robot: a block's own ramp, and whether the sum of two with sine-square slope keeps what the blocks ask, not only what
the axes can.

Such a row of sine squares keeps the times at which its blocks were added (motion.planner.sine_square_laws), so a sum that is too fast
would slow
all of it; jerk-limited blocks get a law of their own along the curve, which is slower only where it must be.  AX-600.
"""

import math

import numpy as np
from numpy.typing import NDArray

from motion.paths.joints import JointPath
from motion.planner.caps import block_caps, robot_limits
from motion.planner.robot import Machine
from motion.planner.tool_speed import tool_pulls, tool_rates, tool_tops
from motion.program.blocks import Block, Shape
from motion.program.slopes import SAMPLES, Ramped, ramped
from motion.timing.jerk import JUDGE_S, slowing
from motion.timing.limits import LawLimits

Array = NDArray[np.float64]
TRUE = 1 + 2e-4  # of a limit: no nearer to the tool's true rates are the columns a law is held against (AX-583)


def own_ramp(block: Block, path: JointPath, machine: Machine) -> Ramped:
    """Return the block alone, as fast as allowed.  With sine squares it gets the additional time that a bent path needs, or a tool whose
    acceleration limit is lower than that of the axes.
    """
    pace, sine = block.pace, block.shape is Shape.SIN2
    made = ramped(
        path,
        machine.limits,
        speed=min(pace.speed, 1.0),
        accel=(min(pace.accel, 1.0), min(pace.decel, 1.0)),
        tool=tool_tops([block], machine),
        pulls=tool_pulls(block, machine) if sine else ((math.inf, math.inf), math.inf),
        sine=sine,
    )
    if not sine:
        return made
    limits = robot_limits(machine, block_caps(block, path, 0.0, 0.0, path.length, machine))
    return made.slower(slowing(path, limits, made.law()))


def sum_keeps(before: Ramped, after: Ramped, start: float, blocks: tuple[Block, Block], machine: Machine) -> bool:
    """Whether axes and tool keep the pace of both blocks while both run; start: of the second, s after that of the first."""
    t = np.linspace(start, before.duration, SAMPLES)
    one, two = before.motion(t), after.motion(t - start)
    s = np.array([before.s(float(x))[0] + after.s(float(x) - start)[0] for x in t])
    s -= s[0]
    middle = float(np.interp(0.5 * s[-1], s, t))
    limits = _limits(before, after, blocks, machine, float(s[-1]), float(np.interp(middle - JUDGE_S, t, s)))
    speed, pulls = limits.at(s)[0], limits.pulls(s)
    axes, sums = before.path.axes, one[1] + two[1]
    accel = one[2] + two[2]
    allowed = np.where(sums * accel >= 0.0, pulls[0, :, :axes], pulls[1, :, :axes])
    if bool(np.any(np.abs(sums) > TRUE * speed[:, :axes])) or bool(np.any(np.abs(accel) > TRUE * allowed)):
        return False
    if not np.any(np.isfinite(np.concatenate([speed[:, axes:], pulls[0, :, axes:], pulls[1, :, axes:]]))):
        return True
    place = before.path.at(np.zeros(1))[:, :axes] + one[0] + two[0]
    first = s <= 0.5 * s[-1]
    halves = zip(blocks, (first, ~first), strict=True)
    rates = np.concatenate([tool_rates(machine, block.tool.pose, place[here], sums[here]) for block, here in halves])
    if bool(np.any(rates > TRUE * speed[:, axes:])):
        return False
    pull = np.diff(rates, axis=0) / float(t[1] - t[0])
    up, down = np.maximum(pulls[:, 1:, axes:], pulls[:, :-1, axes:])
    return bool(np.all(np.abs(pull) <= TRUE * np.where(pull >= 0.0, up, down)))


def _limits(before: Ramped, after: Ramped, blocks: tuple[Block, Block], machine: Machine, length: float, middle: float) -> LawLimits:
    """Of the curve the sum makes, as of any corner: the first block asks all along it, the second from the middle on (a period sooner:
    its speed is a difference)."""
    caps = []
    for block, ramp, begin in ((blocks[0], before, 0.0), (blocks[1], after, middle)):
        caps += block_caps(block, ramp.path, 0.0, begin, length, machine)
    return robot_limits(machine, caps)
