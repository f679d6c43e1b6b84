"""What others made of the same arm: pinocchio for forward and Jacobian, EAIK and OPW for all branches; and any URDF."""

import math

import numpy as np
import pytest
from eaik.IK_DH import DhRobot
from py_opw_kinematics import _internal as internal

from hil_tests.unit.motion.kinematics.robots import GENERAL, TX60, apart, arm, scara, sliding, spread, turning, unlike, unlike_turned, urdf
from motion.errors import MotionError
from motion.geometry.frames import Pose, translation
from motion.kinematics.arm6 import ArmGeometry
from motion.kinematics.base import FREE, SAME, Unreachable, WrongConfiguration
from motion.kinematics.dh import default_dh
from motion.kinematics.portal import Portal
from motion.kinematics.urdf import Urdf

OFFSET = ArmGeometry(0.5, 0.6, 0.7, 0.1, delta=0.15, elbow=-0.1, side=0.02)
CONTINUOUS = """<robot name="r"><link name="l0"/><link name="l1"/><link name="l2"/>
<joint name="turn" type="continuous"><parent link="l0"/><child link="l1"/><axis xyz="0 0 1"/><limit velocity="2" effort="1"/></joint>
<joint name="slide" type="prismatic"><parent link="l1"/><child link="l2"/><axis xyz="1 0 0"/>
<limit lower="0.1" upper="0.9" velocity="0.5" effort="1"/></joint></robot>"""


def matrix(pose: Pose) -> np.ndarray:
    """4 x 4."""
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = np.array(pose.rotation).reshape(3, 3), pose.position
    return result


def same_sets(ours: list[tuple[float, ...]], theirs: list[tuple[float, ...]]) -> bool:
    """Each of ours has its like among theirs, and the other way round; whole turns not counted."""
    return all(min(unlike_turned(one, two) for two in b) < 1e-6 for a, b in ((ours, theirs), (theirs, ours)) for one in a)


@pytest.mark.parametrize("geometry", [TX60, OFFSET])
def test_forward_and_jacobian_are_those_of_pinocchio(geometry: ArmGeometry) -> None:
    ours, judge = arm(geometry), Urdf(urdf(geometry), "flange")
    for q in spread(100, (3.1,) * 6):
        assert apart(ours.forward(q), judge.forward(q)) < 1e-12
        assert np.abs(ours.jacobian(q) - judge.jacobian(q)).max() < 1e-12


@pytest.mark.parametrize("down", [True, False])
def test_a_scara_and_a_portal_are_those_of_pinocchio(down: bool) -> None:
    ours = scara(down=down)
    links = "".join(f'<link name="l{n}"/>' for n in range(6))
    rows = (
        ("revolute", "0 0 1", "0 0 0"),
        ("revolute", "0 0 1", "0.35 0 0"),
        ("prismatic", "0 0 1", "0.25 0 0.3"),
        ("revolute", "0 0 1", "0 0 0"),
    )
    text = f'<robot name="scara">{links}{_joints(rows)}<joint name="f" type="fixed"><parent link="l4"/><child link="l5"/>'
    judge = Urdf(f'{text}<origin rpy="{math.pi if down else 0} 0 0"/></joint></robot>', "l5")
    for q in spread(30, (3.0, 3.0, 1.0, 3.0)):
        assert apart(ours.forward(q), judge.forward(q)) < 1e-12
        assert np.abs(ours.jacobian(q) - judge.jacobian(q)).max() < 1e-12
    gantry = Portal("xyzcb", [sliding("x"), sliding("y"), sliding("z"), turning("c"), turning("b")], translation(0.0, 0.0, -0.2))
    slides = (("prismatic", "1 0 0", "0 0 0"), ("prismatic", "0 1 0", "0 0 0"), ("prismatic", "0 0 1", "0 0 0"))
    turns = (("revolute", "0 0 1", "0 0 0"), ("revolute", "0 1 0", "0 0 0"))
    links += '<link name="l6"/><joint name="f" type="fixed"><parent link="l5"/><child link="l6"/><origin xyz="0 0 -0.2"/></joint>'
    other = Urdf(f'<robot name="portal">{links}{_joints(slides + turns)}</robot>', "l6")
    for q in spread(30, (1.0, 1.0, 1.0, 3.0, 3.0)):
        assert apart(gantry.forward(q), other.forward(q)) < 1e-12
        assert np.abs(gantry.jacobian(q) - other.jacobian(q)).max() < 1e-12


def _joints(rows: tuple[tuple[str, str, str], ...]) -> str:
    """Joints of a URDF between links l0, l1 ..."""
    form = '<joint name="j{0}" type="{2}"><parent link="l{1}"/><child link="l{0}"/><origin xyz="{4}"/><axis xyz="{3}"/>'
    limit = '<limit lower="-4" upper="4" velocity="1" effort="1"/></joint>'
    return "".join(form.format(n, n - 1, *row) + limit for n, row in enumerate(rows, 1))


