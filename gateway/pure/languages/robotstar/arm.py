"""The robot of a cell as ROBOTstar programs count its positions: tool centre point in mm and degrees, axes by name."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.path import Target
from gateway.pure.languages.robotstar.values import Structure
from motion.errors import MotionError
from motion.geometry.conventions import convention
from motion.geometry.frames import IDENTITY, Pose
from motion.geometry.units import from_si, to_si
from motion.kinematics.base import KinematicsError
from motion.kinematics.identity import Identity
from motion.planner.robot import Machine

REIS = convention("reis")
FREE = {1: (), 2: (), 3: (), 4: (5,), 5: (3, 4, 5), 6: (3, 4, 5)}  # axes of the arm -> angles among X Y Z A B C it can turn
TOOL = ("X", "Y", "Z", "RX", "RY", "RZ")


def tool_values(tool: Structure | None) -> tuple[float, ...]:
    """X Y Z RX RY RZ of a tool."""
    return (0.0,) * 6 if tool is None else tuple(tool.number(name) for name in TOOL)


@dataclass(frozen=True, slots=True)
class Arm:
    """first: its first axis in the cell, from 0; stations: frame number -> where the frame is in the basic system."""

    first: int
    machine: Machine
    stations: Mapping[int, Pose] = field(default_factory=dict)

    @property
    def plain(self) -> bool:
        """It has no geometry: its positions are those of its axes."""
        return isinstance(self.machine.kinematics, Identity)

    @property
    def units(self) -> tuple[str, ...]:
        """mm or deg of each axis."""
        return tuple(axis.unit for axis in self.machine.limits)

    def own(self, places: Sequence[float]) -> tuple[float, ...]:
        """Its axes among those of the cell."""
        return tuple(places[self.first : self.first + self.machine.axes])

    def flange(self, axes: Sequence[float]) -> Pose:
        """Where the flange is."""
        return self.machine.forward(tuple(to_si(value, unit) for value, unit in zip(axes, self.units, strict=True)))

    def actual(self, axes: Sequence[float], tool: Structure | None) -> Target:
        """The position of the tool, with the additional axes; of a robot without geometry its axes."""
        named = {f"A{number}": value for number, value in enumerate(axes, 1)}
        if self.plain:
            return Target((), 0, named)
        pose = REIS.values(self.flange(axes) @ self._tool(tool))
        return Target(pose, 0, {name: value for name, value in named.items() if int(name[1:]) > self.machine.arm})

    def based(self, target: Target) -> Target:
        """A position of a station in the basic system; StepFault: the cell has no such station."""
        if not target.frame:
            return target
        if not target.pose:
            return Target((), 0, target.axes)
        return Target(REIS.values(self._station(target.frame) @ REIS.pose(target.pose)), 0, target.axes)

    def seen_from(self, number: int, target: Target) -> Target:
        """A position of the basic system in a station's frame."""
        if not number or not target.pose:
            return Target(target.pose, number, target.axes)
        return Target(REIS.values(self._station(number).inverse() @ REIS.pose(target.pose)), number, target.axes)

    def _station(self, number: int) -> Pose:
        if number not in self.stations:
            known = ", ".join(str(each) for each in sorted(self.stations)) or "none"
            raise StepFault(f"frame {number}: this cell has no such station; [[controller.station]] names {known}")
        return self.stations[number]

    @staticmethod
    def _tool(tool: Structure | None) -> Pose:
        return IDENTITY if tool is None else REIS.pose(tool_values(tool))

    def text(self, target: Target, near: Target) -> str:
        """Return the position in the text form; angles that an arm of fewer than five axes cannot turn, and additional axes that the
        position omits, are as in `near`.  Raise StepFault where this robot has no such position.
        """
        if not target.pose:
            return self._joints(target, near)
        if self.plain:
            raise StepFault("a position of the tool needs the geometry of the robot; state the position by its axes, A1:..")
        pose = self._filled(target, near)
        self._known(target)
        extra = [self._axis(number, target, near) for number in range(self.machine.arm + 1, self.machine.axes + 1)]
        named = zip(extra, self.units[self.machine.arm :], strict=True)
        return _numbers("pose", pose) + (" extra=" + ",".join(f"{value:.10g}{unit}" for value, unit in named) if extra else "")

    def _filled(self, target: Target, near: Target) -> list[float]:
        pose, free = list(target.pose), FREE.get(self.machine.arm, (3, 4, 5))
        for place in (3, 4, 5) if near.pose else ():
            if place not in free:
                pose[place] = near.pose[place]
        return pose

    def unreachable(self, target: Target, near: Target, tool: Structure | None, axes: Sequence[float]) -> str:
        """Why the robot does not get there from where its axes are; "" where it does, as far as the position alone shows."""
        for name, value in target.axes.items():
            limits = self.machine.limits[int(name[1:]) - 1]
            if not limits.lower - 1e-9 <= to_si(value, limits.unit) <= limits.upper + 1e-9:
                low, high = (from_si(each, limits.unit) for each in (limits.lower, limits.upper))
                return f"{name} {value:g} is outside {low:g} .. {high:g} {limits.unit}"
        if target.pose:
            try:
                flange = REIS.pose(self._filled(target, near)) @ self._tool(tool).inverse()
                self.machine.inverse(flange, tuple(to_si(value, unit) for value, unit in zip(axes, self.units, strict=True)))
            except KinematicsError as error:
                return error.plain
            except MotionError as error:
                return str(error)
        return ""

    def _joints(self, target: Target, near: Target) -> str:
        self._known(target)
        missing = [number for number in range(1, self.machine.arm + 1) if f"A{number}" not in target.axes]
        if missing:
            raise StepFault(f"a position by axes needs A1 to A{self.machine.arm}; A{missing[0]} is missing")
        return _numbers("joints", [self._axis(number, target, near) for number in range(1, self.machine.axes + 1)])

    def _known(self, target: Target) -> None:
        for name in target.axes:
            if int(name[1:]) > self.machine.axes:
                raise StepFault(f"{name}: the robot has {self.machine.axes} axes")

    @staticmethod
    def _axis(number: int, target: Target, near: Target) -> float:
        name = f"A{number}"
        return target.axes[name] if name in target.axes else near.axes.get(name, 0.0)


def _numbers(word: str, values: Sequence[float]) -> str:
    if not all(math.isfinite(value) for value in values):
        raise StepFault("a component of the position is not a number")
    return f"{word} {' '.join(f'{value:.10g}' for value in values)}"
