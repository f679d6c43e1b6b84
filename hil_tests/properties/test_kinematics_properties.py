"""Round trips of poses, angles, kinematics and frames, whatever the numbers are."""

import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from hil_tests.unit.motion.kinematics.robots import TX60, apart, arm, scara, sliding, turning, unlike
from motion.errors import MotionError
from motion.geometry.conventions import CONVENTIONS
from motion.geometry.frames import IDENTITY, Pose, check_pose, from_quaternion, quaternion_of, rotation_of
from motion.geometry.orientation import angle_between, between, rotation_by, rotation_vector, slerp
from motion.kinematics.arm6 import Arm6, ArmGeometry
from motion.kinematics.base import SAME
from motion.kinematics.choice import nearest_turn
from motion.kinematics.endless import within
from motion.kinematics.portal import Portal
from motion.rho3.kinematic import mirrored
from motion.rho3.wc import Assignment, WcFrame

SOME = settings(max_examples=150, deadline=None)
ANGLE = st.floats(-math.pi, math.pi)
LENGTH = st.floats(-3.0, 3.0)
PART = st.floats(0.05, 1.0)
SHIFT = st.floats(-900, 900)  # mm
TURN = st.floats(-179, 179)  # deg
QUATERNION = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: math.hypot(*q) > 1e-3)
POSE = st.builds(from_quaternion, st.tuples(LENGTH, LENGTH, LENGTH), QUATERNION)
JOINTS = st.tuples(*[ANGLE] * 6)
GEOMETRY = st.builds(
    ArmGeometry,
    height=LENGTH,
    arm=PART,
    forearm=PART,
    flange=st.floats(0.0, 0.3),
    delta=st.floats(-0.3, 0.3),
    elbow=st.floats(-0.2, 0.2),
    side=st.floats(-0.2, 0.2),
    signs=st.tuples(*[st.sampled_from((1, -1))] * 6),
    offsets=st.tuples(*[ANGLE] * 6),
)
BORDERLINE = (
    TX60,
    ArmGeometry(0.4, 0.3, 0.35, 0.1),
    ArmGeometry(0.4, 0.3, 0.35, 0.1, delta=0.1, elbow=0.07),
    ArmGeometry(0.4, 0.3, 0.35, 0.1, delta=0.1, elbow=-0.07, side=-0.03),
)
OFF = st.builds(lambda sign, power: sign * 10.0**-power, st.sampled_from((1.0, -1.0, 0.0)), st.floats(1.0, 17.0))


@SOME
@given(POSE, POSE, POSE)
def test_poses_compose_and_turn_back(a: Pose, b: Pose, c: Pose) -> None:
    assert apart(a @ a.inverse(), IDENTITY) < 1e-12
    assert apart((a @ b) @ c, a @ (b @ c)) < 1e-12
    assert apart((a @ b).inverse(), b.inverse() @ a.inverse()) < 1e-12
    assert math.dist((a @ b).position, a.apply(b.position)) < 1e-12
    assert check_pose(a @ b) == a @ b


@SOME
@given(QUATERNION)
def test_quaternions_and_rotation_vectors_come_back(q: tuple[float, float, float, float]) -> None:
    rotation = rotation_of(q)
    again = quaternion_of(rotation)
    scale = math.hypot(*q)
    assert min(math.dist(again, [sign * value / scale for value in q]) for sign in (1, -1)) < 1e-12
    assert again[0] >= 0
    assert apart(Pose((0, 0, 0), rotation_by(rotation_vector(rotation))), Pose((0, 0, 0), rotation)) < 1e-12


