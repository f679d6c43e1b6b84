"""A belt of type 1 as the frame of one period: counter, filter, prediction, catching up."""

from dataclasses import dataclass, field

from motion.frames import Pose
from motion.sync.parallel import Coupling, Hold, ParallelPart
from motion.sync.tracker import Tracker
from motion.sync.watch import Motion


@dataclass(slots=True)
class Carried:
    """F_belt(t) of one kinematic.  step() once a period, after Belts.update; the frame holds when the set value acts."""

    part: ParallelPart
    tracker: Tracker
    coupling: Coupling = field(default_factory=Coupling)
    frame: Pose = field(init=False)

    def __post_init__(self) -> None:
        self.frame = self.part.carrier.frame(self.coupling.value)

    def engage(self) -> Pose:
        """SYNCHRON, after step(): the frame in which the robot stands at this moment; the path begins there."""
        self.coupling.engage(self.part.value(self.tracker.ahead()), self.tracker.speed)
        self.frame = self.part.carrier.frame(self.coupling.value)
        return self.frame

    def release(self) -> None:
        """SYNCHRON_END."""
        self.coupling.release()

    @property
    def caught(self) -> bool:
        """The robot is where the belt is."""
        return self.coupling.state is Hold.ON

    def step(self, period: float) -> Pose:
        """One period further."""
        belt = self.part.belt
        middle = 0.5 * abs(belt.data.increment)  # an increment counts when it is whole: the belt is half of one further on average
        self.tracker.update(belt.way + middle, standing=belt.watch.motion is Motion.STOPPED)
        if self.coupling.state is not Hold.OFF:
            self.coupling.step(self.part.value(self.tracker.ahead()), period)
            self.frame = self.part.carrier.frame(self.coupling.value)
        return self.frame
