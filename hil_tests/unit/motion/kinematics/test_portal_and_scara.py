"""Portals with 2 to 6 axes, SCARAs, axes without transformation."""

import itertools
import math

import numpy as np
import pytest

from hil_tests.unit.motion.kinematics.robots import apart, scara, sliding, spread, turning, unlike, unlike_turned
from hil_tests.unit.motion.kinematics.test_arm import by_differences
from motion.errors import MotionError
from motion.geometry.frames import IDENTITY, Pose, translation
from motion.kinematics.base import FREE, SAME, Configuration, OutOfLimits, Shoulder, Unreachable, WrongConfiguration, beyond
from motion.kinematics.identity import Identity
from motion.kinematics.portal import Portal, about

LETTERS = [
    linear + "".join(rotary)
    for linear in ("xy", "xz", "zx", "xyz")
    for count in range(4)
    for rotary in itertools.product("abc", repeat=count)
    if len(linear) + count <= 6 and all(one != two for one, two in itertools.pairwise(rotary))
]
FLANGE = Pose((0.1, 0.2, 0.3), about(0, 0.3))


def portal(letters: str, flange: Pose = IDENTITY) -> Portal:
    return Portal(letters, [sliding(letter) if letter in "xyz" else turning(letter) for letter in letters], flange)


@pytest.mark.parametrize("letters", LETTERS)
def test_every_portal_finds_its_joints_again(letters: str) -> None:
    robot = portal(letters, FLANGE)
    for q in spread(12, (3.0,) * len(letters)):
        pose = robot.forward(q)
        assert all(apart(robot.forward(joints), pose) < 1e-12 for joints, _ in robot.branches(pose))
        assert all(robot.configuration(joints) == flags for joints, flags in robot.branches(pose))
        assert unlike(robot.inverse(pose, q), q) < 1e-9
        assert np.abs(robot.jacobian(q) - by_differences(robot, q)).max() < 1e-8


@pytest.mark.parametrize(("letters", "middle"), [("xyzcba", math.pi / 2), ("xyzabc", -math.pi / 2), ("xyzcbc", 0.0), ("xyzaba", math.pi)])
def test_at_the_pole_of_a_portals_wrist_the_last_axis_stays(letters: str, middle: float) -> None:
    robot = portal(letters)
    q = (0.1, 0.2, 0.3, 0.7, middle, -0.4)
    back = robot.inverse(robot.forward(q), q)
    assert apart(robot.forward(back), robot.forward(q)) < 1e-12
    assert back[5] == -0.4
    assert unlike_turned(back, q) < 1e-9


def test_a_direction_the_portal_does_not_have_is_532_or_534() -> None:
    tilted = Pose((0.1, 0.2, 0.0), about(0, 0.2))
    for letters, pose, number, words in (
        ("xy", translation(0.1, 0.2, 0.003), 532, "3 mm in z"),
        ("xyz", tilted, 534, "orientation"),
        ("xyzc", tilted, 534, "orientation"),
        ("xyzcb", tilted, 534, "orientation"),
        ("xyz", Pose((math.nan, 0.0, 0.0), IDENTITY.rotation), 530, "not a finite number"),
    ):
        robot = portal(letters)
        with pytest.raises((Unreachable, OutOfLimits)) as fault:
            robot.inverse(pose, (0.0,) * len(letters))
        assert fault.value.number == number
        assert words in str(fault.value)


def test_letters_and_units_that_make_no_portal() -> None:
    for letters in ("x", "xx", "cxy", "xyzaa", "xyzabca", "xq", "ab"):
        with pytest.raises(MotionError, match="portal"):
            portal(letters)
    with pytest.raises(MotionError, match="unit"):
        Portal("xy", [sliding("x"), turning("y")])
    with pytest.raises(MotionError, match="limits"):
        Portal("xyz", [sliding("x")])


@pytest.mark.parametrize("down", [True, False])
def test_a_scara_finds_both_shoulders(down: bool) -> None:
    robot = scara(down=down)
    for q in spread(60, (3.1, 3.1, 1.0, 3.1)):
        pose = robot.forward(q)
        found = robot.branches(pose)
        assert {flags.shoulder for _, flags in found} == {Shoulder.RIGHTY, Shoulder.LEFTY}
        assert all(apart(robot.forward(joints), pose) < 1e-12 for joints, _ in found)
        assert all(robot.configuration(joints) == flags for joints, flags in found)
        assert unlike(robot.inverse(pose, q, SAME), q) < 1e-6
        assert unlike(robot.follow(pose, q), q) < 1e-6
        assert np.abs(robot.jacobian(q) - by_differences(robot, q)).max() < 1e-8


