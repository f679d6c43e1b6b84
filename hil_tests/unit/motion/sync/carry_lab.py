"""A six-axis arm on a straight path seen from a belt, in the stepper, in virtual time."""

import numpy as np
from numpy.typing import NDArray

from hil_tests.lab.cells.motion_paths import MS, POINTING_DOWN, arm, paths_of
from motion.execution.stepper import Stepper
from motion.execution.timed import TimedPiece
from motion.geometry.frames import Pose
from motion.kinematics.base import Joints
from motion.paths.line import line
from motion.planner.commit import timed_pieces
from motion.sync.join import SyncStepper
from motion.sync.reserve import reserved
from motion.timing.jerk import jerk_limited
from motion.timing.limits import law_limits

NEAR: Joints = (0.0, 0.5, 1.2, 0.0, 1.0, 0.0)
ROBOT, LIMITS = arm()
SPEEDS = tuple(axis.speed for axis in LIMITS)


def down(x: float, y: float, z: float) -> Pose:
    """Tool down at this place, m."""
    return Pose((x, y, z), POINTING_DOWN)


def straight(start: Pose, end: Pose, speed: float = 0.5, *, reserve: bool = True) -> list[TimedPiece]:
    """Pieces of the line, m/s along it; reserve: planned with what a belt leaves."""
    near = ROBOT.inverse(start, NEAR)
    (path,) = paths_of([line(start, end)], ROBOT, near)
    way = (speed, 5.0, 200.0)
    planned = law_limits(reserved(LIMITS) if reserve else LIMITS, way=(speed, 4.5, 140.0) if reserve else way)
    return timed_pieces(path, law_limits(LIMITS, way=way), jerk_limited(path, planned))


def joined(start: Pose) -> SyncStepper:
    """The arm at `start`, a stepper without a piece."""
    q = ROBOT.inverse(start, NEAR)
    return SyncStepper(Stepper(6, MS, q), ROBOT, SPEEDS, MS, q)


def shares(rows: list[tuple[float, ...]]) -> NDArray[np.float64]:
    """(n - 1, 6) speeds as shares of their limits."""
    return np.asarray(np.abs(np.diff(np.array(rows), axis=0)) / MS / np.array(SPEEDS))
