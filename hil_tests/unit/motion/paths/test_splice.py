"""A path that grows while the axes move: the braking tail is replaced, nothing stops, nothing starves (design 6, goal 8)."""

import numpy as np

from hil_tests.lab.cells.motion_paths import chain_path, contour_points, portal_limits, worst_shares
from motion.execution.follower import Follower
from motion.paths.joints import joint_part
from motion.paths.spline import spline
from motion.planner.commit import timed_pieces
from motion.timing.jerk import jerk_limited
from motion.timing.limits import law_limits
from motion.timing.splice import continued

LIMITS = portal_limits(0.5, 5.0, 200.0)


def test_the_contour_in_two_windows_takes_as_long_as_in_one_and_never_stops() -> None:
    whole, bounds = chain_path(spline(contour_points())), law_limits(LIMITS)
    window = joint_part(whole, 0.0, 0.4)
    law = jerk_limited(window, bounds)
    first = timed_pieces(window, bounds, law)
    follower = Follower(3, 1e-3)
    for piece in first:
        follower.load(piece)
    early = [follower.step(1.0) for _ in range(150)]
    k, tau = 0, 0.0
    while tau < 0.45:  # a piece that has not begun: the planner's lead
        tau += first[k].duration
        k += 1
    on = continued(whole, bounds, law, round(tau / law.step))
    assert on is not None
    for piece in timed_pieces(whole, bounds, on, first_id=first[k].id, new_tail=True):
        follower.load(piece)
    samples = early
    while not samples[-1].at_end:
        samples.append(follower.step(1.0))
    q = np.array([[progress.q[axis][0] for axis in range(3)] for progress in samples])
    speed, accel, jerk = worst_shares(np.concatenate([whole.at(np.zeros(1))[:, :3], q]), LIMITS)
    assert speed <= 1.0 and accel <= 1.02 and jerk <= 1.08
    moving = np.max(np.abs(np.diff(q, axis=0)), axis=1)[80:-80]  # starting and ending left out
    assert np.min(moving) > 0.1e-3, "it stops between the windows"
    assert len(samples) * 1e-3 < jerk_limited(whole, bounds).duration * 1.005 + 2e-3
    assert np.allclose(q[-1], whole.at(np.array([whole.length]))[0, :3], atol=1e-9)


def test_laws_that_never_come_close_are_not_joined() -> None:
    whole, bounds = chain_path(spline(contour_points())), law_limits(LIMITS)
    law = jerk_limited(joint_part(whole, 0.0, 0.1), bounds)
    assert continued(joint_part(whole, 0.0, 0.3), bounds, law, len(law.s) - 20) is None
