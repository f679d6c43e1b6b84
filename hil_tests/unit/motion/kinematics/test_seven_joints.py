"""An arm of seven joints out of a URDF: its inverse, and lines run along it."""

import math

import numpy as np
import pytest

from hil_tests.lab.cells.motion_paths import worst_shares
from hil_tests.unit.motion.kinematics.robots import apart, spread
from motion.geometry.frames import Pose
from motion.kinematics.group import Group
from motion.kinematics.urdf import Urdf
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.planner.trace import trace
from motion.program.blocks import Block, Interpolation, Pace, PoseTarget
from motion.program.errors import BlockError

OFFSETS = ("0 0 0.15", "0 0 0.19", "0 0 0.21", "0 0 0.19", "0 0 0.21", "0 0 0.19", "0 0 0.081")
AXES = ("0 0 1", "0 1 0", "0 0 1", "0 -1 0", "0 0 1", "0 1 0", "0 0 1")
START = (0.3, 0.6, -0.2, -1.2, 0.2, 0.9, 0.1)


def seven() -> Urdf:
    """Of the build of a KUKA iiwa."""
    joints = "".join(
        f'<joint name="j{n}" type="revolute"><parent link="l{n - 1}"/><child link="l{n}"/><origin xyz="{place}"/><axis xyz="{axis}"/>'
        '<limit lower="-2.9" upper="2.9" velocity="1.7" effort="1"/></joint>'
        for n, (place, axis) in enumerate(zip(OFFSETS, AXES, strict=True), 1)
    )
    links = "".join(f'<link name="l{n}"/>' for n in range(9))
    tip = '<joint name="tip" type="fixed"><parent link="l7"/><child link="l8"/><origin xyz="0 0 0.045"/></joint>'
    return Urdf(f'<robot name="seven">{links}{joints}{tip}</robot>', "l8")


def test_poses_are_reached_from_near_and_from_far_away() -> None:
    robot = seven()
    for q in spread(60, (2.5,) * 7):
        pose = robot.forward(q)
        for near in (tuple(v + 0.05 for v in q), (0.0,) * 7, (0.1, 0.5, 0.0, -1.0, 0.0, 0.5, 0.0)):
            found = robot.inverse(pose, near)
            assert apart(robot.forward(found), pose) < 1e-8
        assert max(abs(a - b) for a, b in zip(robot.follow(pose, tuple(v + 1e-3 for v in q)), q, strict=True)) < 1e-2, "it stays near"


def test_a_line_is_run_straight_within_the_limits_and_one_too_long_is_reported() -> None:
    robot = seven()
    machine = Machine(robot, robot.limits)
    here = robot.forward(START)
    x, y, z = here.position
    route = Route(machine, START)
    route.add(Block(Interpolation.LINEAR, PoseTarget(Pose((x, y + 0.2, z - 0.05), here.rotation)), pace=Pace(path_speed=0.2)))
    with pytest.raises(BlockError, match="along the path"):
        route.add(Block(Interpolation.LINEAR, PoseTarget(Pose((x, y + 3.0, z), here.rotation))))
    route.finish()
    made = trace(route.take(), machine)
    shares = worst_shares(made.q, robot.limits)
    assert max(shares) < 1.05
    way = np.array([0.0, 0.2, -0.05])
    for row in made.q[::20]:
        off = np.array(robot.forward(tuple(row)).position) - here.position
        assert np.linalg.norm(off - way * (off @ way) / (way @ way)) < 1e-6
    assert math.dist(robot.forward(tuple(made.q[-1])).position, (x, y + 0.2, z - 0.05)) < 1e-7


@pytest.mark.parametrize("wrapped", [False, True])
def test_where_a_line_cannot_go_on_it_is_searched_from_the_joints_before_alone(monkeypatch: pytest.MonkeyPatch, wrapped: bool) -> None:
    """From 60 other places, too, in each interval that was tried, a check of such a line took minutes."""
    robot, searches = seven(), 0
    search = Urdf._search

    def counted(self: Urdf, pose: Pose, start: np.ndarray) -> tuple[float, ...] | None:
        nonlocal searches
        searches += 1
        return search(self, pose, start)

    monkeypatch.setattr(Urdf, "_search", counted)
    machine = Machine(Group(robot, ()) if wrapped else robot, robot.limits)
    here = robot.forward(START)
    x, y, z = here.position
    with pytest.raises(BlockError, match="along the path"):
        Route(machine, START).add(Block(Interpolation.LINEAR, PoseTarget(Pose((x, y + 3.0, z), here.rotation))))
    assert searches < 1200