@pytest.mark.parametrize("geometry", [TX60, OFFSET])
def test_all_branches_are_those_of_eaik(geometry: ArmGeometry) -> None:
    dh = default_dh(geometry)
    alpha, a, d = (np.array(row) for row in (np.radians([*dh.alpha[:5], 0]), np.array(dh.a) / 1e3, np.array(dh.d) / 1e3))
    judge, ours = DhRobot(alpha, a, d), arm(geometry)
    theta = np.radians(dh.theta)
    for q in spread(100, (3.1,) * 6):
        pose = ours.forward(q)
        answer = judge.IK(matrix(pose))
        theirs = [
            tuple(float(value) for value in row - theta) for row, loose in zip(np.array(answer.Q), answer.is_LS, strict=True) if not loose
        ]
        assert same_sets([joints for joints, _ in ours.branches(pose)], theirs)


@pytest.mark.parametrize("geometry", [TX60, OFFSET, GENERAL])
def test_all_branches_are_those_of_opw(geometry: ArmGeometry) -> None:
    g = geometry
    o1, o2, o3, o4, o5, o6 = (-value for value in g.offsets)  # theirs are taken away
    f1, f2, f3, f4, f5, f6 = (sign < 0 for sign in g.signs)
    lengths = (g.delta, g.elbow, g.side, g.height, g.arm, g.forearm, g.flange)
    model = internal.KinematicModel(*lengths, offsets=(o1, o2, o3, o4, o5, o6), flip_axes=(f1, f2, f3, f4, f5, f6))
    judge = internal.Robot(model, degrees=False)
    ours = arm(geometry)
    for q in spread(100, (3.1,) * 6):
        pose = ours.forward(q)
        theirs = [tuple(float(value) for value in row) for row in judge.inverse(matrix(pose))]
        assert same_sets([joints for joints, _ in ours.branches(pose)], theirs)


def test_the_numeric_inverse_finds_what_the_closed_form_finds() -> None:
    closed = arm()
    numeric = Urdf(urdf(TX60), "flange", closed.limits)
    assert numeric.names == ("j1", "j2", "j3", "j4", "j5", "j6")
    for q in spread(15, (2.8,) * 6):
        pose = closed.forward(q)
        assert unlike(numeric.inverse(pose, [value + 0.02 for value in q]), q) < 1e-7
        far = numeric.inverse(pose, (0.1,) * 6)
        assert apart(numeric.forward(far), pose) < 1e-9
        assert all(axis.lower <= value <= axis.upper for axis, value in zip(numeric.limits, far, strict=True))
    found = [joints for joints, _ in numeric.branches(pose)]
    assert 3 <= len(found) <= 8
    assert all(min(unlike(joints, one) for one, _ in closed.branches(pose)) < 1e-6 for joints in found)


def test_the_numeric_inverse_says_when_there_is_no_way() -> None:
    numeric = Urdf(urdf(TX60, travel=0.5), "flange")
    with pytest.raises(Unreachable, match="did not converge"):
        numeric.inverse(translation(0.0, 0.0, -1.0), (0.0,) * 6)
    with pytest.raises(Unreachable):
        numeric.follow(translation(0.0, 0.0, -1.0), (0.0,) * 6)
    with pytest.raises(Unreachable, match="finite"):
        numeric.inverse(translation(math.nan, 0.0, 0.0), (0.0,) * 6)
    with pytest.raises(WrongConfiguration):
        numeric.inverse(numeric.forward((0.1,) * 6), (0.0,) * 6, SAME)
    assert numeric.configuration((0.0,) * 6) == FREE


def test_joints_that_turn_without_end_and_slides() -> None:
    robot = Urdf(CONTINUOUS, "l2")
    assert [axis.unit for axis in robot.limits] == ["rad", "m"]
    assert (robot.limits[1].lower, robot.limits[1].upper, robot.limits[1].speed) == (0.1, 0.9, 0.5)
    assert robot.forward((math.pi / 2, 0.4)).position == pytest.approx((0.0, 0.4, 0.0))
    assert robot.inverse(robot.forward((1.0, 0.4)), (0.8, 0.3)) == pytest.approx((1.0, 0.4))


def test_texts_that_are_no_robot() -> None:
    with pytest.raises(MotionError, match="URDF"):
        Urdf("<robot", "flange")
    with pytest.raises(MotionError, match="no link"):
        Urdf(urdf(TX60), "hand")
    with pytest.raises(MotionError, match="1 axes for 6 joints"):
        Urdf(urdf(TX60), "flange", [turning("a")])
    with pytest.raises(MotionError, match="this has 0"):
        Urdf('<robot name="r"><link name="l0"/></robot>', "l0")
