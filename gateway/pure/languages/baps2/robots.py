"""Kinematics of a cell as BAPS2 programs count their points: mm and degrees, as many components as axes, in the angles of the rho 3."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from gateway.pure.languages.baps2.errors import fault
from motion.errors import MotionError
from motion.geometry.conventions import CONVENTIONS
from motion.geometry.units import from_si, to_si
from motion.kinematics.identity import Identity
from motion.kinematics.portal import Portal
from motion.planner.robot import Machine

RHO3 = CONVENTIONS["rho3"]
ORIENTED = {4: (5,), 6: (3, 4, 5)}  # axes of the arm -> places of its angles among x y z a b c


@dataclass(frozen=True, slots=True)
class CellRobot:
    """A robot of the cell.  number: from 1; first: its first axis in the cell, from 0."""

    number: int
    first: int
    machine: Machine

    @property
    def size(self) -> int:
        """Components of its points."""
        return self.machine.axes

    @property
    def plain(self) -> bool:
        """World coordinates are those of the axes."""
        return isinstance(self.machine.kinematics, Identity)

    @property
    def straight(self) -> bool:
        """Its lines are straight in its axes, too."""
        return isinstance(self.machine.kinematics, Identity | Portal)

    @property
    def units(self) -> tuple[str, ...]:
        """mm or deg of each axis."""
        return tuple(axis.unit for axis in self.machine.limits)

    def own(self, places: Sequence[float]) -> tuple[float, ...]:
        """Its axes among those of the cell."""
        return tuple(places[self.first : self.first + self.size])

    def _si(self, joints: Sequence[float]) -> tuple[float, ...]:
        return tuple(to_si(value, unit) for value, unit in zip(joints, self.units, strict=True))

    def six(self, joints: Sequence[float]) -> tuple[float, ...]:
        """x y z a b c of the flange."""
        return RHO3.values(self.machine.forward(self._si(joints)))

    def _places(self) -> tuple[int, ...]:
        """Return where the components of the arm are among x y z a b c.  Raise a runtime error for arms without such a rule."""
        arm = self.machine.arm
        if arm <= 3:
            return (0, 1, 2)[:arm]
        if arm not in ORIENTED:
            raise fault(222, f"world coordinates of an arm of {arm} axes; use joint points (@)")
        return (0, 1, 2, *ORIENTED[arm])

    def world(self, joints: Sequence[float]) -> tuple[float, ...]:
        """Return world coordinates of joints, followed by the additional axes."""
        if self.plain:
            return tuple(joints)
        six = self.six(joints)
        return (*(six[place] for place in self._places()), *joints[self.machine.arm :])

    def filled(self, world: Sequence[float], near: Sequence[float]) -> tuple[float, ...]:
        """Return x y z a b c of a point; components that it omits keep their value at the joints `near`."""
        six = list(self.six(near))
        for place, value in zip(self._places(), world, strict=False):
            six[place] = value
        return tuple(six)

    def joints(self, world: Sequence[float], near: Sequence[float]) -> tuple[float, ...]:
        """Joints of world coordinates, near those given."""
        if self.plain:
            return tuple(world)
        try:
            found = self.machine.inverse(RHO3.pose(self.filled(world, near)), self._si(near))
        except MotionError as error:
            raise fault(205, str(error)) from error
        arm = self.machine.arm
        own = tuple(from_si(value, unit) for value, unit in zip(found, self.units, strict=True))
        return (*own[:arm], *world[arm:])

    def target(self, world: Sequence[float], near: Sequence[float]) -> str:
        """A world point as the text form has it."""
        if self.plain:
            return self.text("joints", world)
        extra = self.extra(world)
        return f"{self.text('pose', self.filled(world, near))}{extra}"

    def shift(self, values: Sequence[float], *, joint: bool) -> str:
        """A relative target as the text form has it."""
        if joint or self.plain:
            return self.text("rel joints", values)
        six = [0.0] * 6
        for place, value in zip(self._places(), values, strict=False):
            six[place] = value
        return f"{self.text('rel pose', six)}{self.extra(values)}"

    def extra(self, world: Sequence[float]) -> str:
        """Additional axes of a world point."""
        arm = self.machine.arm
        if len(world) <= arm:
            return ""
        return " extra=" + ",".join(f"{value:.10g}{unit}" for value, unit in zip(world[arm:], self.units[arm:], strict=True))

    @staticmethod
    def text(word: str, values: Sequence[float]) -> str:
        """Numbers of the text form."""
        if not all(math.isfinite(value) for value in values):
            raise fault(205, "a component is not a number")
        return f"{word} {' '.join(f'{value:.10g}' for value in values)}"
