"""VAL 3, section 13.3: the chain of geometric parameters, getDH, setDH."""

from dataclasses import replace

import pytest

from hil_tests.unit.motion.kinematics.robots import apart, arm, spread, unlike
from motion.errors import MotionError
from motion.kinematics.arm6 import ArmGeometry
from motion.kinematics.dh import DhParameters, MeasuredArm
from motion.val3.absolute import AbsoluteRobot
from motion.val3.cartesian import Arm, new_flange, new_world
from motion.val3.errors import RuntimeFault
from motion.val3.trsf import Trsf, times

GEOMETRY = ArmGeometry(height=0.375, arm=0.29, forearm=0.31, flange=0.07, side=0.02, delta=0.05)


def by_hand(dh: DhParameters, joints: tuple[float, ...]) -> Trsf:
    """The product of the manual, in its own type, mm and degrees (L6527-6540)."""
    result = Trsf(0, 0, 0, 0, 0, joints[0] + dh.theta[0])
    for k in range(5):
        result = times(result, Trsf(dh.a[k], dh.b[k], dh.d[k], dh.alpha[k], dh.beta[k], joints[k + 1] + dh.theta[k + 1]))
    return times(result, Trsf(dh.a[5], dh.b[5], dh.d[5], dh.alpha[5], dh.beta[5], 0))


@pytest.mark.requirement("VAL-DH-01", by="motion.kinematics.dh:default_dh")
def test_the_default_parameters_lead_where_joint_to_point_leads() -> None:
    robot = AbsoluteRobot(arm(GEOMETRY), licensed=False)
    ideal = Arm(robot.kinematics, ("deg",) * 6)
    for joints in ((0.0,) * 6, *spread(20, (170, 120, 140, 170, 110, 170))):
        chain = by_hand(robot.get_default_dh(), joints).pose
        assert apart(chain, ideal.joint_to_point(new_flange(), new_world(), joints).trsf.pose) < 1e-9


@pytest.mark.requirement("VAL-DH-01", by=("motion.val3.absolute:AbsoluteRobot.set_dh", "motion.kinematics.dh:too_far"))
def test_a_change_that_is_too_large_or_misfits_is_false_and_changes_nothing() -> None:
    robot = AbsoluteRobot(arm(GEOMETRY), licensed=True)
    default = robot.get_default_dh()
    for wrong in (replace(default, a=(60.0, 301.0, 0, 0, 0, 0)), replace(default, alpha=(-93.0, 0, 90, -90, 90, 0))):
        assert robot.set_dh(wrong) is False
        assert robot.get_dh() == default
    small = replace(default, a=(50.4, 289.7, 0.1, 0, 0, 0), alpha=(-90.1, 0, 90, -90, 90.05, 0), b=(0.2, 0, 0, 0, 0, 0))
    assert robot.set_dh(small) is True
    assert robot.get_dh() == small
    assert robot.get_default_dh() == default


def test_a_measured_arm_goes_by_the_chain_and_its_inverse_comes_back() -> None:
    robot = AbsoluteRobot(arm(GEOMETRY), licensed=True)
    default = robot.get_default_dh()
    measured = replace(default, a=(50.4, 289.7, 0.1, 0, 0, 0), theta=(0.05, -90.1, 90.0, 0.02, 0, 0), d=(*default.d, 5.0))
    assert robot.set_dh(measured)
    assert isinstance(robot.kinematics, MeasuredArm)
    for q in spread(30, (3.0, 1.4, 2.3, 3.0, 2.0, 3.0)):
        pose = robot.kinematics.forward(q)
        assert unlike(robot.kinematics.follow(pose, [value + 1e-3 for value in q]), q) < 1e-8
        back = robot.kinematics.inverse(pose, q)
        assert apart(robot.kinematics.forward(back), pose) < 1e-9


def test_without_licence_250_and_not_while_moves_are_pending() -> None:
    with pytest.raises(RuntimeFault) as fault:
        AbsoluteRobot(arm(GEOMETRY), licensed=False).set_dh(AbsoluteRobot(arm(GEOMETRY), licensed=True).get_dh())
    assert fault.value.code == 250
    robot = AbsoluteRobot(arm(GEOMETRY), licensed=True)
    with pytest.raises(MotionError, match="pending"):
        robot.set_dh(robot.get_dh(), moves_pending=True)
    with pytest.raises(MotionError, match="six values"):
        DhParameters((0.0,) * 5, (0.0,) * 6, (0.0,) * 6, (0.0,) * 6)
