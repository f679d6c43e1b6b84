"""What a block may have to keep besides reach and travel, looked at before anything moves: the working range of the tool and, where the
old controller's error is wanted instead of slowing down, the speed of every axis.

Working range: LIMIT_MIN and LIMIT_MAX of the rho 3, world points that move with the frame (L8976-8983).  Speed: rho 3 P306 sub-query 6 = 1,
"Ax-Velocity exceeded", and 3, "Interpolator Stop" (L5549-5596), or VAL 3 540 near a singularity (L5562-5564, L5675-5677).  AX-571.
"""

import math
from dataclasses import dataclass

import numpy as np

from motion.geometry.frames import Pose
from motion.paths.joints import JointPath
from motion.planner.block_paths import Leg
from motion.planner.robot import Machine
from motion.program.blocks import Block, Interpolation
from motion.program.errors import BlockError
from motion.timing.limiter import ABORT_TEXT, WARNING_TEXT, TooFast

OUTSIDE = 532  # VAL 3: Cartesian position outside the workspace
SINGULARITY = 540
LOOKS = 200  # along a way that is not straight
SPEED_LOOKS = 16  # along each quintic
TOUCH = 1e-9  # m, or share of a speed


@dataclass(frozen=True, slots=True)
class Slowed:
    """A block whose programmed speed an axis cannot keep everywhere.  share: overload at the worst place, as a multiple of the allowed
    speed.
    """

    axis: str
    share: float
    percent: float  # of the stretch, where that place is

    @property
    def words(self) -> str:
        return f"{WARNING_TEXT}: {self.share:.3g} times its speed, {self.percent:.0f} % along the path: run more slowly there"

    def of(self, block: int) -> str:
        """In words, of the block by its number in the program."""
        return f"block {block}, axis {self.axis}: {self.words} (rho 3)"


def check_range(leg: Leg, machine: Machine) -> None:
    """Raises BlockError for the first place where the tool would be outside the working range of its block.  A straight way from inside
    to inside stays inside; of a way that begins outside its end alone counts: it leads back."""
    if leg.block.lowest is None and leg.block.highest is None:
        return
    bent = leg.block.kind is not Interpolation.LINEAR and not _beyond(leg, 0.0, machine)
    for k in range(1, LOOKS + 1) if bent else (LOOKS,):
        if what := _beyond(leg, leg.length * k / LOOKS, machine):
            where = "" if k == LOOKS else f", {100 * k // LOOKS} % along the path"
            raise BlockError(f"working range: {what}{where}", code=OUTSIDE, source="VAL 3")


def _beyond(leg: Leg, s: float, machine: Machine) -> str:
    """What of the place at s is outside; empty: nothing."""
    low, high = leg.block.lowest or (-math.inf,) * 3, leg.block.highest or (math.inf,) * 3
    place = (leg.block.frame.pose.inverse() @ _tool(leg, s, machine)).position
    for letter, value, least, most in zip("xyz", place, low, high, strict=True):
        if not least - TOUCH <= value <= most + TOUCH:
            return f"{letter} {value * 1e3:.6g} mm is outside {least * 1e3:.6g} .. {most * 1e3:.6g} mm"
    return ""


def _tool(leg: Leg, s: float, machine: Machine) -> Pose:
    if leg.curve is not None:
        return leg.curve.at(s)
    assert leg.path is not None
    return machine.forward(leg.path.q(s)) @ leg.block.tool.pose


def check_speed(path: JointPath, block: Block, machine: Machine) -> Slowed | None:
    """Where the programmed speed of the path asks more of an axis than its limit: the finding, or BlockError if that is to be an
    error."""
    pace = block.pace
    if machine.too_fast is TooFast.SLOW or block.kind is Interpolation.PTP or (pace.path_speed is None and pace.turn_speed is None):
        return None
    s = path.looks(SPEED_LOOKS * len(path.coefficients))
    slopes = np.abs(path.at(s, 1))
    speed = np.full(len(slopes), math.inf)
    for column, given in ((-2, pace.path_speed), (-1, pace.turn_speed)):
        if given is not None:
            speed = np.minimum(speed, given / np.maximum(slopes[:, column], 1e-12))
    most = np.array([axis.speed for axis in machine.limits])
    shares = slopes[:, : machine.axes] * speed[:, None] / most
    where, axis = np.unravel_index(int(np.argmax(shares)), shares.shape)
    share, percent = float(shares[where, axis]), 100.0 * float(s[where]) / path.length
    if share <= 1.0 + TOUCH:
        return None
    if machine.too_fast is TooFast.WARN:
        return Slowed(machine.name(int(axis)), share, percent)
    what = f"{share:.3g} times its speed, {percent:.0f} % along the path"
    if machine.too_fast is TooFast.ABORT:
        raise BlockError(f"{ABORT_TEXT}: {what}", axis=machine.name(int(axis)), source="rho 3")
    raise BlockError(f"singularity cannot be crossed here: {what}", code=SINGULARITY, axis=machine.name(int(axis)), source="VAL 3")