@SOME
@given(QUATERNION, QUATERNION, st.floats(0, 1))
def test_the_least_rotation_is_divided_evenly(one: tuple[float, ...], two: tuple[float, ...], part: float) -> None:
    start, end = rotation_of((one[0], one[1], one[2], one[3])), rotation_of((two[0], two[1], two[2], two[3]))
    there = slerp(start, end, part)
    whole = angle_between(start, end)
    assert whole <= math.pi + 1e-12
    assert abs(angle_between(start, there) - part * whole) < 1e-7
    assert apart(Pose((0, 0, 0), slerp(start, end, 1.0)), Pose((0, 0, 0), end)) < 1e-12
    assert math.hypot(*between(start, end)) == pytest.approx(whole)


@pytest.mark.parametrize("name", CONVENTIONS)
@given(POSE)
@SOME
def test_angles_of_every_control_come_back(name: str, pose: Pose) -> None:
    convention = CONVENTIONS[name]
    values = convention.values(pose)
    assert apart(convention.pose(values), pose) < 1e-12
    assert -90 - 1e-9 <= values[4] <= 90 + 1e-9
    assert all(-180 < value <= 180 for value in values[3:])


@pytest.mark.parametrize("name", CONVENTIONS)
@given(ANGLE, ANGLE, st.sampled_from((math.pi / 2, -math.pi / 2)), st.sampled_from((0.0, 1e-6, 1e-9, 1e-11, 1e-13)))
@SOME
def test_angles_at_and_near_the_pole_come_back(name: str, first: float, last: float, middle: float, off: float) -> None:
    convention = CONVENTIONS[name]
    rotation = convention.to_rotation(first, middle + off, last)
    again = convention.to_rotation(*convention.to_angles(rotation))
    assert max(abs(a - b) for a, b in zip(rotation, again, strict=True)) < 1e-11


@SOME
@given(GEOMETRY, JOINTS)
def test_every_arm_finds_its_joints_and_flags_again(geometry: ArmGeometry, q: tuple[float, ...]) -> None:
    robot = arm(geometry)
    pose = robot.forward(q)
    found = robot.branches(pose)
    _, t2, t3, _, t5, _ = (s * j + o for s, j, o in zip(geometry.signs, q, geometry.offsets, strict=True))
    stretched = math.sin(t3 + math.atan2(geometry.elbow, geometry.forearm))
    out = geometry.delta + geometry.arm * math.sin(t2) + geometry.forearm * math.sin(t2 + t3) + geometry.elbow * math.cos(t2 + t3)
    assume(abs(stretched) > 1e-4 and abs(math.sin(t5)) > 1e-6 and abs(out) > 1e-4)  # poles have tests of their own
    assert max(apart(robot.forward(joints), pose) for joints, _ in found) < 1e-9
    assert all(robot.configuration(joints) == flags for joints, flags in found)
    assert unlike(robot.inverse(pose, q, SAME), q) < 1e-6
    assert unlike(robot.follow(pose, q), q) < 1e-6


def on_axis_1(geometry: ArmGeometry, third: float, off: float) -> float | None:
    """The angle of axis 2 that brings the wrist centre to `off` m before axis 1's plane; None where none does."""
    along = geometry.arm + geometry.forearm * math.cos(third) - geometry.elbow * math.sin(third)
    across = geometry.forearm * math.sin(third) + geometry.elbow * math.cos(third)
    sine = (off - geometry.delta) / math.hypot(along, across)
    return math.asin(sine) - math.atan2(across, along) if abs(sine) < 1 else None


@SOME
@given(st.sampled_from(BORDERLINE), JOINTS, st.sampled_from(("wrist", "elbow", "shoulder", "wrist and elbow", "all")), OFF, OFF, OFF)
def test_at_the_borders_of_configurations_all_branches_lead_back_with_their_flags(
    geometry: ArmGeometry, q: tuple[float, ...], border: str, one: float, two: float, three: float
) -> None:
    robot = arm(geometry)
    t = list(q)
    if border in ("wrist", "wrist and elbow", "all"):
        t[4] = one
    if border in ("elbow", "wrist and elbow", "all"):
        t[2] = two - math.atan2(geometry.elbow, geometry.forearm)
    if border in ("shoulder", "all"):
        second = on_axis_1(geometry, t[2], three)
        assume(second is not None)
        t[1] = second or 0.0
    pose = robot.forward(t)
    found = robot.branches(pose)
    assert found
    assert max(apart(robot.forward(joints), pose) for joints, _ in found) < 1e-9
    assert all(robot.configuration(joints) == flags for joints, flags in found)
    assert apart(robot.forward(robot.inverse(pose, q)), pose) < 1e-9


