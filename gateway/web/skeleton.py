"""A robot as a line through its joints, for the picture of the motion page: points in m out of joints in rad and m.

Drawn out of the same robot file the planner uses; a cell without one is drawn as a portal of its linear axes, and says so.
"""

import math
from collections.abc import Sequence

from gateway.cell import Cell
from gateway.files import ConfigNotFound
from gateway.robotfile import RobotFaults, load_robot
from motion.errors import MotionError
from motion.frames import IDENTITY, Pose, compose
from motion.kinematics.arm6 import ArmGeometry
from motion.kinematics.base import Kinematics
from motion.robot import Robot, ScaraGeometry, kinematics_of

Point = tuple[float, float, float]


class Skeleton:
    """Points from the base to the flange, one polyline."""

    def __init__(self, cell: Cell) -> None:
        self.kind, self.why = "axes", "the cell has no [robot]: its linear axes are drawn as a portal"
        self._robot: Robot | None = None
        self._kinematics: Kinematics | None = None
        self._linear = [n for n, axis in enumerate(cell.axis) if axis.unit == "mm"][:3]
        self.reach = max([axis.limits.max / 1000.0 for axis in cell.axis if axis.unit == "mm"], default=1.0)
        if cell.robot is not None and cell.robot.model:
            try:
                self._robot = load_robot(cell.robot.model)
                self._kinematics = kinematics_of(self._robot)
                self.kind, self.why = self._robot.kind.value, ""
                self.reach = _reach(self._robot)
            except (ConfigNotFound, RobotFaults, OSError, MotionError) as error:
                self.why = f"robot {cell.robot.model}: {error}"

    def points(self, joints: Sequence[float]) -> list[Point]:
        """joints: SI, at least as many as the robot has axes; [] for a place it cannot be drawn at."""
        if self._robot is None or self._kinematics is None:
            return self._portal(joints)
        try:
            flange = self._kinematics.forward(joints[: self._kinematics.axes])
        except MotionError:
            return []
        match self._robot.geometry:
            case ArmGeometry() as arm:
                inner = _arm(arm, joints)
            case ScaraGeometry() as scara:
                inner = _scara(scara, joints, flange)
            case _:
                inner = [(0.0, 0.0, 0.0), flange.position]
        base = self._robot.base
        tip = compose(base, flange) if base != IDENTITY else flange
        return [_round(base.apply(point)) for point in inner] + [_round(tip.position), *_gripper(tip)]

    def _portal(self, joints: Sequence[float]) -> list[Point]:
        """Bridge, trolley and ram."""
        x, y, z = (*(joints[n] for n in self._linear), 0.0, 0.0, 0.0)[:3]
        top = self.reach * 0.6
        return [_round(point) for point in ((x, 0.0, top), (x, y, top), (x, y, top - z), (x, y, top - z - 0.05))]


def _arm(arm: ArmGeometry, joints: Sequence[float]) -> list[Point]:
    """Foot, shoulder, elbow, wrist; as motion.kinematics.arm6 writes the angles."""
    t1, t2, t3 = (arm.signs[n] * joints[n] + arm.offsets[n] for n in range(3))
    c1, s1 = math.cos(t1), math.sin(t1)

    def at(forwards: float, up: float) -> Point:
        return c1 * forwards - s1 * arm.side, s1 * forwards + c1 * arm.side, up

    elbow = arm.delta + arm.arm * math.sin(t2), arm.height + arm.arm * math.cos(t2)
    both = t2 + t3
    wrist = (
        elbow[0] + arm.forearm * math.sin(both) + arm.elbow * math.cos(both),
        elbow[1] + arm.forearm * math.cos(both) - arm.elbow * math.sin(both),
    )
    return [(0.0, 0.0, 0.0), (0.0, 0.0, arm.height), at(arm.delta, arm.height), at(*elbow), at(*wrist)]


def _scara(scara: ScaraGeometry, joints: Sequence[float], flange: Pose) -> list[Point]:
    """Column, both arms at the height of the column, the stroke down to the flange."""
    up = scara.height + 0.25 * (scara.arm + scara.forearm)
    x, y = scara.arm * math.cos(joints[0]), scara.arm * math.sin(joints[0])
    return [(0.0, 0.0, 0.0), (0.0, 0.0, up), (x, y, up), (flange.position[0], flange.position[1], up)]


def _gripper(tip: Pose) -> list[Point]:
    """A short piece along the flange's own z, so that its direction is seen."""
    return [_round(tip.apply((0.0, 0.0, 0.06)))]


def _reach(robot: Robot) -> float:
    match robot.geometry:
        case ArmGeometry() as arm:
            return arm.height + arm.arm + math.hypot(arm.forearm, arm.elbow) + arm.flange
        case ScaraGeometry() as scara:
            return scara.arm + scara.forearm + abs(scara.height)
    return max([abs(axis.upper) for axis in robot.limits if axis.unit == "mm"], default=1.0)


def _round(point: Sequence[float]) -> Point:
    return round(point[0], 4), round(point[1], 4), round(point[2], 4)
