"""The six-axis arm: every branch leads back, poles, turns, limits, and what cannot be reached is told with its number."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from hil_tests.unit.motion.kinematics.robots import GENERAL, TX60, apart, arm, scara, sliding, spread, turning, unlike
from motion.errors import MotionError
from motion.geometry.frames import Pose, product, transposed
from motion.geometry.orientation import rotation_vector
from motion.geometry.workspace import Workspace
from motion.kinematics.arm6 import Arm6, ArmGeometry
from motion.kinematics.base import (
    SAME,
    Configuration,
    Elbow,
    Kinematics,
    KinematicsError,
    OutOfLimits,
    Shoulder,
    Unreachable,
    Wrist,
    WrongConfiguration,
)
from motion.kinematics.choice import Chooser
from motion.kinematics.identity import Identity

DOWNWARDS = (1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)
HALF = math.pi / 2


def by_differences(robot: Kinematics, q: tuple[float, ...], step: float = 1e-6) -> np.ndarray:
    """(6, axes): the Jacobian by moving each joint a little."""
    columns = []
    for n in range(robot.axes):
        up, down = ([*q[:n], q[n] + sign * step, *q[n + 1 :]] for sign in (1, -1))
        high, low = robot.forward(up), robot.forward(down)
        turn = rotation_vector(product(high.rotation, transposed(low.rotation)))
        columns.append([(a - b) / (2 * step) for a, b in zip((*high.position, *turn), (*low.position, 0, 0, 0), strict=True)])
    return np.array(columns).T


@pytest.mark.parametrize("geometry", [TX60, GENERAL])
def test_all_branches_lead_back_and_the_joints_are_among_them(geometry: ArmGeometry) -> None:
    robot = arm(geometry)
    for q in spread(300, (3.1,) * 6):
        pose = robot.forward(q)
        found = robot.branches(pose)
        assert max(apart(robot.forward(joints), pose) for joints, _ in found) < 1e-12
        assert min(unlike(joints, q) for joints, _ in found) < 1e-7
        assert all(-math.pi <= value <= math.pi for joints, _ in found for value in joints)
        assert unlike(robot.inverse(pose, q), q) < 1e-7
        assert unlike(robot.follow(pose, q), q) < 1e-7


@pytest.mark.parametrize("geometry", [TX60, GENERAL])
def test_the_jacobian_is_the_change_of_the_pose(geometry: ArmGeometry) -> None:
    robot = arm(geometry)
    for q in spread(10, (3.0,) * 6):
        assert np.abs(robot.jacobian(q) - by_differences(robot, q)).max() < 1e-8


def test_straight_up_at_zero() -> None:
    pose = arm().forward((0.0,) * 6)
    assert pose.position == pytest.approx((0, 0.02, 0.375 + 0.29 + 0.31 + 0.07))
    assert pose.rotation == pytest.approx((1, 0, 0, 0, 1, 0, 0, 0, 1))


def test_at_the_wrist_pole_axes_4_and_6_stay() -> None:
    robot = arm()
    q = (0.3, 0.5, 1.0, 0.7, 0.0, -0.4)
    pose = robot.forward(q)
    assert unlike(robot.inverse(pose, q), q) < 1e-9
    assert unlike(robot.follow(pose, q), q) < 1e-9
    turned = robot.forward((*q[:5], -0.2))
    shared = robot.follow(turned, q)
    assert apart(robot.forward(shared), turned) < 1e-9
    assert unlike(shared, (*q[:3], 0.8, 0.0, -0.3)) < 1e-9, "each takes half of the turn"
    now = robot.configuration(q)
    alike = [flags.wrist for _, flags in robot.branches(pose) if (flags.shoulder, flags.elbow) == (now.shoulder, now.elbow)]
    assert alike == [Wrist.POSITIVE]


@pytest.mark.parametrize("sine", [1e-3, 1e-6, 1e-9, 1e-10, 1e-12, 0.0])
def test_near_the_wrist_pole_every_branch_leads_back(sine: float) -> None:
    robot = arm()
    for q in spread(20, (3.0, 1.5, 2.0, 3.0, 0.0, 3.0)):
        pose = robot.forward((*q[:4], sine, q[5]))
        found = robot.branches(pose)
        assert len(found) >= 4
        assert max(apart(robot.forward(joints), pose) for joints, _ in found) < 1e-9
        assert apart(robot.forward(robot.inverse(pose, q)), pose) < 1e-9


def test_a_line_through_the_wrist_pole_changes_the_sign_of_axis_5_and_keeps_4_and_6() -> None:
    robot = arm()
    q: tuple[float, ...] = (0.3, 0.5, 1.0, 0.7, 0.2, -0.4)
    for step in range(401):
        target = (0.3, 0.5, 1.0, 0.7, 0.2 - 0.001 * step, -0.4)
        q = robot.follow(robot.forward(target), q)
        assert unlike(q, target) < 1e-6


@pytest.mark.parametrize("geometry", [TX60, GENERAL])
@pytest.mark.parametrize("width", [0.01, 0.3, 1.2, 2.9])
def test_a_path_takes_the_nearer_of_the_two_wrists_however_far_a_step_is(geometry: ArmGeometry, width: float) -> None:
    speeds = (1.0, 2.0, 1.5, 4.0, 3.0, 6.0)
    robot = Arm6(geometry, [turning(f"j{n}", -4.0, 3.5, speed) for n, speed in enumerate(speeds, 1)])
    chooser, turned_over = Chooser(robot.limits), 0
    for near, step in zip(spread(300, (2.5,) * 6), spread(300, (0.01, 0.01, 0.01, width, width, width)), strict=True):
        pose, now = robot.forward([a + b for a, b in zip(near, step, strict=True)]), robot.configuration(near)
        pair = [branch for branch in robot.branches(pose) if (branch[1].shoulder, branch[1].elbow) == (now.shoulder, now.elbow)]
        wanted = chooser.choose(pair, near, None, now)
        assert robot.follow(pose, near) == wanted
        turned_over += not isinstance(wanted, str) and robot.configuration(wanted).wrist is not now.wrist
    assert turned_over or width < 2.0, "wrists that turn over are among the wide ones"


def test_of_branches_equally_near_the_first_is_taken_whichever_is_like_the_joints() -> None:
    robot = arm()
    over, under, other = (flags for _, flags in robot.branches(robot.forward((0.3, 0.5, 1.0, 0.7, 0.9, -0.4)))[:3])
    rows = [((0.1, 0.0, 0.0, 0.0, 0.0, 0.0), over), ((-0.1, 0.0, 0.0, 0.0, 0.0, 0.0), under)]
    for now in (over, under, other):
        assert Chooser(robot.limits).choose(rows, (0.0,) * 6, None, now)[0] == 0.1
        assert Chooser(robot.limits).choose(rows[::-1], (0.0,) * 6, None, now)[0] == -0.1


def test_with_the_wrist_centre_on_axis_1_axis_1_stays() -> None:
    robot = arm(ArmGeometry(0.4, 0.3, 0.3, 0.1))
    bent = math.radians(50)
    for first in (0.0, 0.8, -2.0):
        q = (first, -bent, 2 * bent, 0.3, 0.6, 0.1)
        pose = robot.forward(q)
        assert unlike(robot.inverse(pose, q), q) < 1e-9
        assert all(apart(robot.forward(joints), pose) < 1e-9 for joints, _ in robot.branches(pose))


def test_stretched_and_folded_arms_are_reached() -> None:
    robot = arm(ArmGeometry(0.4, 0.3, 0.3, 0.1, delta=0.1))
    for third in (0.0, 1e-9, -1e-9, 1e-5):
        q = (0.2, 1.0, third, 0.3, 0.6, 0.1)
        pose = robot.forward(q)
        assert apart(robot.forward(robot.inverse(pose, q)), pose) < 1e-9
    folded = robot.forward((0.2, 0.4, math.pi, 0.3, 0.6, 0.1))
    assert all(apart(robot.forward(joints), folded) < 1e-9 for joints, _ in robot.branches(folded))
    assert robot.branches(folded)


def test_what_cannot_be_reached_says_why_and_has_its_number() -> None:
    robot = arm()
    cases = (
        (Pose((0.9, 0.0, 0.4), DOWNWARDS), Unreachable, 530, "from axis 2"),
        (Pose((0.001, 0.0, 0.3), DOWNWARDS), Unreachable, 530, "from axis 1"),
        (Pose((math.nan, 0.0, 0.4), DOWNWARDS), Unreachable, 530, "not a finite number"),
    )
    for pose, kind, number, words in cases:
        for ask in (robot.inverse, robot.follow):
            with pytest.raises(kind, match=words) as fault:
                ask(pose, (0.0,) * 6)
            assert fault.value.number == number
            assert "point not reachable" in str(fault.value)
        assert robot.branches(pose) == []


def test_beyond_the_travel_is_531_with_the_axis_and_a_wrong_configuration_533() -> None:
    q = (0.3, 0.5, 1.0, 0.7, 0.9, -0.4)
    pose = arm().forward(q)
    with pytest.raises(OutOfLimits) as fault:
        arm(j1=(1.0, 2.0)).inverse(pose, (1.5, 0, 0, 0, 0, 0))
    assert (fault.value.number, fault.value.axis) == (531, "j1")
    bent = arm(j3=(0.0, 2.5))
    with pytest.raises(WrongConfiguration) as wrong:
        bent.inverse(pose, q, Configuration(elbow=Elbow.NEGATIVE))
    assert wrong.value.number == 533
    assert unlike(bent.inverse(pose, q, SAME), q) < 1e-9
    other = bent.inverse(pose, q, Configuration(wrist=Wrist.NEGATIVE))
    assert bent.configuration(other) == Configuration(Shoulder.LEFTY, Elbow.POSITIVE, Wrist.NEGATIVE)


def joints_or_refusal(
    ask: Callable[[Pose, Sequence[float]], tuple[float, ...]], pose: Pose, near: Sequence[float]
) -> tuple[float, ...] | str:
    try:
        return ask(pose, near)
    except MotionError as refusal:
        return str(refusal)


@pytest.mark.parametrize("wrong", [math.nan, math.inf])
def test_joints_to_start_from_that_are_no_numbers_are_refused(wrong: float) -> None:
    q = (0.3, 0.5, 1.0, 0.7, 0.9, -0.4)
    for robot in (arm(), scara(), Identity([turning("a"), sliding("b")])):
        pose = robot.forward(q[: robot.axes])
        for number in range(robot.axes):
            near = [*q[: robot.axes]]
            near[number] = wrong
            for ask in (robot.inverse, robot.follow):
                answer = joints_or_refusal(ask, pose, near)
                assert "finite" in answer if isinstance(answer, str) else all(map(math.isfinite, answer))


def test_the_nearest_turn_inside_the_travel_is_taken() -> None:
    robot = arm(j6=(-4.7, 4.7), j4=(-4.7, 4.7))
    q = (0.3, 0.5, 1.0, 0.7, 0.9, 3.5)
    pose = robot.forward(q)
    assert unlike(robot.inverse(pose, q), q) < 1e-9
    assert unlike(robot.follow(pose, (*q[:5], 3.4)), q) < 1e-9
    near_zero = robot.inverse(pose, (*q[:5], 0.0), SAME)
    assert math.isclose(near_zero[5], 3.5 - 2 * math.pi)


def test_of_all_branches_and_turns_the_nearest_is_taken() -> None:
    travel, speeds = 5.0, (1.0, 2.0, 1.5, 4.0, 3.0, 6.0)
    robot = Arm6(TX60, [turning(f"j{n}", -travel, travel, speed) for n, speed in enumerate(speeds, 1)])
    for q, near in zip(spread(100, (3.0,) * 6), spread(100, (4.9, 2.0, 4.5, 4.8, 2.5, 4.7)), strict=True):
        pose, ways = robot.forward(q), []
        for joints, _ in robot.branches(pose):
            turns = [[way for way in (j - 2 * math.pi, j, j + 2 * math.pi) if -travel <= way <= travel] for j in joints]
            best = [here + min((way - here for way in row), key=abs) for row, here in zip(turns, near, strict=True)]
            ways.append((sum(((a - b) / v) ** 2 for a, b, v in zip(best, near, speeds, strict=True)), best))
        assert unlike(robot.inverse(pose, near), min(ways)[1]) < 1e-9


def test_faster_axes_make_the_longer_way() -> None:
    slow = [turning(f"j{n}", speed=0.1 if n == 4 else 10.0) for n in range(1, 7)]
    robot = Arm6(TX60, slow)
    q = (0.3, 0.5, 1.0, 0.1, 0.05, -0.4)
    pose = robot.forward(q)
    there = robot.inverse(pose, (*q[:3], 0.1 - math.pi + 0.4, 0.05, -0.4))
    assert there[4] < 0, "the wrist turns over, because axis 4 is slow"


def test_geometry_and_limits_that_cannot_be() -> None:
    for arm_m, forearm, elbow in ((0.0, 0.3, 0.0), (0.3, math.nan, 0.0), (0.3, 0.0, 0.0)):
        with pytest.raises(MotionError, match="finite lengths"):
            ArmGeometry(0.3, arm_m, forearm, 0.1, elbow=elbow)
    with pytest.raises(MotionError, match="signs"):
        ArmGeometry(0.3, 0.3, 0.3, 0.1, signs=(1, 1, 1, 1, 1, 2))
    with pytest.raises(MotionError, match="6 axes"):
        Arm6(TX60, [turning("j1")])
    with pytest.raises(MotionError, match="7 joints"):
        Chooser(arm().limits).choose(arm().branches(arm().forward((0.1,) * 6)), (0.0,) * 7, None, SAME)


def test_a_workspace_puts_tool_frame_and_base_around_the_arm() -> None:
    robot = arm()
    q = (0.3, 0.5, 1.0, 0.7, 0.9, -0.4)
    place = robot.forward((1.0, 0.2, 0.5, 0.1, 0.4, 0.3))
    space = Workspace(robot, base=place, frame=place.inverse(), tool=robot.forward((0.1,) * 6))
    tcp = space.tcp(q)
    assert apart(tcp, (place.inverse() @ space.frame).inverse() @ robot.forward(q) @ space.tool) < 1e-12
    assert unlike(space.joints(tcp, q), q) < 1e-9
    assert apart(space.with_tool(place).tcp(q), tcp @ space.tool.inverse() @ place) < 1e-12
    assert apart(space.with_frame(space.base).tcp(q), robot.forward(q) @ space.tool) < 1e-12


def test_every_error_of_the_inverse_is_one_of_the_motion_core() -> None:
    assert issubclass(KinematicsError, MotionError)
    assert KinematicsError("x", number=534).number == 534
