"""What the pace of a block asks of the columns of its path, and the robot of all."""

import math
from collections.abc import Sequence

import numpy as np

from motion.paths.joints import JointPath
from motion.planner.given_times import figures
from motion.planner.robot import Machine
from motion.program.blocks import Block, Interpolation
from motion.program.factors import FULL, Factors
from motion.timing.limits import FREE, TURNING, WAY, Cap, LawLimits, law_limits


def robot_limits(machine: Machine, caps: Sequence[Cap]) -> LawLimits:
    """Of one robot's path."""
    return law_limits(
        machine.limits,
        way=(machine.path_speed, machine.path_accel, FREE),
        turning=(machine.turn_speed, machine.turn_accel, FREE),
        caps=caps,
    )


def block_caps(block: Block, path: JointPath, way: float, start: float, end: float, machine: Machine, factors: Factors = FULL) -> list[Cap]:
    """Return the caps of a block on the stretch start .. end of s.  path: that of its axes, or of its corner; way: full length of the
    block.
    """
    pace, caps = block.pace, []
    accel, decel = min(pace.accel * factors.acceleration, 1.0), min(pace.decel * factors.deceleration, 1.0)
    lead = _lead(block, path)
    whole = lead is None and min(pace.speed * factors.velocity, accel, decel) >= 1.0
    for n, axis in () if whole else enumerate(machine.limits):
        speed = pace.speed * factors.velocity if lead is None or lead == n else factors.velocity
        if speed < 1.0 or accel < 1.0 or decel < 1.0:
            caps.append(Cap(start, end, n, axis.speed * min(speed, 1.0), axis.accel * accel, axis.accel * decel))
    ptp = block.kind is Interpolation.PTP  # accelerates as its axes can: of the tool its speeds alone are asked for
    path_accel = FREE if ptp else (pace.path_accel or FREE) * factors.acceleration
    path_decel = FREE if ptp else (pace.path_decel or FREE) * factors.deceleration
    if pace.time is not None and way > 0.0:  # rounded at an end: speed from the time of the entire block
        speed, ramp = figures(way, pace.time, pace.ramp)
        still = not np.any(path.at(np.zeros(1), 1)[0, WAY])
        caps.append(Cap(start, end, TURNING if still else WAY, speed, ramp, ramp))
    if pace.path_speed is not None or math.isfinite(path_accel) or math.isfinite(path_decel):
        caps.append(Cap(start, end, WAY, (pace.path_speed or FREE) * factors.velocity, path_accel, path_decel))
    if pace.turn_speed is not None:
        caps.append(Cap(start, end, TURNING, pace.turn_speed * factors.velocity))
    return caps


def _lead(block: Block, path: JointPath) -> int | None:
    """Reis PTP: the axis with the largest travel goes at the programmed share, the others only have to keep up (L350-352)."""
    if not block.pace.lead or block.kind is not Interpolation.PTP:
        return None
    travel = np.abs(path.at(np.zeros(1), 1)[0, : path.axes])
    return int(np.argmax(travel))
