"""What share of full speed the joints allow on a path that a belt carries: looked at ahead of the robot, a quarter of a look a period.

Along the path a joint moves with omega * p + b: p from the path at full speed, b from the belt.  The scout finds both at a place the
robot reaches later, so that the stepper can brake on the path in time; between two looks lie four periods.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from motion.execution.stepper import Sample
from motion.geometry.frames import IDENTITY, Pose, compose
from motion.geometry.orientation import interpolated
from motion.kinematics.base import Joints, KinematicsError, PathKinematics
from motion.sync.chain import Chain

LOOKS = 4  # periods that a look needs
DRIFT = 8  # looks over which the belt's drift is taken: what its filter leaves of the increments must not be seen in it
TOP = 0.97  # of a joint's speed that is planned for; the rest is for what changes meanwhile


class Caps:
    """Shares that hold until the robot is past a place, and the least of them, which a period has for one look: a share kept for a place
    after a lower one is never used.
    """

    def __init__(self) -> None:
        self._kept: deque[tuple[float, float]] = deque()  # (tau, share), both rising

    @property
    def least(self) -> float:
        """1 where there is none."""
        return self._kept[0][1] if self._kept else 1.0

    def note(self, place: float, share: float) -> None:
        """One seen later is forgotten later, also where it is nearer because the chain was cut."""
        kept = self._kept
        if kept:
            place = max(place, kept[-1][0])
        while kept and kept[-1][1] >= share:
            kept.pop()
        kept.append((place, share))

    def past(self, tau: float) -> None:
        """Drop notes for places that the robot has passed."""
        while self._kept and self._kept[0][0] < tau:
            self._kept.popleft()

    def clear(self) -> None:
        """None is left."""
        self._kept.clear()


@dataclass(slots=True)
class Scout:
    """speeds: limits of the arm's joints per s; horizon_s: how far ahead at full speed: at least the time to brake."""

    kinematics: PathKinematics
    chain: Chain
    speeds: Sequence[float]
    period_s: float
    horizon_s: float = 0.15
    _caps: Caps = field(init=False, default_factory=Caps)
    _phase: int = field(init=False, default=0)
    _tau: float = field(init=False, default=0.0)  # of the robot
    _place: float = field(init=False, default=0.0)  # that is looked at
    _pose: Pose | None = field(init=False, default=None)
    _recent: deque[Pose] = field(init=False, default_factory=lambda: deque(maxlen=DRIFT + 1))  # frames of the last looks
    _frames: tuple[Pose, Pose] = field(init=False, default=(IDENTITY, IDENTITY))  # expected there, and one look earlier
    _here: Joints = field(init=False, default=())
    _belt: list[float] = field(init=False, default_factory=list)
    _reached: bool = field(init=False, default=True)

    def restart(self) -> None:
        """Another path, or another place on it: what was seen means nothing."""
        self._caps.clear()
        self._recent.clear()
        self._phase, self._pose, self._here = 0, None, ()

    def look(self, sample: Sample, frame: Pose, alteration: Pose, near: Joints) -> float:
        """The share allowed from here to the horizon; frame, alteration and joints: those of this period."""
        phase, self._phase = self._phase, (self._phase + 1) % LOOKS
        if phase == 0:
            self._begin(sample, frame, alteration, near)
        elif self._pose is not None and self._reached:
            try:
                self._go_on(phase, sample, alteration)
            except KinematicsError:
                self._caps.note(self._place, 0.0)
        return self._caps.least

    def _begin(self, sample: Sample, frame: Pose, alteration: Pose, near: Joints) -> None:
        tau = self.chain.tau(sample)
        if tau is None:
            self.restart()
            return
        if tau < self._tau:
            self._caps.clear()  # it goes back
        self._tau, self._place = tau, min(tau + self.horizon_s, self.chain.end)
        self._caps.past(tau)
        self._recent.append(frame)
        self._frames = self._expected(self._place - tau)
        self._pose = self._path(self._place, sample, alteration)
        try:
            self._here, self._reached = self.kinematics.follow(compose(self._frames[0], self._pose), self._here or near), True
        except KinematicsError:
            self._reached = False
            self._caps.note(self._place, 0.0)

    def _expected(self, ahead_s: float) -> tuple[Pose, Pose]:
        """Return the frame when the robot arrives at full speed, and one look before that, with constant motion of the belt."""
        first, last, looks = self._recent[0], self._recent[-1], len(self._recent) - 1
        if looks == 0:
            return last, last
        far = 1.0 + ahead_s / (looks * LOOKS * self.period_s)
        return interpolated(first, last, far), interpolated(first, last, far - 1.0 / looks)

    def _go_on(self, phase: int, sample: Sample, alteration: Pose) -> None:
        assert self._pose is not None
        frame, before = self._frames
        window, here = LOOKS * self.period_s, self._here
        if phase == 1:
            was = self.kinematics.follow(compose(before, self._pose), here)
            self._belt = _slopes(here, was, window)
        elif phase == 2 and self._belt:
            back = max(self._place - window, 0.0)
            if self._place > back:
                pose = compose(frame, self._path(back, sample, alteration))
                along = _slopes(here, self.kinematics.follow(pose, here), self._place - back)
                self._caps.note(self._place, allowed(along, self._belt, self.speeds))

    def _path(self, tau: float, sample: Sample, alteration: Pose) -> Pose:
        pose = self.kinematics.forward(self.chain.at(tau, sample.q)[: self.kinematics.axes])
        return pose if alteration is IDENTITY else compose(pose, alteration)


def _slopes(here: Joints, was: Joints, apart: float) -> list[float]:
    slopes: list[float] = []
    for k, value in enumerate(here):  # no zip, no comprehension: they cost as much as three of the axes
        slopes.append((value - was[k]) / apart)
    return slopes


def allowed(along: Sequence[float], belt: Sequence[float], speeds: Sequence[float], top: float = TOP) -> float:
    """Largest share 0 .. 1 with |share * along + belt| <= top * speeds for every joint; 0 where the belt alone asks for more."""
    share = 1.0
    for k, speed in enumerate(speeds):
        p, b, limit = along[k], belt[k], top * speed
        if p < 0.0:
            p, b = -p, -b
        if abs(b) >= limit:
            return 0.0
        if p != 0.0 and (limit - b) / p < share:
            share = (limit - b) / p
    return max(share, 0.0)
