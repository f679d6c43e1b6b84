"""Additional axes 7 .. 24, coupled axes."""

import math

import numpy as np
import pytest

from hil_tests.unit.motion.kinematics.robots import apart, arm, scara, sliding, spread, turning, unlike
from hil_tests.unit.motion.kinematics.test_arm import by_differences
from motion.errors import MotionError
from motion.geometry.frames import IDENTITY, translation
from motion.kinematics.base import OutOfLimits
from motion.kinematics.coupled import Coupled
from motion.kinematics.group import Additional, Group, OnTable, Role, on_course

TRACK = Additional(sliding("track"), Role.CARRIER, (0.0, 1.0, 0.0), translation(0.0, 0.0, 0.2))
COLUMN = Additional(turning("column"), Role.CARRIER, (0.0, 0.0, 1.0), translation(0.5, 0.0, 0.0))
TABLE = Additional(turning("table"), Role.TABLE, (1.0, 0.0, 0.0), translation(1.0, 0.0, 0.0))
SPINDLE = Additional(turning("spindle", -9, 9))


def group() -> Group:
    return Group(arm(), (TRACK, COLUMN, TABLE, SPINDLE))


def test_carriers_move_the_robot_and_the_inverse_leaves_additional_axes_where_they_are() -> None:
    robot = group()
    assert robot.axes == 10
    for q in spread(20, (3.0,) * 6):
        joints = (*q, 0.7, -0.4, 1.0, 5.0)
        pose = robot.forward(joints)
        assert unlike(robot.inverse(pose, joints), joints) < 1e-8
        assert unlike(robot.follow(pose, joints), joints) < 1e-8
        assert np.abs(robot.jacobian(joints) - by_differences(robot, joints)).max() < 1e-8
    on_track = robot.forward((*q, 0.7, 0.0, 0.0, 0.0)).position
    at_start = robot.forward((*q, 0.0, 0.0, 0.0, 0.0)).position
    assert np.subtract(on_track, at_start) == pytest.approx((0, 0.7, 0))


def test_a_table_carries_the_workpiece_and_not_the_robot() -> None:
    robot = group()
    still, turned = (0.1,) * 6 + (0.0, 0.0, 0.0, 0.0), (0.1,) * 6 + (0.0, 0.0, 1.5, 0.0)
    assert apart(robot.forward(still), robot.forward(turned)) == 0
    assert robot.table(turned).apply((0.0, 1.0, 0.0)) == pytest.approx((1.0, math.cos(1.5), math.sin(1.5)))


def test_a_workpiece_on_tables_sees_the_flange_go_the_other_way() -> None:
    tilt = Additional(turning("tilt"), Role.TABLE, (0.0, 1.0, 0.0), translation(0.0, 0.3, 0.1))
    world, seen = Group(arm(), (TRACK, TABLE, SPINDLE, tilt)), OnTable(arm(), (TRACK, TABLE, SPINDLE, tilt))
    for q in spread(20, (3.0,) * 6):
        assert apart(seen.forward((*q, 0.7, 0.0, 5.0, 0.0)), world.forward((*q, 0.7, 0.0, 5.0, 0.0))) < 1e-12, "tables at 0"
        joints = (*q, 0.7, 1.0, 5.0, -0.6)
        pose = seen.forward(joints)
        assert apart(world.table(joints) @ world.table((0.0,) * 10).inverse() @ pose, world.forward(joints)) < 1e-12
        assert unlike(seen.inverse(pose, joints), joints) < 1e-8
        assert unlike(seen.follow(pose, joints), joints) < 1e-8
        assert np.abs(seen.jacobian(joints) - by_differences(seen, joints)).max() < 1e-8


def test_joints_are_looked_for_near_the_arm_with_additional_axes_on_their_course() -> None:
    assert on_course(Group(arm(), (TRACK,)), (0.1,) * 9, (0.2,) * 9) == (*(0.1,) * 6, 0.2)
    assert on_course(arm(), (0.1,) * 9, (0.2,) * 9) == (0.1,) * 6


def test_branches_of_a_group_are_those_of_its_robot() -> None:
    robot = group()
    pose = robot.forward((*(0.4, 0.5, 0.6, 0.7, 0.8, 0.9), 0.0, 0.0, 0.0, 0.0))
    found = robot.branches(pose)
    assert len(found) == 8
    assert all(apart(robot.forward(joints), pose) < 1e-12 and robot.configuration(joints) == flags for joints, flags in found)


def test_an_additional_axis_beyond_its_travel_is_named() -> None:
    robot = group()
    with pytest.raises(OutOfLimits) as fault:
        robot.inverse(IDENTITY, (0.0,) * 6 + (4.5, 0.0, 0.0, 0.0))
    assert (fault.value.axis, fault.value.number) == ("track", 531)
    with pytest.raises(MotionError, match="10 axes"):
        robot.inverse(IDENTITY, (0.0,) * 6)


def test_at_most_24_axes_and_directions_of_length_1() -> None:
    assert Group(arm(), [SPINDLE] * 18).axes == 24
    with pytest.raises(MotionError, match="24"):
        Group(arm(), [SPINDLE] * 19)
    with pytest.raises(MotionError, match="length 1"):
        Additional(sliding("x"), Role.CARRIER, (1.0, 1.0, 0.0))


SCREW = ((1.0, 0.0, 0.0, 0.0), (0.5, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.004), (0.0, 0.0, 0.0, 1.0))


def test_coupled_axes_turn_several_joints() -> None:
    inner = scara()
    robot = Coupled(inner, SCREW, inner.limits)
    axes = (0.3, 0.5, -0.1, 0.9)
    assert robot.joints(axes) == pytest.approx((0.3, 0.65, -0.0964, 0.9))
    assert robot.positions(robot.joints(axes)) == pytest.approx(axes)
    assert apart(robot.forward(axes), inner.forward(robot.joints(axes))) == 0
    for q in spread(20, (2.0, 2.0, 1.0, 3.0)):
        pose = robot.forward(q)
        assert unlike(robot.inverse(pose, q), q) < 1e-6
        assert unlike(robot.follow(pose, q), q) < 1e-6
        assert all(apart(robot.forward(joints), pose) < 1e-12 for joints, _ in robot.branches(pose))
        assert np.abs(robot.jacobian(q) - by_differences(robot, q)).max() < 1e-8
        assert robot.configuration(q) == inner.configuration(robot.joints(q))


def test_the_travel_of_a_coupled_axis_is_that_of_the_drive() -> None:
    inner = scara()
    limits = [inner.limits[0], turning("a2", -0.2, 0.2), *inner.limits[2:]]
    robot = Coupled(inner, SCREW, limits)
    with pytest.raises(OutOfLimits) as fault:
        robot.inverse(inner.forward((0.3, 0.9, 0.0, 0.0)), (0.3, 0.1, 0.0, 0.0))
    assert fault.value.axis == "a2"
    for matrix in (SCREW[:3], ((0.0,) * 4,) * 4):
        with pytest.raises(MotionError, match="couplings"):
            Coupled(inner, matrix, inner.limits)
    with pytest.raises(MotionError, match="limits"):
        Coupled(inner, SCREW, inner.limits[:2])
