"""A long contour of short segments, streamed through planner and follower in virtual time."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hil_tests.lab.cells.arms import Array, differences, portal
from motion.geometry.frames import NO_ROTATION, Pose
from motion.planner.arm import Arm
from motion.program.blocks import Blend, Block, Interpolation, Pace, PoseTarget, Rounding

SEGMENT_M = 1e-3
SPEED = 0.2  # m/s
CORNER = Blend(Rounding.CARTESIAN, 1e-2, 1e-2)  # as large as the neighbours allow


def contour(count: int) -> Iterator[Block]:
    """Segments of about 1 mm along a wavy circle that never ends."""
    angle, x0 = 0.0, 0.1
    for _ in range(count):
        radius = 0.1 + 0.02 * math.sin(5 * angle)
        angle += SEGMENT_M / radius
        radius = 0.1 + 0.02 * math.sin(5 * angle)
        place = (radius * math.cos(angle) - x0, radius * math.sin(angle), 0.0)
        yield Block(Interpolation.LINEAR, PoseTarget(Pose(place, NO_ROTATION)), pace=Pace(path_speed=SPEED), blend=CORNER)


@dataclass(frozen=True)
class Streamed:
    """starved: periods at rest while blocks were still to come; slowest: TCP speed away from the ends, m/s; shares of the limits."""

    blocks: int
    seconds: float
    starved: int
    slowest: float
    accel: float
    jerk: float
    waiting: int  # most blocks that waited


def stream(count: int, period_s: float = 0.004) -> Streamed:
    """All blocks through one arm; the program fills the look-ahead before every period, as an interpreter would."""
    arm, blocks, more = Arm(portal(), (0.0, 0.0, 0.0), period_s), contour(count), True
    rows, starved, waiting = [arm.joints], 0, 0
    while more or not (arm.place().waiting == 0 and arm.resting):
        while more and arm.planner.room:
            block = next(blocks, None)
            if block is None:
                more = False
                arm.finish()
            else:
                arm.add(block)
        waiting = max(waiting, arm.planner.waiting)
        rows.append(arm.step())
        starved += more and len(rows) > 20 and arm.resting
    return _judged(count, np.array(rows), period_s, starved, waiting)


def _judged(count: int, rows: Array, period_s: float, starved: int, waiting: int) -> Streamed:
    speed = np.linalg.norm(np.diff(rows, axis=0), axis=1) / period_s
    edge = round(0.2 / period_s)
    tops = [float(np.max(np.abs(differences(rows, period_s, order)))) for order in (2, 3)]
    limits = portal().limits[0]
    return Streamed(
        count, len(rows) * period_s, starved, float(speed[edge:-edge].min()), tops[0] / limits.accel, tops[1] / limits.jerk, waiting
    )
