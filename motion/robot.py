"""What a robot is, as plain data, and the kinematics made of it; how much of it one cell may hold.

The files below configs/robots are read at the edge (gateway.files.robots) and arrive here as `Robot`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

from motion.errors import MotionError
from motion.execution.pieces import MAX_AXES
from motion.geometry.conventions import Convention, convention
from motion.geometry.frames import IDENTITY, Pose, Vector
from motion.geometry.limits import AxisLimits
from motion.geometry.workspace import Workspace
from motion.kinematics.arm6 import Arm6, ArmGeometry
from motion.kinematics.base import Kinematics
from motion.kinematics.coupled import Coupled
from motion.kinematics.group import Additional, Group, Role
from motion.kinematics.identity import Identity
from motion.kinematics.portal import Portal
from motion.kinematics.scara import Scara

MOST_KINEMATICS, MOST_AXES, MOST_BELTS = 16, MAX_AXES, 8


class Kind(Enum):
    """What geometry a robot has."""

    IDENTITY, PORTAL, SCARA, ARM6, URDF = "identity", "portal", "scara", "arm6", "urdf"


@dataclass(frozen=True, slots=True)
class ScaraGeometry:
    """m."""

    arm: float
    forearm: float
    height: float
    down: bool = True


@dataclass(frozen=True, slots=True)
class PortalGeometry:
    """letters of the axes in their order; flange: where the wrist carries it."""

    letters: str
    flange: Pose = IDENTITY


@dataclass(frozen=True, slots=True)
class UrdfGeometry:
    """The text of a URDF and the link or joint that is the flange."""

    text: str
    frame: str


Geometry = ArmGeometry | ScaraGeometry | PortalGeometry | UrdfGeometry | None


@dataclass(frozen=True, slots=True)
class AxisOfRobot:
    """Limits in SI, and where the figures come from (a document, or "assumed")."""

    limits: AxisLimits
    source: str
    role: Role | None = None  # of additional axes
    direction: Vector = (0.0, 0.0, 1.0)
    origin: Pose = IDENTITY


@dataclass(frozen=True, slots=True)
class Robot:
    """One robot: geometry, axes (own ones first, then additional ones), couplings, place in the cell, how angles are written."""

    name: str
    kind: Kind
    geometry: Geometry
    axes: tuple[AxisOfRobot, ...]
    angles: str = "val3"
    base: Pose = IDENTITY  # position of the robot (rho 3: P310)
    coupling: tuple[tuple[float, ...], ...] = ()
    source: str = "assumed"
    shape: str = "jerk"  # of blocks without their own shape: jerk or sin2
    too_fast: str | int = "slow"  # what becomes of a path too fast for an axis (motion.timing.limiter.too_fast)

    @property
    def own(self) -> tuple[AxisLimits, ...]:
        """Limits of the axes of the geometry."""
        return tuple(axis.limits for axis in self.axes if axis.role is None)

    @property
    def limits(self) -> tuple[AxisLimits, ...]:
        """Limits of all axes."""
        return tuple(axis.limits for axis in self.axes)

    @property
    def convention(self) -> Convention:
        """How its control writes orientations."""
        return convention(self.angles)


def with_limits(robot: Robot, limits: Sequence[AxisLimits]) -> Robot:
    """The robot on the axes of a cell, as many as it has: their names, travel and speeds choose its configurations and turns, too."""
    axes = zip(robot.axes, limits, strict=True)
    return replace(robot, axes=tuple(replace(axis, limits=own) for axis, own in axes))


def kinematics_of(robot: Robot) -> Kinematics:
    """The kinematics; raises MotionError where axes and geometry do not fit."""
    roles = [axis.role is not None for axis in robot.axes]
    if roles != sorted(roles):
        raise MotionError(f"robot {robot.name}: additional axes come last")
    made = _geometric(robot)
    if robot.coupling:
        made = Coupled(made, robot.coupling, robot.own)
    extra = [Additional(axis.limits, axis.role, axis.direction, axis.origin) for axis in robot.axes if axis.role is not None]
    return Group(made, extra) if extra else made


def workspace_of(robot: Robot, frame: Pose = IDENTITY, tool: Pose = IDENTITY) -> Workspace:
    """The robot at its place in the cell, with a user frame (in the cell) and a tool (on the flange)."""
    return Workspace(kinematics_of(robot), robot.base, frame, tool)


def _geometric(robot: Robot) -> Kinematics:
    limits = robot.own
    match robot.geometry:
        case None:
            return Identity(limits)
        case ArmGeometry() as geometry:
            return Arm6(geometry, limits)
        case ScaraGeometry(arm, forearm, height, down):
            return Scara(arm, forearm, height, limits, down=down)
        case PortalGeometry(letters, flange):
            return Portal(letters, limits, flange)
        case UrdfGeometry(text, frame):
            try:
                from motion.kinematics.urdf import Urdf  # pinocchio is loaded only where a URDF is used
            except ImportError as error:
                raise MotionError(
                    f"a robot of a URDF needs pinocchio, which is not installed ({error}): pip install 'axisgate[urdf]'"
                ) from error

            return Urdf(text, frame, limits)


@dataclass(frozen=True, slots=True)
class Installation:
    """All robots of a cell and the number of its belts."""

    robots: tuple[Robot, ...]
    belts: int = 0

    def __post_init__(self) -> None:
        faults = list(self._faults())
        if faults:
            raise MotionError("; ".join(faults))

    def _faults(self) -> Sequence[str]:
        axes = sum(len(robot.axes) for robot in self.robots)
        names = [robot.name for robot in self.robots]
        axis_names = [axis.name for robot in self.robots for axis in robot.limits]
        counted = ((len(self.robots), MOST_KINEMATICS, "kinematics"), (axes, MOST_AXES, "axes"), (self.belts, MOST_BELTS, "belts"))
        faults = [f"{count} {what}, at most {most} in one cell" for count, most, what in counted if count > most]
        if self.belts < 0:
            faults.append(f"{self.belts} belts")
        faults += [f"two kinematics are named {name}" for name in sorted({name for name in names if names.count(name) > 1})]
        return faults + [f"two axes are named {name}" for name in sorted({name for name in axis_names if axis_names.count(name) > 1})]
