"""ROBOTstar V: LINEAR and SPLINE with their orientation, as the six-axis arm and a portal really run them."""

import math
from itertools import pairwise

import numpy as np
import pytest

from hil_tests.lab.cells.arms import Array, at, off_line, portal, robot, run
from hil_tests.lab.cells.reis_path import Path
from motion.geometry.conventions import VAL3
from motion.geometry.frames import Pose
from motion.geometry.orientation import angle_between
from motion.planner.arm import Arm
from motion.planner.route import Route
from motion.planner.stretch import Stretch
from motion.program.blocks import PoseTarget

P = 2e-3
HOME = (0.0, math.radians(30), math.radians(90), 0.0, math.radians(60), 0.0)
ARM = robot("tx60-like")


def beside(x: float, y: float = 0.0, z: float = 0.0, turn: float = 0.0) -> Pose:
    """mm and deg about the tool's own z from where the arm stands."""
    here = ARM.kinematics.forward(HOME)
    return VAL3.pose((x, y, z, 0, 0, 0)) @ here @ VAL3.pose((0, 0, 0, 0, 0, turn))


def poses(rows: Array) -> list[Pose]:
    return [ARM.kinematics.forward([float(value) for value in row]) for row in rows]


@pytest.mark.requirement("RSV-MOT-03", by=("motion.planner.block_paths:_line", "motion.planner.joint_path:joint_path_of"))
def test_linear_keeps_the_tool_of_an_arm_on_the_line_and_turns_it_steadily() -> None:
    path = Path(PoseTarget(beside(0)))
    path.set("BEWEG_ART", "LINEAR")
    path.set("BAHN_GESCHW", 400)
    end = beside(-60, 180, 40, 40)
    path.position(PoseTarget(end))
    arm = Arm(ARM, HOME, P)
    for block in path.blocks():
        arm.add(block)
    arm.finish()
    seen = poses(run(arm))
    places = np.array([pose.position for pose in seen])
    start = beside(0)
    assert off_line(places, start.position, end.position) < 10e-6
    assert places[-1] == pytest.approx(end.position, abs=1e-6) and angle_between(seen[-1].rotation, end.rotation) < 1e-6
    way, whole = math.dist(start.position, end.position), angle_between(start.rotation, end.rotation)
    for pose in seen:
        share = math.dist(pose.position, start.position) / way
        assert angle_between(start.rotation, pose.rotation) == pytest.approx(whole * share, abs=1e-4), "in step with the way"
    assert max(angle_between(a.rotation, b.rotation) for a, b in pairwise(seen)) < whole * 0.4 / way * P * 1.01, "no jump"


def spline_of(path: Path, route: Route) -> list[Stretch]:
    for block in path.blocks():
        route.add(block)
    route.finish()
    return route.take()


POINTS = ((60.0, 0.0), (100.0, 70.0), (180.0, 70.0), (240.0, 0.0))


def swing(tension: float) -> float:
    """m by which a spline over 4 points leaves its chords; it meets all of them."""
    path = Path(at(0))
    for name, value in (("BEWEG_ART", "SPLINE"), ("ISPL_TENS", tension), ("BAHN_GESCHW", 200)):
        path.set(name, value)
    for x, y in POINTS:
        path.position(at(x, y))
    parts = spline_of(path, Route(portal(), (0.0, 0.0, 0.0)))
    assert len(parts) == len(POINTS)
    most, before = 0.0, (0.0, 0.0, 0.0)
    for part, (x, y) in zip(parts, POINTS, strict=True):
        point = (x * 1e-3, y * 1e-3, 0.0)
        rows = part.path.at(np.linspace(0.0, part.path.length, 200))[:, :3]
        assert rows[-1] == pytest.approx(point, abs=1e-9), "programmed points are met"
        most, before = max(most, off_line(rows, before, point)), point
    return most


@pytest.mark.requirement("RSV-MOT-11", by=("motion.planner.spline_rows:curve_of", "gateway.pure.languages.robotstar.lines:line"))
def test_ispl_tens_0_50_100_swings_out_in_that_order_through_the_same_four_points() -> None:
    none, half, full = (swing(tension) for tension in (0, 50, 100))
    assert none < 0.05 * full and none < half < full
    assert full > 1e-3


@pytest.mark.requirement("RSV-MOT-12", by=("motion.planner.spline_rows:curve_of", "gateway.pure.languages.robotstar.lines:line"))
def test_iori_weight_0_before_p2_ignores_its_orientation_alone_and_p3_is_met() -> None:
    targets = (beside(-20, 50, 0, 10), beside(-40, 100, 0, 60), beside(-20, 150, 0, -10), beside(0, 200, 0, 0))

    def ends(weighted: bool) -> list[Pose]:
        path = Path(PoseTarget(beside(0)))
        path.set("BEWEG_ART", "SPLINE")
        for number, target in enumerate(targets, 1):
            if weighted and number == 2:
                path.set("IORI_WEIGHT", 0)
            path.position(PoseTarget(target))
        parts = spline_of(path, Route(ARM, HOME))
        return [ARM.kinematics.forward(part.path.q(part.path.length)) for part in parts]

    for weighted in (False, True):
        found = ends(weighted)
        assert len(found) == len(targets)
        off = [math.degrees(angle_between(pose.rotation, target.rotation)) for pose, target in zip(found, targets, strict=True)]
        assert [off[0], *off[2:]] == pytest.approx([0.0] * 3, abs=1e-3), "not modal: P3 is met again"
        assert (off[1] > 30.0) is weighted and (off[1] < 1e-3) is not weighted, "that of P2 is ignored"
        assert all(math.dist(pose.position, target.position) < 2e-6 for pose, target in zip(found, targets, strict=True))
