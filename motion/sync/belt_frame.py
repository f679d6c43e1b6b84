"""A belt of type 1 as the frame of one period: counter, filter, prediction, catching up."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from motion.geometry.frames import Pose, compose
from motion.geometry.limits import AxisLimits
from motion.kinematics.base import Joints, KinematicsError, PathKinematics
from motion.sync.belt_state import STOPPED
from motion.sync.parallel import OFF, ON, Coupling, Hold, ParallelPart
from motion.sync.reserve import borne, left_over
from motion.sync.tracker import Tracker

PROBE = 1e-4  # m or rad of belt: so far the axes are looked at
ONWARD = 0.99  # of full speed, where a path began with less: room to reach it without a step
SETTLING = 4  # periods after it has caught up: third differences of the set values still see it


@dataclass(slots=True)
class Carried:
    """F_belt(t) of one kinematic.  step() once a period, after Belts.update; the frame holds when the set value acts."""

    part: ParallelPart
    tracker: Tracker
    coupling: Coupling = field(default_factory=Coupling)
    frame: Pose = field(init=False)
    _along: Sequence[float] = field(init=False, default=())  # way of each axis for one m or rad of belt
    _limits: Sequence[AxisLimits] = field(init=False, default=())
    _beside: float = field(init=False, default=1.0)
    _on: int = field(init=False, default=0)  # periods since it has caught up

    def __post_init__(self) -> None:
        self.frame = self.part.carrier.frame(self.coupling.value)

    def bear(self, kinematics: PathKinematics, limits: Sequence[AxisLimits], q: Joints) -> None:
        """Limit the coupling before engage(): getting on and off uses no more than the arm's axes allow at q, and the path only the
        remainder.
        """
        value, carrier = self.part.value(self.tracker.ahead()), self.part.carrier
        moved = compose(carrier.frame(value + PROBE), carrier.frame(value).inverse())
        try:
            there = kinematics.follow(compose(moved, kinematics.forward(q)), q)
        except KinematicsError:
            return  # the belt leads out of reach: reported as soon as the robot is on it
        self._along, self._limits = [(b - a) / PROBE for a, b in zip(q, there, strict=True)], limits
        accel, jerk = borne(self._along, limits)
        self.coupling.accel, self.coupling.jerk = min(self.coupling.accel, accel), min(self.coupling.jerk, jerk)

    @property
    def beside(self) -> float:
        """Share of full speed a path may have now; it does not change while the robot catches up, or that would cost the axes anew."""
        catching = self.coupling.state is Hold.CATCHING or (self.caught and self._on < SETTLING)
        return self._beside if catching else max(self._beside, ONWARD)

    def engage(self) -> Pose:
        """SYNCHRON, after step(): the present frame of the robot; the path begins there."""
        self.coupling.engage(self.part.value(self.tracker.ahead()), self.tracker.speed)
        self._beside = left_over(self._along, self._limits, *self.coupling.asks)
        self.frame = self.part.carrier.frame(self.coupling.value)
        return self.frame

    def release(self) -> None:
        """SYNCHRON_END."""
        self.coupling.release()

    @property
    def caught(self) -> bool:
        """The robot is where the belt is."""
        return self.coupling.state is ON

    def step(self, period: float) -> Pose:
        """One period further."""
        belt = self.part.belt
        middle = 0.5 * abs(belt.data.increment)  # an increment counts when it is complete: the belt is half of one further on average
        self.tracker.update(belt.way + middle, at_rest=belt.watch.motion is STOPPED)
        coupling = self.coupling
        if coupling.state is not OFF:
            self.frame = self.part.carrier.frame(coupling.step(self.part.value(self.tracker.ahead()), period))
            self._on = self._on + 1 if coupling.state is ON else 0
        return self.frame
