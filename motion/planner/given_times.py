"""Blocks whose time is given: Reis BAHN_ZEIT with _IACC_TIME (L1744-1752, L1944-1956).

Speed goes up for `ramp` of the time, stays, and goes down for `ramp` of it again; 50 % is a triangle.  The corners of that profile
are rounded by the mean over a few milliseconds, within the ramps, so the time is kept to the sample.
"""

import numpy as np

from motion.paths.joints import JointPath
from motion.planner.robot import Machine
from motion.program.blocks import Block
from motion.program.errors import BlockError
from motion.timing.law import Law, check_seconds

STEP_S = 1e-3
PROFILE, ADDITIONAL = 611, 706  # speed profile cannot be computed; additional axes cannot keep the time (L4757, L4768)
LOOKS = 200
SOURCE = "Reis path error"


def figures(length: float, seconds: float, ramp: float) -> tuple[float, float]:
    """(sdot in the middle, sddot of the ramps)."""
    share = max(ramp, 2 * STEP_S / seconds)
    speed = length / (seconds * (1.0 - share))
    return speed, speed / (share * seconds)


def check_time(path: JointPath, block: Block, number: int, machine: Machine) -> None:
    """Raises BlockError 611, or 706 for an additional axis, where an axis cannot do what the time asks of it."""
    assert block.pace.time is not None
    speed, accel = figures(path.length, block.pace.time, block.pace.ramp)
    s = path.looks(LOOKS)
    first, second = (np.abs(path.at(s, order))[:, : machine.axes] for order in (1, 2))
    fast = first.max(axis=0) * speed / np.array([axis.speed for axis in machine.limits])
    strong = (first * accel + second * speed * speed).max(axis=0) / np.array([axis.accel for axis in machine.limits])
    for n in range(machine.axes):
        worst = max(float(fast[n]), float(strong[n]))
        if worst > 1.0 + 1e-9:
            code = ADDITIONAL if n >= machine.arm else PROFILE
            what = f"{block.pace.time:g} s are too short: {worst:.2f} times what the axis may do"
            raise BlockError(what, code=code, block=number, axis=machine.name(n), source=SOURCE)


def time_given(length: float, seconds: float, ramp: float, width: float) -> Law:
    """s(t) from rest to rest in exactly `seconds` (rounded to the sample); width: s of the mean that rounds the profile."""
    total = max(round(check_seconds(seconds) / STEP_S), 4)
    up = min(max(round(ramp * total), 2), total // 2)
    count = max(min(round(width / STEP_S), up), 1)
    t = np.arange(total - count + 1, dtype=np.float64)
    rise, end = float(up - count), float(total - count)
    speed = length / (end - rise)
    if rise > 0.0:
        s = np.where(t < rise, 0.5 * speed * t * t / rise, speed * (t - 0.5 * rise))
        s = np.where(t > end - rise, length - 0.5 * speed * (end - t) ** 2 / rise, s)
    else:
        s = speed * t
    padded = np.concatenate([np.zeros(count), s, np.full(count, length)])
    halves = np.concatenate([[0.0], np.cumsum(0.5 * (padded[1:] + padded[:-1]))])
    smooth = (halves[count:] - halves[:-count]) / count
    smooth[-1] = length
    return Law.sampled(np.asarray(smooth, dtype=np.float64), STEP_S)
