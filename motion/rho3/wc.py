"""Workpiece coordinate systems: WC_FRAME, WC_SYSTEM, WC_UR, P313.  Source: rho 3 Releases part 1, TO06 section 6, L8795-9070.

A frame (dx, dy, dz mm, da, db, dc deg) is the workpiece's zero in the original system; dc turns about z, then db
about y', then da about x'' (L8817).  P313 selects for x, y, z, a, b, c which component of a world point holds it, 0 for none: coordinates
without a component of the machine are not corrected (L8905-8937).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from motion.errors import MotionError
from motion.geometry.conventions import RHO3
from motion.geometry.frames import IDENTITY, Pose, compose

LONGEST_NAME = 12
MOST_COMPONENTS = 24


@dataclass(frozen=True, slots=True)
class WcFrame:
    """One value of the type; kinematic: the only one it is valid for (empty: a value that is not a declared variable)."""

    dx: float = 0.0
    dy: float = 0.0
    dz: float = 0.0
    da: float = 0.0
    db: float = 0.0
    dc: float = 0.0
    kinematic: str = ""
    name: str = ""

    def __post_init__(self) -> None:
        if not all(map(math.isfinite, self.values)):
            raise MotionError(f"WC_FRAME {self.name}: six finite numbers are needed, not {self.values}")
        if len(self.name) > LONGEST_NAME:
            raise MotionError(f"WC_FRAME {self.name}: a name has at most {LONGEST_NAME} characters")

    @property
    def values(self) -> tuple[float, float, float, float, float, float]:
        """In the order of the six components."""
        return self.dx, self.dy, self.dz, self.da, self.db, self.dc

    @property
    def pose(self) -> Pose:
        """The workpiece's system in the original one."""
        return RHO3.pose(self.values)


WC_UR = WcFrame()


class WcSystems:
    """WC_SYSTEM of all kinematics: valid for programs and processes alike until changed; only a start-up brings WC_UR back."""

    def __init__(self) -> None:
        self._active: dict[str, WcFrame] = {}

    def select(self, kinematic: str, frame: WcFrame) -> None:
        """kinematic.WC_SYSTEM = frame; a frame declared for another kinematic is refused (L8842)."""
        if frame.kinematic and frame.kinematic != kinematic:
            raise MotionError(f"WC_FRAME {frame.name} belongs to {frame.kinematic}, not to {kinematic}")
        self._active[kinematic] = frame

    def active(self, kinematic: str) -> WcFrame:
        """The frame in force; WC_UR where none was chosen."""
        return self._active.get(kinematic, WC_UR)

    def program_ended(self, kinematic: str) -> None:
        """After END, and after an abort (emergency stop, automatic to manual, reset), the last frame stays (L9015-9021)."""

    def started_up(self) -> None:
        """Start-up of the control: the original system everywhere (L9023)."""
        self._active.clear()


@dataclass(frozen=True, slots=True)
class Assignment:
    """P313: numbers (from 1) of the world point's components that hold x, y, z, a, b, c; 0 = no such component."""

    numbers: tuple[int, int, int, int, int, int] = (1, 2, 3, 4, 5, 6)

    def __post_init__(self) -> None:
        used = [number for number in self.numbers if number]
        if any(not 0 <= number <= MOST_COMPONENTS for number in self.numbers) or len(set(used)) < len(used):
            raise MotionError(f"P313 {self.numbers}: six numbers of components, each at most once, 0 for none")

    def pose(self, point: Sequence[float]) -> Pose:
        """Convert components (mm, deg) to a pose; missing components are 0."""
        if any(number > len(point) for number in self.numbers):
            raise MotionError(f"P313 {self.numbers} names components that a point of {len(point)} does not have")
        return RHO3.pose([point[number - 1] if number else 0.0 for number in self.numbers])

    def put(self, point: Sequence[float], pose: Pose) -> tuple[float, ...]:
        """`point` with the components that P313 names taken from `pose`; the others stay."""
        changed = list(point)
        for number, value in zip(self.numbers, RHO3.values(pose), strict=True):
            if number:
                changed[number - 1] = value
        return tuple(changed)

    def moved(self, point: Sequence[float], by: Pose) -> tuple[float, ...]:
        """A point seen from outside of `by`: its position wholly, its orientation as far as there are components for it."""
        return tuple(point) if by == IDENTITY else self.put(point, compose(by, self.pose(point)))
