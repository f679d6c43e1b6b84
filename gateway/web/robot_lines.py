"""The robot of a cell as lines: joints by the same geometry the planner uses, the flange by its kinematics."""

import math
from collections.abc import Sequence

from gateway.files.robots import load_robot
from gateway.web.points import SHORT_TOOL, Frame, Lines, Point, rounded
from motion.errors import MotionError
from motion.geometry.frames import Pose, compose
from motion.kinematics.arm6 import ArmGeometry
from motion.kinematics.group import Group, Role
from motion.robot import Robot, ScaraGeometry, kinematics_of


class Arm:
    """One robot of configs/robots; raises the exceptions of load_robot, MotionError."""

    def __init__(self, model: str) -> None:
        self._robot = load_robot(model)
        self._kinematics = kinematics_of(self._robot)
        self.kind, self.reach = self._robot.kind.value, _reach(self._robot)

    def lines(self, joints: Sequence[float], tool: Pose = SHORT_TOOL) -> Lines:
        """joints: rad and m; tool: on the flange; [] where its kinematics has no answer."""
        found = self._poses(joints)
        if found is None:
            return []
        base, flange = found
        beside: list[Point] = []
        match self._robot.geometry:
            case ArmGeometry() as arm:
                inner = _arm(arm, joints)
            case ScaraGeometry() as scara:
                inner = _scara(scara, joints, flange)
            case _:
                inner, beside = _portal(self._robot, flange)
        tip = compose(base, flange)
        first = [rounded(point) for point in (*(base.apply(each) for each in inner), tip.position, tip.apply(tool.position))]
        return [first, [rounded(base.apply(point)) for point in beside]] if beside else [first]

    def _poses(self, joints: Sequence[float]) -> tuple[Pose, Pose] | None:
        """Base in the cell, flange on the base; None where the kinematics has no answer."""
        whole, base = self._kinematics, self._robot.base
        arm_alone = whole.main if isinstance(whole, Group) else whole
        try:
            flange = arm_alone.forward(joints[: arm_alone.axes])
            return compose(base, whole.base(joints[: whole.axes])) if isinstance(whole, Group) else base, flange
        except MotionError:
            return None

    def frames(self, joints: Sequence[float], tool: Pose = SHORT_TOOL) -> list[Frame]:
        """Base, flange, and the tool's own frame."""
        found = self._poses(joints)
        if found is None:
            return []
        base, flange = found
        tip = compose(base, flange)
        return [
            ("base", rounded(base.position), base.rotation),
            ("flange", rounded(tip.position), tip.rotation),
            ("tool", rounded(tip.apply(tool.position)), compose(tip, tool).rotation),
        ]

    def places(self, joints: Sequence[float]) -> list[tuple[int, Point]]:
        """Axes 1 to 3 of an arm at their joints, the wrist's at the wrist; carriers and others at the base."""
        lines = self.lines(joints)
        if not lines:
            return []
        line, own = lines[0], len(self._robot.own)
        match self._robot.geometry:
            case ArmGeometry():
                at = [line[1], line[2], line[3], line[4], line[4], line[5]]
            case ScaraGeometry():
                at = [line[1], line[2], line[3], line[-2]]
            case _ if len(lines) > 1:
                posts = lines[1]
                at = [posts[1], line[0], line[-2]]
            case _:
                at = []
        at += [line[-2]] * (own - len(at))
        return [*enumerate(at[:own]), *((n, line[0]) for n in range(own, min(len(self._robot.axes), len(joints))))]


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


def _portal(robot: Robot, flange: Pose) -> tuple[list[Point], list[Point]]:
    """The ram at the height of the bridge, and the bridge on its two posts; fewer than three linear axes: a line from the foot."""
    linear = [axis for axis in robot.limits if axis.unit == "mm"][:3]
    if len(linear) < 3:
        return [(0.0, 0.0, 0.0)], []
    (x, y, _), across, down = flange.position, linear[1], linear[2]
    top, foot = down.upper + 0.1 * (down.upper - down.lower), down.lower
    posts = [(x, across.lower, foot), (x, across.lower, top), (x, across.upper, top), (x, across.upper, foot)]
    return [(x, y, top)], posts


def _reach(robot: Robot) -> float:
    """m; including the travel of its carriers."""
    carriers = [axis.limits for axis in robot.axes if axis.role is Role.CARRIER and axis.limits.unit == "mm"]
    return _alone(robot) + sum(max(abs(axis.lower), abs(axis.upper)) for axis in carriers)


def _alone(robot: Robot) -> float:
    match robot.geometry:
        case ArmGeometry() as arm:
            return arm.height + arm.arm + math.hypot(arm.forearm, arm.elbow) + arm.flange
        case ScaraGeometry() as scara:
            return scara.arm + scara.forearm + abs(scara.height)
    return max([abs(axis.upper) for axis in robot.own if axis.unit == "mm"], default=1.0)
