"""Paths of the axes: PTP and its passing (rho 3 L1773-1799), TCP curves through the inverse, keeping the branch."""

import math

import numpy as np
import pytest

from hil_tests.lab.cells.motion_paths import POINTING_DOWN, arm, past_singularity, point, portal_limits
from motion.execution.ptp import nominal_duration, plan_ptp
from motion.geometry.frames import Pose
from motion.geometry.limits import AxisLimits
from motion.kinematics.base import KinematicsError
from motion.paths.base import PathError, norm, sub
from motion.paths.corner import MISS
from motion.paths.joints import JointPath, joined, joint_blend, joint_line, joint_part
from motion.paths.line import line
from motion.paths.spline import spline
from motion.planner.joint_path import joint_path_of
from motion.planner.round_corner import span
from motion.timing.jerk import jerk_limited
from motion.timing.limits import law_limits

A, B, C = (0.0, 0.0, 0.0), (0.4, 0.2, -0.1), (0.5, -0.3, 0.2)
P213 = (0.02, 0.03, 0.05)


def passing(factor: float) -> tuple[JointPath, JointPath, JointPath]:
    """Leg, corner with P213 x factor, leg: the first axis within its range decides."""
    before, after = joint_line(A, B), joint_line(B, C)
    shares = np.abs([before.at(np.array([0.0]), 1)[0, :3], after.at(np.array([0.0]), 1)[0, :3]])
    r = factor * float(np.min(np.array(P213) / shares))
    curve = joint_blend(before, before.length - r, after, r)
    return joint_part(before, 0.0, before.length - r), curve, joint_part(after, r, after.length)


def test_r_ptp_2_doubles_the_range_and_speed_is_continuous_at_the_block_transition() -> None:
    once, twice = passing(1.0)[1], passing(2.0)[1]
    assert twice.length == pytest.approx(2 * once.length)
    for factor, curve in ((1.0, once), (2.0, twice)):
        s = np.linspace(0.0, curve.length, 201)
        away = np.max(np.abs(curve.at(s)[:, :3] - np.array(B)), axis=0)
        assert all(distance <= factor * most + 1e-12 for distance, most in zip(away, P213, strict=True))
        assert any(distance >= 0.99 * factor * most for distance, most in zip(away, P213, strict=True))
    path = joined(passing(1.0))
    law = jerk_limited(path, law_limits(portal_limits()))
    q = path.at(law.at(np.arange(0.0, law.duration, 1e-3)))[:, :3]
    steps = np.diff(q, axis=0)
    moving = steps[5:-5]
    assert np.min(np.max(np.abs(moving), axis=1)) > 0, "it stops"
    assert np.max(np.abs(np.diff(steps, axis=0))) <= 1.02 * 20.0 * 1e-6, "the speed of an axis has a step"


def test_the_corner_between_ptp_blocks_misses_the_point_by_the_closed_form() -> None:
    before, after = joint_line(A, B), joint_line(B, C)
    curve = joint_blend(before, before.length - 0.05, after, 0.05)
    u1, u2 = ((np.array(y) - np.array(x)) / np.max(np.abs(np.array(y) - np.array(x))) for x, y in ((A, B), (B, C)))
    middle = curve.at(np.array([0.05]))[0, :3] - np.array(B)
    assert np.abs(middle) == pytest.approx(MISS * 0.05 * np.abs(u2 - u1), abs=1e-12)


def test_small_corners_bend_more_gently_and_others_as_before() -> None:
    limits = portal_limits()  # a ramp takes 8 mm
    across = (joint_line(A, (0.4, 0.0, 0.0)), joint_line((0.4, 0.0, 0.0), (0.4, 0.3, 0.0)))
    assert span(*across, 0.016, limits) == pytest.approx(2 * 0.016 * 1.08) and span(*across, 0.064, limits) == 2 * 0.064
    going_on = (joint_line(A, (0.4, 0.1, 0.0)), joint_line((0.4, 0.1, 0.0), (0.8, -0.1, 0.0)))
    assert span(*going_on, 0.01, limits) == 2 * 0.01


def test_parts_and_joints_of_paths_fit_and_misfits_are_refused() -> None:
    path = joined(passing(1.5))
    s = np.linspace(0.0, path.length, 77)
    cut = 0.37 * path.length
    first, second = joint_part(path, 0.0, cut), joint_part(path, cut, path.length)
    again = joined([first, second])
    for order in range(4):
        assert np.allclose(again.at(s, order)[:, :3], path.at(s, order)[:, :3], atol=1e-6)
    with pytest.raises(PathError, match="does not begin"):
        joined([joint_line(A, B), joint_line(A, B)])
    with pytest.raises(PathError, match="a corner"):
        joined([joint_line(A, B), joint_line(B, C)])
    for start, end in ((0.2, 0.1), (-0.1, 0.2), (0.0, path.length + 1)):
        with pytest.raises(PathError):
            joint_part(path, start, end)
    for bad in ((A, A), (A, (math.nan, 0.0, 0.0)), (A, (1.0,))):
        with pytest.raises(PathError):
            joint_line(*bad)


