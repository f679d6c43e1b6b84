"""A robot as a line through its joints, for the picture of the motion page: points in m out of joints in rad and m.

Drawn out of the same robot file the planner uses; a cell without one is drawn as a portal of its linear axes, and says so.
"""

from collections.abc import Callable, Sequence

from gateway.pure.cell.cell import Cell

Point = tuple[float, float, float]
Lines = list[list[Point]]
GRIPPER_M = 0.06  # a short piece along the flange's own z, so that its direction is seen


class Skeleton:
    """Polylines of one cell's robot."""

    def __init__(self, cell: Cell) -> None:
        self.kind, self.why = "axes", "the cell has no [robot]: its linear axes are drawn as a portal"
        linear = [n for n, axis in enumerate(cell.axis) if axis.unit == "mm"][:3]
        ends = [cell.axis[n].limits.max / 1000.0 for n in linear]
        self.reach = max(ends, default=1.0)
        self._draw: Callable[[Sequence[float]], Lines] = Portal(linear, ends).lines
        if cell.robot and cell.robot[0].model:
            self._load(cell.robot[0].model)
        if len(cell.robot) > 1 and not self.why:
            first, *others = (f"{robot.name} ({robot.model})" for robot in cell.robot)
            self.why = f"{first} is drawn, without {', '.join(others)}: where they stand to each other is not known"

    def _load(self, model: str) -> None:
        """Kinematics and robot files are loaded only where a cell has a robot: they take their time."""
        from gateway.files.find import ConfigNotFound
        from gateway.files.robots import RobotFaults
        from gateway.web.robot_lines import Arm
        from motion.errors import MotionError

        try:
            robot = Arm(model)
        except (ConfigNotFound, RobotFaults, OSError, MotionError) as error:
            self.why = f"robot {model}: {error}"
            return
        self.kind, self.why, self.reach, self._draw = robot.kind, "", robot.reach, robot.lines

    def lines(self, joints: Sequence[float]) -> Lines:
        """The last point of the first line is the tip.  joints: SI, as many as the robot has axes or more; []: not drawable."""
        return self._draw(joints)


class Portal:
    """A ram at its trolley and a bridge on two posts, out of up to three linear axes."""

    def __init__(self, linear: Sequence[int], ends: Sequence[float]) -> None:
        self._linear = linear
        self._reach, self._width, self._stroke = max(ends, default=1.0), *(*ends[1:], 0.0, 0.0)[:2]

    def lines(self, joints: Sequence[float]) -> Lines:
        """joints: m."""
        x, y, z = (*(joints[n] for n in self._linear), 0.0, 0.0, 0.0)[:3]
        top, wide = 1.3 * self._stroke + 0.2 * self._reach, self._width + 0.1 * self._reach
        ram = [(x, y, top + 0.3 * self._stroke), (x, y, top), (x, y, top - 0.1 * self._reach - z)]
        bridge = [(x, -0.1 * self._reach, 0.0), (x, -0.1 * self._reach, top), (x, wide, top), (x, wide, 0.0)]
        return [[rounded(point) for point in ram], [rounded(point) for point in bridge]]


def rounded(point: Sequence[float]) -> Point:
    """To a tenth of a millimetre."""
    return round(point[0], 4), round(point[1], 4), round(point[2], 4)
