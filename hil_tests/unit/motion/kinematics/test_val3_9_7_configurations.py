"""VAL 3, chapter 9.7.4 and 9.7.5: the inequalities that define a configuration."""

import math

import pytest

from hil_tests.unit.motion.kinematics.robots import GENERAL, TX60, arm, scara, spread
from motion.kinematics.arm6 import ArmGeometry
from motion.kinematics.base import Configuration, Elbow, Shoulder, Wrist


@pytest.mark.requirement("VAL-CFG-01", by="motion.kinematics.arm6:Arm6.configuration")
def test_the_inequalities_of_an_rx_or_tx_arm() -> None:
    robot = arm()

    def at(j2: float, j3: float, j5: float) -> Configuration:
        return robot.configuration([math.radians(value) for value in (0, j2, j3, 0, j5, 0)])

    assert at(30, 0, 10).elbow is Elbow.POSITIVE, "j3 = 0"
    assert at(30, -1e-9, 10).elbow is Elbow.NEGATIVE
    assert at(30, 20, -1).wrist is Wrist.NEGATIVE
    assert at(30, 20, 0).wrist is Wrist.POSITIVE
    assert at(0, 0, 0).shoulder is Shoulder.LEFTY, "the sum is 0"
    assert at(-30, 20, 0).shoulder is Shoulder.RIGHTY, "0.29 sin -30 + 0.31 sin -10 < 0"
    assert at(-30, 70, 0).shoulder is Shoulder.LEFTY, "0.29 sin -30 + 0.31 sin 40 > 0"


@pytest.mark.requirement("VAL-CFG-01", by="motion.kinematics.arm6:Arm6.configuration")
def test_the_offset_of_axes_1_and_2_counts_for_the_shoulder() -> None:
    robot = arm(ArmGeometry(0.5, 0.4, 0.4, 0.1, delta=0.15))
    assert robot.configuration((0, math.radians(-10), 0, 0, 0, 0)).shoulder is Shoulder.LEFTY, "0.8 sin -10 + 0.15 > 0"
    assert robot.configuration((0, math.radians(-11), 0, 0, 0, 0)).shoulder is Shoulder.RIGHTY, "0.8 sin -11 + 0.15 < 0"
    bent = arm(ArmGeometry(0.5, 0.4, 0.4, 0.1, elbow=0.1))
    for j2, j3, side in ((-6, 0, Shoulder.LEFTY), (-8, 0, Shoulder.RIGHTY), (-15, 26, Shoulder.LEFTY), (-53, 173, Shoulder.RIGHTY)):
        q2, q23 = math.radians(j2), math.radians(j2 + j3)
        forwards = 0.4 * math.sin(q2) + 0.4 * math.sin(q23) + 0.1 * math.cos(q23)
        assert abs(forwards) > 0.001 and (forwards > 0) is (side is Shoulder.LEFTY)
        assert bent.configuration((0, q2, math.radians(j3), 0, 0, 0)).shoulder is side, "the offset of the elbow"


@pytest.mark.requirement("VAL-CFG-01", by="motion.kinematics.scara:Scara.configuration")
def test_a_scara_is_righty_where_the_sine_of_j2_is_positive() -> None:
    robot = scara()
    shoulders = [robot.configuration((0, math.radians(j2), 0, 0)).shoulder for j2 in (90, 1e-9, 0, -1, -90, 190, -190)]
    right, left = Shoulder.RIGHTY, Shoulder.LEFTY
    assert shoulders == [right, right, left, left, left, left, right]


@pytest.mark.parametrize("geometry", [TX60, GENERAL])
def test_flags_of_branches_are_those_of_the_formulas_and_all_eight_are_there(geometry: ArmGeometry) -> None:
    robot = arm(geometry)
    eight = 0
    for q in spread(200, (3.1,) * 6):
        found = robot.branches(robot.forward(q))
        assert all(robot.configuration(joints) == flags for joints, flags in found)
        eight += len({flags for _, flags in found}) == len(found) == 8
    assert eight >= (200 if geometry is TX60 else 80)


def test_fields_that_are_free_or_same_demand_nothing_or_what_was() -> None:
    right = Configuration(Shoulder.RIGHTY, Elbow.POSITIVE, Wrist.NEGATIVE)
    left = Configuration(Shoulder.LEFTY, Elbow.POSITIVE, Wrist.NEGATIVE)
    assert Configuration().admits(right, left)
    assert Configuration(shoulder=Shoulder.SAME).admits(right, right)
    assert not Configuration(shoulder=Shoulder.SAME).admits(right, left)
    assert not Configuration(elbow=Elbow.NEGATIVE).admits(right, left)
    assert Configuration(wrist=Wrist.NEGATIVE, elbow=Elbow.SAME).admits(right, left)
