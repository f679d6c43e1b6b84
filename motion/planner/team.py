"""Several kinematics that share one clock: their machines, and stretches of path on which they move together."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate, pairwise

import numpy as np

from motion.errors import MotionError
from motion.geometry.limits import AxisLimits
from motion.planner.path_checks import Slowed
from motion.planner.robot import Machine, machine_of
from motion.planner.stretch import Stretch
from motion.program.errors import BlockError
from motion.robot import MOST_AXES, MOST_KINEMATICS, Installation, Robot
from motion.timing.limits import FREE, WAY, Cap, LawLimits


@dataclass(frozen=True)
class Team:
    """names: of the kinematics, one for each machine.  Raises MotionError on more than a cell may hold, and on names that occur twice."""

    names: tuple[str, ...]
    machines: tuple[Machine, ...]

    def __post_init__(self) -> None:
        if not 1 <= len(self.names) == len(self.machines) <= MOST_KINEMATICS:
            raise MotionError(f"{len(self.names)} names, {len(self.machines)} kinematics: as many of both, 1 .. {MOST_KINEMATICS}")
        if self.axes > MOST_AXES:
            raise MotionError(f"{self.axes} axes, at most {MOST_AXES} in one cell")
        axes = [axis.name for axis in self.limits]
        for what, each in (("kinematics", self.names), ("axes", axes)):
            if twice := sorted({name for name in each if list(each).count(name) > 1}):
                raise MotionError(f"two {what} are named {', '.join(twice)}")

    @property
    def limits(self) -> tuple[AxisLimits, ...]:
        """Of all axes, kinematic by kinematic."""
        return tuple(axis for machine in self.machines for axis in machine.limits)

    @property
    def axes(self) -> int:
        """All axes."""
        return sum(machine.axes for machine in self.machines)

    @property
    def firsts(self) -> tuple[int, ...]:
        """First axis of each kinematic, and the number of all axes."""
        return (0, *accumulate(machine.axes for machine in self.machines))

    def split(self, values: Sequence[float]) -> list[tuple[float, ...]]:
        """(all axes,) -> those of each kinematic; MotionError where the number does not fit."""
        if len(values) != self.axes:
            raise MotionError(f"{len(values)} positions for {self.axes} axes")
        firsts = self.firsts
        return [tuple(values[a:b]) for a, b in pairwise(firsts)]

    def column(self, kinematic: int, column: int) -> int:
        """Of a team's path (motion.paths.together) for one of a kinematic's own path."""
        return self.axes + 2 * kinematic + column - WAY if column < 0 else self.firsts[kinematic] + column

    def placed(self, position: Sequence[float], kinematic: int, places: Sequence[float]) -> tuple[float, ...]:
        """(all axes,) where they are, those of one kinematic at other places."""
        rows = self.split(position)
        rows[kinematic] = tuple(places)
        return tuple(value for row in rows for value in row)

    def with_kinematic(self, error: BlockError, kinematic: int) -> BlockError:
        """A fault of one kinematic, with its name."""
        what = f"kinematic {self.names[kinematic]}: {error.what}"
        return BlockError(what, code=error.code, block=error.block, axis=error.axis, source=error.source)

    def law_limits(self, caps: Sequence[Cap]) -> LawLimits:
        """Of all axes, of way and turning of every tool, none of the last two columns."""
        rows = [(axis.speed, axis.accel, axis.jerk) for axis in self.limits]
        for machine in self.machines:
            rows += [(machine.path_speed, machine.path_accel, FREE), (machine.turn_speed, machine.turn_accel, FREE)]
        table = np.array([*rows, (FREE, FREE, FREE), (FREE, FREE, FREE)], dtype=np.float64)
        return LawLimits(table[:, 0], table[:, 1], table[:, 2], tuple(caps))


def team_of(installation: Installation) -> Team:
    """All robots of a cell."""
    return Team(tuple(robot.name for robot in installation.robots), tuple(machine_of(robot) for robot in installation.robots))


def called(name: str, robot: Robot) -> Robot:
    """Return the robot under its own name, its axes included (left.J1): one file may describe several kinematics."""
    axes = (replace(axis, limits=replace(axis.limits, name=f"{name}.{axis.limits.name}")) for axis in robot.axes)
    return replace(robot, name=name, axes=tuple(axes))


@dataclass(frozen=True)
class TeamStretch(Stretch):
    """source: that of the leading kinematic.  parts: (kinematic, its stretch, as long in s as the shared one) of those that move."""

    parts: tuple[tuple[int, Stretch], ...] = field(default=())


def worst(stretches: Iterable[tuple[int, Stretch]]) -> dict[int, Slowed]:
    """Return per slowed block the most slowed axis, from stretches with their block numbers."""
    found: dict[int, Slowed] = {}
    for number, stretch in stretches:
        for _, own in own_parts(stretch):
            if own.slowed is not None and (number not in found or own.slowed.share > found[number].share):
                found[number] = own.slowed
    return found


def own_parts(stretch: Stretch) -> Iterator[tuple[int, Stretch]]:
    """Kinematic and stretch of each that moves; a stretch of one robot is its own."""
    if isinstance(stretch, TeamStretch):
        yield from stretch.parts
    else:
        yield 0, stretch