@SOME
@given(JOINTS, OFF, st.sampled_from((0.0, math.pi)), st.booleans())
def test_a_scara_at_its_stretched_and_folded_arm_comes_back(q: tuple[float, ...], off: float, border: float, down: bool) -> None:
    robot = scara(down=down)
    pose = robot.forward((q[0], border - abs(off) if border else off, 0.1 * q[2], q[3]))
    found = robot.branches(pose)
    assert found
    assert max(apart(robot.forward(joints), pose) for joints, _ in found) < 1e-9
    assert all(robot.configuration(joints) == flags for joints, flags in found)


@SOME
@given(POSE)
def test_any_pose_is_answered_or_refused_by_an_error_of_ours(pose: Pose) -> None:
    for robot in (arm(), scara(), Portal("xyzcba", [sliding("x"), sliding("y"), sliding("z"), turning("c"), turning("b"), turning("a")])):
        near = (0.0,) * robot.axes
        try:
            joints = robot.inverse(pose, near)
        except MotionError:
            continue
        assert apart(robot.forward(joints), pose) < 1e-9


@SOME
@given(st.floats(-50, 50), st.floats(-30, 30), st.floats(-20, 20), st.floats(0, 30))
def test_the_nearest_turn_is_the_nearest_of_all(angle: float, near: float, lower: float, width: float) -> None:
    upper = lower + width
    turned = nearest_turn(angle, near, lower, upper)
    all_turns = [angle + 2 * math.pi * k for k in range(-20, 21)]
    possible = [value for value in all_turns if lower + 1e-8 <= value <= upper - 1e-8]
    if possible:
        assert turned is not None
        assert abs(turned - near) <= min(abs(value - near) for value in possible) + 1e-9
    if turned is not None:
        assert lower - 2e-9 <= turned <= upper + 2e-9
        assert abs(math.remainder(turned - angle, 2 * math.pi)) < 1e-9


@SOME
@given(st.builds(WcFrame, SHIFT, SHIFT, SHIFT, TURN, TURN, TURN), st.tuples(SHIFT, SHIFT, SHIFT, TURN, st.floats(-89, 89), TURN))
def test_workpiece_points_go_there_and_back(frame: WcFrame, point: tuple[float, ...]) -> None:
    by = frame.pose
    all_six = Assignment()
    there = all_six.moved(point, by)
    assert apart(all_six.pose(all_six.moved(there, by.inverse())), all_six.pose(point)) < 1e-9
    flipped = mirrored(mirrored(by, 1), 1)
    assert apart(flipped, by) < 1e-15
    assert check_pose(mirrored(by, 0))


@SOME
@given(st.floats(-1e4, 1e4), st.floats(0.5, 720))
def test_an_endless_axis_stays_within_its_modulo(position: float, modulo: float) -> None:
    inside = within(position, modulo)
    assert 0 <= inside < modulo
    assert abs(math.remainder(inside - position, modulo)) < 1e-8


def test_what_is_no_pose_or_no_orientation_is_refused() -> None:
    with pytest.raises(MotionError, match="finite"):
        check_pose(Pose((math.nan, 0, 0), IDENTITY.rotation))
    for last in (2, -1):
        with pytest.raises(MotionError, match="do not form a rotation"):
            check_pose(Pose((0, 0, 0), (1, 0, 0, 0, 1, 0, 0, 0, last)))
    for none in ((0.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0)):
        with pytest.raises(MotionError):
            rotation_of(none)
    assert isinstance(arm(), Arm6)
