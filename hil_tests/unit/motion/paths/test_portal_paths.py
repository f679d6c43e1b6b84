"""Lines and corners of a portal with a wrist that stands: the same path as by the inverse, as one piece."""

import math

import numpy as np
import pytest

from motion.geometry.conventions import RHO3
from motion.geometry.frames import IDENTITY, Pose
from motion.geometry.limits import AxisLimits
from motion.kinematics.base import OutOfLimits
from motion.kinematics.portal import Portal
from motion.paths.base import Curve
from motion.paths.corner import corner
from motion.paths.line import line
from motion.planner.joint_path import joint_path_of
from motion.planner.portal_paths import exact_path

LINEAR = AxisLimits("X", -2.0, 2.0, 1.0, 5.0, 50.0, "mm")
ROTARY = AxisLimits("C", -3.0, 3.0, 2.0, 5.0, 50.0, "deg")
TOOL = Pose((0.05, 0.02, -0.1), IDENTITY.rotation)


def portal(letters: str) -> Portal:
    return Portal(letters, [LINEAR if letter in "xyz" else ROTARY for letter in letters], Pose((0.01, 0.0, -0.05), IDENTITY.rotation))


def pose(kinematics: Portal, x: float, y: float, *turns: float) -> Pose:
    return kinematics.forward([x, y, 0.1, *turns]) @ TOOL


def curves(kinematics: Portal, turns: tuple[float, ...]) -> list[Curve]:
    """Two lines, and the corner between them."""
    a, b, c = (pose(kinematics, x, y, *turns) for x, y in ((0.1, 0.2), (0.5, 0.3), (0.6, 0.7)))
    before, after = line(a, b), line(b, c)
    return [before, after, corner(before, after, 0.05, 0.05)]


@pytest.mark.parametrize(
    ("letters", "turns"), [("xyzc", (0.7,)), ("xyzcb", (0.7, 0.3)), ("xyzcba", (0.7, 0.3, -0.4)), ("xyzcbc", (0.4, 0.0, 0.2))]
)
def test_a_wrist_that_stands_needs_no_inverse_on_the_way(letters: str, turns: tuple[float, ...]) -> None:
    kinematics = portal(letters)
    for curve in curves(kinematics, turns):
        near = kinematics.inverse(curve.at(0.0) @ TOOL.inverse(), (0.0, 0.0, 0.0, *turns))
        exact = exact_path(curve, kinematics, near, TOOL)
        assert exact is not None
        general = joint_path_of(curve, kinematics, near, tool=TOOL)
        s = np.linspace(0.0, curve.length, 201)
        assert np.max(np.abs(exact.at(s)[:, : kinematics.axes] - general.at(s)[:, : kinematics.axes])) < 5e-9
        assert np.max(np.abs(exact.at(s, 1) - general.at(s, 1))) < 5e-4
        assert np.ptp(exact.at(s)[:, 3 : kinematics.axes], axis=0).max() == 0.0
        for place in s[::20]:
            reached = kinematics.forward(exact.q(float(place))) @ TOOL
            assert math.dist(reached.position, curve.at(float(place)).position) < 1e-9


def test_a_tool_that_turns_goes_the_general_way() -> None:
    kinematics = portal("xyzc")
    turning = line(pose(kinematics, 0.1, 0.2, 0.1), pose(kinematics, 0.5, 0.3, 0.6))
    assert exact_path(turning, kinematics, (0.1, 0.2, 0.1, 0.1), TOOL) is None


def test_an_end_beyond_the_travel_is_refused() -> None:
    kinematics = portal("xyzc")
    start, end = pose(kinematics, 1.9, 0.0, 0.5), pose(kinematics, 2.1, 0.0, 0.5)
    with pytest.raises(OutOfLimits):
        exact_path(line(start, end), kinematics, (1.9, 0.0, 0.1, 0.5), TOOL)


def test_a_turned_frame_is_driven_with_the_wrist_of_its_start() -> None:
    """The orientation of a frame is that of every place on a line in it."""
    kinematics = portal("xyzc")
    frame = RHO3.pose((0.2, 0.1, 0.0, 0.0, 0.0, 0.0))
    start, end = frame @ pose(kinematics, 0.1, 0.2, 0.9), frame @ pose(kinematics, 0.4, -0.2, 0.9)
    exact = exact_path(line(start, end), kinematics, (0.3, 0.3, 0.1, 0.9), TOOL)
    assert exact is not None
    assert exact.q(exact.length)[3] == pytest.approx(0.9, abs=1e-12)