@pytest.mark.requirement("RSV-MOT-01", by="motion.execution.ptp:plan_ptp")
def test_all_axes_of_a_ptp_move_start_and_end_together() -> None:
    limits = [AxisLimits(f"A{n}", -9, 9, 1.0 + n, 10.0, 100.0) for n in range(4)]
    piece = plan_ptp([0.0] * 4, [1.0, -2.0, 0.5, 0.001], limits)
    end = np.array([1.0, -2.0, 0.5, 0.001])
    for s in np.linspace(0.0, piece.length, 21):
        shares = np.array(piece.position(float(s))) / end
        assert np.allclose(shares, s / piece.length, atol=1e-9)
    assert nominal_duration(piece) > 0


def test_a_line_through_the_inverse_follows_it_to_2e_9_and_keeps_its_slopes() -> None:
    robot, _ = arm()
    curve = line(Pose((0.35, -0.15, 0.3), POINTING_DOWN), Pose((0.4, 0.15, 0.35), POINTING_DOWN))
    near = robot.inverse(curve.at(0.0), (-0.4, 0.5, 1.2, 0.0, 1.0, 0.0))
    path = joint_path_of(curve, robot, near)
    h = 1e-5
    for k in range(1, 60):
        s = curve.length * k / 60
        q = path.q(s)
        exact = robot.inverse(curve.at(s), q)
        assert max(abs(a - b) for a, b in zip(q, exact, strict=True)) < 5e-9
        ahead, behind = (robot.inverse(curve.at(s + d), q) for d in (h, -h))
        slope = (np.array(ahead) - np.array(behind)) / (2 * h)
        assert np.allclose(path.at(np.array([s]), 1)[0, :6], slope, atol=1e-6 * (1 + np.max(np.abs(slope))))
    assert path.at(np.array([path.length]))[0, 6] == pytest.approx(curve.length)
    assert path.at(np.array([path.length]))[0, 7] == pytest.approx(0.0, abs=1e-9)


def test_frame_and_tool_are_taken_into_account() -> None:
    robot, _ = arm()
    tool, frame = Pose((0.0, 0.03, 0.1), POINTING_DOWN), Pose((0.1, 0.05, 0.0), (0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0))
    flange = Pose((0.35, -0.1, 0.35), POINTING_DOWN)
    start = frame.inverse() @ flange @ tool
    x, y, z = start.position
    ends = ((x + 0.1, y + 0.05, z), (x + 0.15, y, z + 0.05))
    chain = spline([start, *(Pose(end, start.rotation) for end in ends)])
    path = joint_path_of(chain, robot, robot.inverse(flange, (-0.3, 0.5, 1.2, 0.0, 1.0, 0.0)), frame=frame, tool=tool)
    for k in range(31):
        s = chain.length * k / 30
        found = frame.inverse() @ robot.forward(path.q(s)) @ tool
        assert norm(sub(found.position, chain.at(s).position)) < 2e-8


def test_past_the_wrist_singularity_the_branch_is_kept_and_the_joints_stay_in_their_limits() -> None:
    """Goal 12: joints <= 1.00, path <= 10 um, <= 0.90 s at 0.57 deg."""
    curve, near, robot, limits = past_singularity(0.57)
    path = joint_path_of(curve, robot, near)
    law = jerk_limited(path, limits)
    assert law.duration <= 0.90
    q = path.at(law.at(np.arange(0.0, law.duration + 1e-3, 1e-3)))[:, :6]
    top = np.array([axis.speed for axis in robot.limits])
    assert np.max(np.abs(np.diff(q, axis=0)) / 1e-3 / top) <= 1.0
    assert np.min(np.abs(q[:, 4])) == pytest.approx(math.radians(0.57), rel=0.01)
    start, end = curve.at(0.0).position, curve.at(curve.length).position
    u = np.array(sub(end, start)) / norm(sub(end, start))
    for row in q[::10]:
        step = np.array(sub(robot.forward(tuple(row)).position, start))
        assert np.linalg.norm(step - u * (step @ u)) < 1e-6


def test_a_curve_out_of_reach_says_so_before_anything_moves() -> None:
    robot, _ = arm()
    curve = line(Pose((0.35, 0.0, 0.3), POINTING_DOWN), Pose((1.5, 0.0, 0.3), POINTING_DOWN))
    with pytest.raises(KinematicsError):
        joint_path_of(curve, robot, robot.inverse(curve.at(0.0), (0.0, 0.5, 1.2, 0.0, 1.0, 0.0)))


def test_unlike_blocks_join_through_a_quintic() -> None:
    """PTP to LINEAR with program slope: the path is left only inside the range (L1797-1799)."""
    robot, _ = arm()
    curve = line(Pose((0.35, -0.1, 0.3), POINTING_DOWN), Pose((0.35, 0.15, 0.3), POINTING_DOWN))
    near = robot.inverse(curve.at(0.0), (-0.4, 0.5, 1.2, 0.0, 1.0, 0.0))
    linear = joint_path_of(curve, robot, near)
    ptp = joint_line([value + 0.3 for value in near], near)
    middle = joint_blend(ptp, ptp.length - 0.04, linear, 0.03)
    path = joined([joint_part(ptp, 0.0, ptp.length - 0.04), middle, joint_part(linear, 0.03, linear.length)])
    for order, tolerance in ((1, 1e-9), (2, 1e-6)):
        for edge in (ptp.length - 0.04, ptp.length - 0.04 + middle.length):
            left, right = (path.at(np.array([edge + d]), order)[0, :6] for d in (-1e-12, 1e-12))
            assert np.allclose(left, right, atol=tolerance * (1 + np.max(np.abs(left))) * 10)


def test_point_helper_is_a_pose() -> None:
    assert point(1, 2, 3).position == (1, 2, 3)
