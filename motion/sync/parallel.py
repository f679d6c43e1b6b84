"""Belts of type 1: the robot works on parts on the belt, its path is carried along.

Source: rho 3 Releases part 1, TO04 section 14 (type 1, as programmed in BAPS), P503 (coupling factors), TO08 section 4 (endless
belt).  The manual of BAPS2 itself is not available: its interpretation is AX-442.  A point of a program holds a belt value: it is
meant for the moment the belt has it.  Seen from the belt this point is at rest, so the path is planned there, and
P = F_belt(t) * P(s): the frame goes with the belt.
"""

from dataclasses import dataclass, field
from enum import Enum
from math import inf, isfinite, sqrt

from motion.errors import MotionError
from motion.geometry.frames import Pose, Vector, compose, translation
from motion.geometry.orientation import rotation_by
from motion.sync.belts import Belt


@dataclass(frozen=True, slots=True)
class Carrier:
    """How a belt carries: factors: P503 of x, y, z, m of the robot's base for one m of belt; or axis and centre of a round table
    (axis: unit vector; the belt is then in rad); or joint: an axis of the robot, from 0, that goes along by the first of the factors,
    per m or rad of belt (motion.sync.endless_axis)."""

    factors: Vector = (1.0, 0.0, 0.0)
    axis: Vector | None = None
    centre: Vector = (0.0, 0.0, 0.0)
    joint: int | None = None

    def frame(self, belt: float) -> Pose:
        """Return the frame at this value of a part that was in the base at belt value 0."""
        if self.axis is None:
            x, y, z = self.factors
            return translation(x * belt, y * belt, z * belt)
        x, y, z = self.axis
        turn = Pose((0.0, 0.0, 0.0), rotation_by((x * belt, y * belt, z * belt)))
        to, back = translation(*self.centre), translation(-self.centre[0], -self.centre[1], -self.centre[2])
        return compose(to, compose(turn, back))

    def on_belt(self, pose: Pose, belt: float) -> Pose:
        """Return a pose of the base, meant for this belt value, as seen from the belt: the planner's input."""
        return compose(self.frame(belt).inverse(), pose)


class Hold(Enum):
    """OFF: the robot is at rest beside the belt; CATCHING: it accelerates to the belt's speed; ON; LEAVING: it comes to rest."""

    OFF, CATCHING, ON, LEAVING = "off", "catching up", "on the belt", "leaving"


ON, OFF = Hold.ON, Hold.OFF  # a name in an Enum is looked up slowly, and these are in every period


@dataclass(slots=True)
class Coupling:
    """Which belt value the robot's frame has: up to the belt's speed and down again within an acceleration and a jerk.

    accel, jerk: of the belt value, m or rad per s2, s3.  Catching up makes good what the belt ran meanwhile (at up to 1.52 times its
    speed): from then on the robot is where the belt is.
    """

    accel: float = inf
    jerk: float = inf
    state: Hold = field(init=False, default=Hold.OFF)
    value: float = field(init=False, default=0.0)  # of the frame
    _speed: float = field(init=False, default=0.0)  # of the belt when the change began
    _from: float = field(init=False, default=0.0)  # of the frame when the change began
    _time: float = field(init=False, default=0.0)
    _lasts: float = field(init=False, default=0.0)
    _rate: float = field(init=False, default=0.0)  # of the frame

    @property
    def rate(self) -> float:
        """Of the frame, per s."""
        return self._rate

    @property
    def asks(self) -> tuple[float, float]:
        """Largest acceleration and jerk of catching up, per s2 and s3."""
        if self._lasts <= 0.0:
            return 0.0, 0.0
        return 3.94 * abs(self._speed) / self._lasts, 36.0 * abs(self._speed) / (self._lasts * self._lasts)

    def engage(self, belt: float, speed: float) -> None:
        """SYNCHRON: the belt is at this value and has this speed.  MotionError while the frame still moves."""
        if self.state is not Hold.OFF:
            raise MotionError(f"SYNCHRON: the robot is still {self.state.value}")
        self.state, self._time, self._speed = Hold.CATCHING, 0.0, speed
        self.value = belt
        self._lasts = max(3.94 * abs(speed) / self.accel, sqrt(36.0 * abs(speed) / self.jerk))

    def release(self) -> None:
        """SYNCHRON_END: the belt keeps running, the robot comes to rest."""
        if self.state in (Hold.CATCHING, Hold.ON):
            self.state, self._time, self._speed, self._from = Hold.LEAVING, 0.0, self._rate, self.value
            self._lasts = max(1.875 * abs(self._rate) / self.accel, sqrt(5.78 * abs(self._rate) / self.jerk))

    def step(self, belt: float, period: float) -> float:
        """The frame's belt value, one period further; belt: where the belt will be."""
        self._time += period
        before = self.value
        if self.state is ON:
            self.value = belt
        elif self.state is not OFF:
            self._change(belt, self._time / self._lasts if self._lasts > 0.0 else 1.0)
        self._rate = (self.value - before) / period
        return self.value

    def _change(self, belt: float, u: float) -> None:
        """u: of the change's time, 0 .. 1 and beyond."""
        if self.state is Hold.CATCHING:
            behind = 0.0 if u >= 1.0 else u * (1.0 + u * u * (-6.0 + u * (8.0 - 3.0 * u)))  # slope 1 -> 0, jerk and accel bounded
            self.value = belt - self._speed * self._lasts * behind
            self.state = ON if u >= 1.0 else Hold.CATCHING
        else:
            w = min(u, 1.0)
            made = w + w**4 * (-2.5 + w * (3.0 - w))  # speed 1 -> 0 as 1 - 10 w^3 + 15 w^4 - 6 w^5
            self.value = self._from + self._speed * self._lasts * made
            self.state = OFF if u >= 1.0 else Hold.LEAVING


@dataclass(slots=True)
class ParallelPart:
    """One SYNCHRON on a belt of type 1.  Belt values of programs are those of the counter as it was at SYNCHRON: a counter that SYNC
    lessens inside the part (endless belt) does not disturb the motion (L11607-11617)."""

    belt: Belt
    carrier: Carrier = Carrier()
    _zero: float = field(init=False)  # way of the belt at which the frame is the base
    _rebased: int = field(init=False)

    def __post_init__(self) -> None:
        self._zero, self._rebased = self.belt.zero, self.belt.rebased

    def value(self, way: float) -> float:
        """Belt value of the frame for this way of the belt (of now, or predicted)."""
        return way - self._zero

    def point(self, pose: Pose, belt_value: float) -> Pose:
        """A programmed point as the planner wants it: seen from the belt.  MotionError for an absolute one after SYNC inside."""
        if self.belt.rebased != self._rebased:
            raise MotionError(f"belt {self.belt.number}: absolute positions are not possible after SYNC inside the part: only MOVE_REL")
        if not isfinite(belt_value):
            raise MotionError(f"belt {self.belt.number}: belt value {belt_value}")
        return self.carrier.on_belt(pose, belt_value)
