"""The robot on the page: every shipped one is drawn with the lengths of its file, up to the flange its kinematics finds."""

import itertools
import math

import pytest

from gateway.cell_file.load import load_cell
from gateway.files.robots import load_robot
from gateway.web.robot_lines import Arm
from gateway.web.skeleton import Skeleton
from motion.geometry.frames import NO_ROTATION, Pose
from motion.robot import kinematics_of

DRAWN = 2e-4  # m: points are rounded to a tenth of a millimetre
LENGTHS = {  # of the robot files, m; None: a length that changes with the joints
    "tx60-like": (0.375, 0.02, 0.29, 0.31, 0.07, 0.06),
    "reis-like": (0.7, 0.2, 0.65, 0.7566, 0.12, 0.06),
    "sr60-like": (0.45, 0.35, 0.25, None, 0.06),
    "portal": (None, 0.06),
}


@pytest.mark.parametrize("name", LENGTHS)
def test_a_robot_is_drawn_by_its_file(name: str) -> None:
    arm, kinematics = Arm(name), kinematics_of(load_robot(name))
    for joints in itertools.product((-0.3, 0.2), (0.1, 0.4), (-0.2, 0.3), (-0.5,), (0.4,), (0.3,)):
        line, *beside = arm.lines(joints)
        found = [math.dist(a, b) for a, b in itertools.pairwise(line)]
        assert len(found) == len(LENGTHS[name])
        for length, wanted in zip(found, LENGTHS[name], strict=True):
            assert wanted is None or length == pytest.approx(wanted, abs=DRAWN)
        assert line[-2] == pytest.approx(kinematics.forward(joints[: kinematics.axes]).position, abs=DRAWN)
        if name == "portal":
            (posts,) = beside
            assert all(point[0] == pytest.approx(line[-2][0], abs=DRAWN) for point in posts), "the bridge goes with x"
            assert line[0][1] == pytest.approx(line[-2][1], abs=DRAWN) and line[0][2] == posts[1][2], "the ram hangs on it"


@pytest.mark.parametrize("name", LENGTHS)
def test_base_flange_and_tool_have_their_frames_and_each_axis_its_name(name: str) -> None:
    arm, kinematics, joints = Arm(name), kinematics_of(load_robot(name)), (0.2, 0.3, 0.2, -0.5, 0.4, 0.3)
    frames = {frame: (at, rotation) for frame, at, rotation in arm.frames(joints)}
    flange = kinematics.forward(joints[: kinematics.axes])
    assert list(frames) == ["base", "flange", "tool"]
    assert frames["flange"][0] == pytest.approx(flange.position, abs=DRAWN) and frames["flange"][1] == pytest.approx(flange.rotation)
    assert frames["tool"][0] == arm.lines(joints)[0][-1] and frames["flange"][0] == arm.lines(joints)[0][-2]
    places = arm.places(joints)
    assert [number for number, _ in places] == list(range(kinematics.axes))
    assert {place for _, place in places} <= {point for line in arm.lines(joints) for point in line}, "on what is drawn"


@pytest.mark.parametrize("name", LENGTHS)
def test_the_tool_in_use_is_drawn_with_its_own_length_and_direction(name: str) -> None:
    arm, joints = Arm(name), (0.2, 0.3, 0.2, -0.5, 0.4, 0.3)
    c, s = math.cos(0.7), math.sin(0.7)
    tool = Pose((0.03, 0.0, 0.145), (c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c))
    line, frames = arm.lines(joints, tool)[0], {frame: (at, rotation) for frame, at, rotation in arm.frames(joints, tool)}
    flange = kinematics_of(load_robot(name)).forward(joints[: kinematics_of(load_robot(name)).axes])
    assert math.dist(line[-2], line[-1]) == pytest.approx(math.hypot(0.03, 0.145), abs=DRAWN)
    assert frames["tool"][0] == line[-1] == pytest.approx((flange @ tool).position, abs=DRAWN)
    assert frames["tool"][1] == pytest.approx((flange @ tool).rotation) and frames["flange"][0] == line[-2]


def test_a_portal_of_axes_alone_draws_the_tool_as_well() -> None:
    drawn, joints = Skeleton(load_cell("demo")), (0.5, 0.4, 0.1, 0.0, 0.0, 0.0)
    flange, tip = drawn.lines(joints, (0.0, 0.0, 0.2, *NO_ROTATION))[0][-2:]
    assert (flange[0] - tip[0], flange[1] - tip[1], flange[2] - tip[2]) == pytest.approx((0.0, 0.0, 0.2), abs=DRAWN)
    assert drawn.lines(joints)[0][-2] == flange, "the flange stays where it is"


def test_a_cell_without_a_robot_is_a_portal_with_frames_and_names() -> None:
    drawn = Skeleton(load_cell("demo"))
    joints = (0.5, 0.4, 0.1, 0.0, 0.0, 0.0)
    assert [name for name, _, _ in drawn.frames(joints)] == ["base", "flange", "tool"]
    marks = dict(drawn.marks(joints))
    assert list(marks) == ["A1", "A2", "A3", "A4, A5, A6"] and marks["A4, A5, A6"] == drawn.frames(joints)[1][1]


def test_an_arm_on_a_track_is_drawn_where_the_track_has_taken_it() -> None:
    joints = (0.2, 0.4, 0.9, -0.5, 0.4, 0.3)
    (alone,), (carried,) = Arm("tx60-like").lines(joints), Arm("tx60-on-track").lines((*joints, 0.7, 1.0))
    assert [tuple(b - a for a, b in zip(*pair, strict=True)) for pair in zip(alone, carried, strict=True)] == [
        pytest.approx((0.0, 0.7, 0.0), abs=DRAWN)
    ] * len(alone)
    assert Arm("tx60-on-track").reach == pytest.approx(Arm("tx60-like").reach + 1.5)