def test_a_scara_stretched_too_far_tilted_or_on_the_wrong_side() -> None:
    robot = scara()
    q = (0.3, 0.0, -0.1, 0.2)
    stretched = robot.forward(q)
    at_full_length = Pose((0.35 + 0.25, 0.0, 0.2), stretched.rotation)
    assert [flags.shoulder for _, flags in robot.branches(at_full_length)] == [Shoulder.LEFTY]
    assert unlike(robot.inverse(stretched, q), q) < 1e-7
    assert unlike(robot.follow(stretched, (0.3, 0.1, -0.1, 0.1)), q) < 1e-7
    down = stretched.rotation
    for pose, number in (
        (Pose((0.7, 0.0, 0.0), down), 530),
        (Pose((0.05, 0.0, 0.0), down), 530),
        (Pose((0.4, 0.0, 0.0), IDENTITY.rotation), 534),
        (Pose((0.4, 0.0, 0.0), about(0, math.pi - 1e-6)), 534),
        (Pose((math.nan, 0.0, 0.0), down), 530),
    ):
        for ask in (robot.inverse, robot.follow):
            with pytest.raises(Unreachable) as fault:
                ask(pose, q)
            assert fault.value.number == number
    with pytest.raises(OutOfLimits) as far:
        robot.inverse(Pose((0.4, 0.1, 9.0), down), q)
    assert far.value.axis == "a3"


def test_a_scara_keeps_to_the_shoulder_that_is_demanded() -> None:
    robot = scara()
    q = (0.3, 0.9, -0.1, 0.2)
    pose = robot.forward(q)
    left = robot.inverse(pose, q, Configuration(shoulder=Shoulder.LEFTY))
    assert left[1] == pytest.approx(-0.9)
    narrow = type(robot)(0.35, 0.25, 0.3, [turning("a1"), turning("a2", 0.0, 2.0), sliding("a3"), turning("a4")])
    with pytest.raises(WrongConfiguration):
        narrow.inverse(pose, q, Configuration(shoulder=Shoulder.LEFTY))


def test_a_scara_that_cannot_be() -> None:
    with pytest.raises(MotionError, match="two arms"):
        type(scara())(0.0, 0.2, 0.3, scara().limits)
    with pytest.raises(MotionError, match="axes"):
        type(scara())(0.3, 0.2, 0.3, [turning("a")] * 4)


def test_without_transformation_points_are_positions_of_axes() -> None:
    robot = Identity([turning("t"), sliding("u"), sliding("v")])
    pose = robot.forward((0.5, 0.1, 0.2))
    assert pose == translation(0.1, 0.2, 0.0)
    assert robot.inverse(pose, (0.5, 0.0, 0.0)) == (0.5, 0.1, 0.2)
    assert robot.follow(pose, (0.7, 0.0, 0.0)) == (0.7, 0.1, 0.2)
    assert robot.branches(pose) == [((0.0, 0.1, 0.2), FREE)]
    assert robot.configuration((0.5, 0.1, 0.2)) == FREE
    assert np.abs(robot.jacobian((0.5, 0.1, 0.2)) - by_differences(robot, (0.5, 0.1, 0.2))).max() < 1e-8
    with pytest.raises(Unreachable) as fault:
        robot.inverse(translation(0.1, 0.2, 0.3), (0.0, 0.0, 0.0))
    assert fault.value.number == 532
    with pytest.raises(MotionError, match="25 axes"):
        Identity([turning("t")] * 25)


@pytest.mark.parametrize(
    ("value", "words"), [(600.001, "600.001"), (600.00004, "600.00004"), (99.9999996, "99.9999996"), (712.3, "712.300"), (300.0, "300.000")]
)
def test_a_distance_out_of_reach_shows_that_it_is(value: float, words: str) -> None:
    """It said: 600.000 mm, possible are 100.000 .. 600.000 mm."""
    assert beyond(value, 100.0, 600.0) == words
