"""Stepper, belt and alteration together: P = F_belt(t) * P(s) * A(t), one sample a period (motion.md E 7).

The path in the stepper is seen from the belt; its joints are those of the robot with the belt at value 0.  Here the frame is applied
before it and the alteration after it, the joints are computed anew on the same branch, and s is slowed where joints would be too fast.  A
remaining excess (a belt that jumps) is stretched over several periods, as with P306 sub-query 6 = 3 (L6221-6227).
"""

from collections.abc import Sequence
from typing import NamedTuple

from motion.errors import MotionError
from motion.execution.pieces import Piece
from motion.execution.stepper import Sample, Stepper
from motion.execution.timed import TimedPiece
from motion.geometry.frames import IDENTITY, Pose, compose
from motion.kinematics.base import Joints, KinematicsError, PathKinematics
from motion.sync.chain import Chain
from motion.sync.endless_axis import AlongAxis
from motion.sync.joint_lookahead import TOP, Scout

STEP = 0.02  # shares are rounded down to it: the stepper need not plan for noise
PATIENCE_S = 0.05  # minimum duration of a lower share
REACTS_S = 0.02  # waiting time for the effect of a lower share


class Joined(NamedTuple):
    """One period.  q: set values (axes,); path: of the stepper; share: allowed share of full speed; short: joints lag."""

    q: tuple[float, ...]
    path: Sample
    share: float
    short: bool


class SyncStepper:
    """Owns the stepper of one kinematic while it is synchronous.  speeds: limits of the arm's joints per s."""

    def __init__(self, stepper: Stepper, kinematics: PathKinematics, speeds: Sequence[float], period_s: float, q: Sequence[float]) -> None:
        if len(speeds) != kinematics.axes:
            raise MotionError(f"{len(speeds)} speed limits for {kinematics.axes} joints")
        self._stepper, self._kinematics, self._speeds, self._period = stepper, kinematics, tuple(speeds), period_s
        self._axes, self._beside = kinematics.axes, isinstance(kinematics, AlongAxis)
        self._chain = Chain()
        self._scout = Scout(kinematics, self._chain, self._speeds, period_s)
        self._q = tuple(q)
        self._wanted = stepper.override
        self._share, self._since = 1.0, 0.0
        self.fault: KinematicsError | None = None

    @property
    def q(self) -> tuple[float, ...]:
        """Set values of the last period."""
        return self._q

    def load(self, piece: Piece | TimedPiece) -> None:
        """As Stepper.load.  A piece of polynomials is run as well, but without look-ahead."""
        self._stepper.load(piece)
        if isinstance(piece, TimedPiece):
            self._chain.load(piece)
        else:
            self._chain.clear()
            self._scout.restart()

    def set_override(self, value: float) -> None:
        """Of the user; what the joints allow goes below it."""
        if not 0.0 <= value <= 1.0:
            raise MotionError(f"override {value} is outside 0 .. 1")
        self._wanted = value

    def place(self, frame: Pose = IDENTITY, alteration: Pose = IDENTITY) -> None:
        """At rest: the robot keeps its position, from now on in this frame with this alteration.  Raises KinematicsError."""
        n = self._kinematics.axes
        seen = compose(compose(frame.inverse(), self._kinematics.forward(self._q[:n])), alteration.inverse())
        self._stepper.place((*self._kinematics.follow(seen, self._q[:n]), *self._q[n:]))
        self._chain.clear()
        self._scout.restart()
        self.fault = None

    def step(self, frame: Pose = IDENTITY, alteration: Pose = IDENTITY) -> Joined:
        """Compute the next period; frame and alteration: at the moment when the set values act.

        Where the pose cannot be reached the joints stay, the path is stopped and `fault` holds the reason; place() continues.
        """
        self._stepper.set_override(self._wanted if self._wanted < self._share else self._share)
        sample = self._stepper.step()
        if self.fault is None:
            try:
                self._q, short = self._found(sample, frame, alteration)
            except KinematicsError as error:
                self.fault, short = error, True
                self._stepper.stop()
        else:
            short = True
        if self.fault is None:
            self._limit(sample, frame, alteration, short)
        return Joined(self._q, sample, self._share, short)

    def _found(self, sample: Sample, frame: Pose, alteration: Pose) -> tuple[tuple[float, ...], bool]:
        """Joints of the period, at most as far from those before as the speeds allow; whether they fell short."""
        kinematics, n, before = self._kinematics, self._axes, self._q
        path, rest = sample.q[:n], sample.q[n:]
        pose = compose(frame, kinematics.forward(path))
        if alteration is not IDENTITY:
            pose = compose(pose, alteration)
        goal: Joints = kinematics.follow(pose, path if self._beside else before[:n])
        most = 0.0
        for k, speed in enumerate(self._speeds):  # no zip and no generator: they cost as much as all the axes
            needed = abs(goal[k] - before[k]) / speed
            if needed > most:
                most = needed
        most /= self._period
        if most <= 1.0:
            return (*goal, *rest) if rest else goal, False
        return (*(a + (b - a) / most for a, b in zip(before, goal, strict=False)), *rest), True

    def _limit(self, sample: Sample, frame: Pose, alteration: Pose, short: bool) -> None:
        share = self._scout.look(sample, frame, alteration, self._q[: self._axes])
        if short and self._share > 0.0:
            share = min(share, self._share if self._since < REACTS_S else 0.8 * TOP * self._share)  # unforeseen: less, until it fits
        share = int(share / STEP) * STEP if share < 1.0 else 1.0
        self._since += self._period
        if share < self._share or (share > self._share and self._since >= PATIENCE_S):
            self._share, self._since = share, 0.0
        elif share == self._share:
            self._since = 0.0 if share < 1.0 else self._since
