"""A robot as a line through its joints, for the picture of the motion page: points in m out of joints in rad and m.

Drawn out of the same robot file the planner uses; a cell without one is drawn as a portal of its linear axes, and marked so.
"""

from collections.abc import Sequence
from typing import Protocol

from gateway.pure.cell.cell import Cell
from gateway.web.points import SHORT_TOOL, Frame, Lines, Point, rounded
from motion.geometry.frames import Pose, compose

Mark = tuple[str, Point]  # name of an axis, and where it acts
UPRIGHT, DOWN = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)


class Skeleton:
    """Polylines of one cell's robot."""

    def __init__(self, cell: Cell) -> None:
        self.kind, self.why = "axes", "the cell has no [robot]: its linear axes are drawn as a portal"
        linear = [n for n, axis in enumerate(cell.axis) if axis.unit == "mm"][:3]
        ends = [cell.axis[n].limits.max / 1000.0 for n in linear]
        self.reach = max(ends, default=1.0)
        self._names = [axis.name for axis in cell.axis]
        self._drawn: Drawn = Portal(linear, ends)
        if cell.robot and cell.robot[0].model:
            self._load(cell.robot[0].model)
        if len(cell.robot) > 1 and not self.why:
            first, *others = (f"{robot.name} ({robot.model})" for robot in cell.robot)
            self.why = f"{first} is drawn, without {', '.join(others)}: their relative position is not known"

    def _load(self, model: str) -> None:
        """Kinematics and robot files are slow to load: only for a cell with a robot."""
        from gateway.files.find import ConfigNotFound
        from gateway.files.robots import RobotFaults
        from gateway.web.robot_lines import Arm
        from motion.errors import MotionError

        try:
            robot = Arm(model)
        except (ConfigNotFound, RobotFaults, OSError, MotionError) as error:
            self.why = f"robot {model}: {error}"
            return
        self.kind, self.why, self.reach, self._drawn = robot.kind, "", robot.reach, robot

    def lines(self, joints: Sequence[float], tool: Sequence[float] = ()) -> Lines:
        """The last point of the first line is the tip.  joints: SI, as many as the robot has axes or more; tool: as the planner's state
        has it; []: not drawable."""
        return self._drawn.lines(joints, tool_pose(tool))

    def frames(self, joints: Sequence[float], tool: Sequence[float] = ()) -> list[Frame]:
        """Base, flange and tool where they are now; those of a robot whose kinematics has no answer are left out."""
        return self._drawn.frames(joints, tool_pose(tool))

    def marks(self, joints: Sequence[float]) -> list[Mark]:
        """Each axis by its name of the cell, where it acts; axes of one place share it."""
        places: dict[Point, list[str]] = {}
        for number, place in self._drawn.places(joints):
            if number < len(self._names):
                places.setdefault(place, []).append(self._names[number])
        return [(", ".join(names), place) for place, names in places.items()]


def tool_pose(tool: Sequence[float]) -> Pose:
    """Position and rotation of twelve numbers; of none: the short piece that only shows a direction."""
    if len(tool) != 12:
        return SHORT_TOOL
    x, y, z, *r = tool
    return Pose((x, y, z), (r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]))


class Drawn(Protocol):
    """Something with joints that can be drawn."""

    def lines(self, joints: Sequence[float], tool: Pose = SHORT_TOOL) -> Lines:
        """Polylines; the last point of the first one is the tip."""

    def frames(self, joints: Sequence[float], tool: Pose = SHORT_TOOL) -> list[Frame]:
        """Base, flange, tool."""

    def places(self, joints: Sequence[float]) -> list[tuple[int, Point]]:
        """Number of an axis, where it acts."""


class Portal:
    """A ram at its trolley and a bridge on two posts, out of up to three linear axes."""

    def __init__(self, linear: Sequence[int], ends: Sequence[float]) -> None:
        self._linear = linear
        self._reach, self._width, self._stroke = max(ends, default=1.0), *(*ends[1:], 0.0, 0.0)[:2]

    def lines(self, joints: Sequence[float], tool: Pose = SHORT_TOOL) -> Lines:
        """joints: m."""
        x, y, z = (*(joints[n] for n in self._linear), 0.0, 0.0, 0.0)[:3]
        top, wide = 1.3 * self._stroke + 0.2 * self._reach, self._width + 0.1 * self._reach
        flange = top - 0.1 * self._reach - z
        ram = [(x, y, top + 0.3 * self._stroke), (x, y, top), (x, y, flange), Pose((x, y, flange), DOWN).apply(tool.position)]
        bridge = [(x, -0.1 * self._reach, 0.0), (x, -0.1 * self._reach, top), (x, wide, top), (x, wide, 0.0)]
        return [[rounded(point) for point in ram], [rounded(point) for point in bridge]]

    def frames(self, joints: Sequence[float], tool: Pose = SHORT_TOOL) -> list[Frame]:
        """A portal's ram looks down."""
        flange, tip = self.lines(joints, tool)[0][-2:]
        return [("base", (0.0, 0.0, 0.0), UPRIGHT), ("flange", flange, DOWN), ("tool", tip, compose(Pose(flange, DOWN), tool).rotation)]

    def places(self, joints: Sequence[float]) -> list[tuple[int, Point]]:
        """The first axis moves the bridge, the second the trolley on it, the third the ram; all others turn at its end."""
        ram, bridge = self.lines(joints)
        found = list(zip(self._linear, (bridge[1], ram[1], ram[0]), strict=False))
        return [*found, *((n, ram[-2]) for n in range(len(joints)) if n not in self._linear)]
