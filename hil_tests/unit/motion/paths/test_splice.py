"""A path that grows while the axes move: the braking tail is replaced, nothing stops, nothing starves (design 6, goal 8)."""

import numpy as np

from hil_tests.lab.cells.motion_paths import chain_path, contour_points, portal_limits, worst_shares
from motion.execution.follower import Follower
from motion.paths.joints import JointPath, joint_part
from motion.paths.spline import spline
from motion.planner.commit import timed_pieces
from motion.planner.quick_law import swift, width_s
from motion.timing.jerk import jerk_limited
from motion.timing.law import Law
from motion.timing.limits import law_limits
from motion.timing.refine import past_of, refined_work
from motion.timing.slices import whole
from motion.timing.splice import led_over

LIMITS = portal_limits(0.5, 5.0, 200.0)
BOUNDS = law_limits(LIMITS)


def gone_on(path: JointPath, law: Law, index: int) -> Law | None:
    """From a law's grid point on to the end of a path that begins with its own, as the planner does it."""
    led = led_over(law, index, swift(path, BOUNDS, width_s(BOUNDS)).law)
    return None if led is None else whole(refined_work(path, BOUNDS, led[0], led[0].duration, past_of(law, index * law.step)))


def test_the_contour_in_two_windows_takes_as_long_as_in_one_and_never_stops() -> None:
    path = chain_path(spline(contour_points()))
    window = joint_part(path, 0.0, 0.4)
    law = jerk_limited(window, BOUNDS)
    first = timed_pieces(window, BOUNDS, law)
    follower = Follower(3, 1e-3)
    for piece in first:
        follower.load(piece)
    early = [follower.step(1.0) for _ in range(150)]
    k, tau = 0, 0.0
    while tau < 0.45:  # a piece that has not begun: the planner's lead
        tau += first[k].duration
        k += 1
    on = gone_on(path, law, round(tau / law.step))
    assert on is not None
    for piece in timed_pieces(path, BOUNDS, on, first_id=first[k].id, new_tail=True):
        follower.load(piece)
    samples = early
    while not samples[-1].at_end:
        samples.append(follower.step(1.0))
    q = np.array([[progress.q[axis][0] for axis in range(3)] for progress in samples])
    speed, accel, jerk = worst_shares(np.concatenate([path.at(np.zeros(1))[:, :3], q]), LIMITS)
    assert speed <= 1.0 and accel <= 1.02 and jerk <= 1.05
    moving = np.max(np.abs(np.diff(q, axis=0)), axis=1)[80:-80]  # starting and ending left out
    assert np.min(moving) > 0.1e-3, "it stops between the windows"
    assert len(samples) * 1e-3 < jerk_limited(path, BOUNDS).duration * 1.005 + 2e-3
    assert np.allclose(q[-1], path.at(np.array([path.length]))[0, :3], atol=1e-9)


def test_laws_that_never_come_close_are_not_joined() -> None:
    path = chain_path(spline(contour_points()))
    law = jerk_limited(joint_part(path, 0.0, 0.1), BOUNDS)
    assert gone_on(joint_part(path, 0.0, 0.3), law, len(law.s) - 20) is None
