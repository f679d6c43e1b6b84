"""What a synchronous part is made of: the robot on its axes of the cell, its ride on a belt of type 1, its way over one of types 2 and 3.
Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from motion.geometry.frames import Pose, Rotation, compose
from motion.geometry.limits import AxisLimits
from motion.kinematics.base import PathKinematics
from motion.sync.belt_frame import Carried
from motion.sync.join import SyncStepper
from motion.sync.parallel import Hold
from motion.sync.synchronous_part import Phase, SynchronPart


@dataclass(slots=True)
class BeltRobots:
    """Kinematics by number, each on the axes of the cell, with the limits of all of these; `now`: the one of the part."""

    numbered: Mapping[int, PathKinematics]
    limits: tuple[AxisLimits, ...]
    now: PathKinematics

    def choose(self, number: int) -> None:
        self.now = self.numbered[number]

    def place_of(self, name: str) -> int:
        """Number of an axis, from 1; 0: there is none of that name."""
        return next((n for n, axis in enumerate(self.limits, 1) if axis.name == name), 0)

    def slowest(self, before: Sequence[float], after: Sequence[float]) -> int:
        """The axis nearest to its speed limit between these, from 1."""
        shares = [abs(b - a) / axis.speed for a, b, axis in zip(before, after, self.limits, strict=False)]
        return shares.index(max(shares)) + 1


@dataclass(slots=True)
class BeltRide:
    """Type 1: the robot is carried, from `rig` on."""

    bearing: PathKinematics  # what the belt moves
    carried: Carried | None = None
    rig: SyncStepper | None = None
    waited: int = 0  # cycles since the belt was where the part begins
    reference: float = 0.0  # belt value at which the path was planned

    @property
    def leaving(self) -> bool:
        """It gets off, or has."""
        return self.rig is not None and self.carried is not None and self.carried.coupling.state in (Hold.LEAVING, Hold.OFF)

    @property
    def value(self) -> float:
        """Of the robot's frame."""
        return self.carried.coupling.value if self.carried is not None else 0.0

    def framed(self, carried: Carried, frame: Pose) -> Pose:
        """The belt's frame from the value the path was planned at."""
        if self.reference == 0.0:
            return frame
        return compose(carried.part.carrier.frame(self.reference).inverse(), frame)

    def drop(self) -> None:
        self.rig, self.carried = None, None


@dataclass(slots=True)
class BeltWay:
    """Types 2 and 3: the part defines the tool's coordinates, with constant rotation."""

    part: SynchronPart | None = None
    rotation: Rotation | None = None  # of the tool at the start

    def in_phase(self, phase: Phase) -> bool:
        return self.part is not None and self.part.phase is phase
