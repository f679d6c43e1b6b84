"""Laws of paths whose axes all move straight: PTP, lines of portals.  There the optimum is known in closed form (motion.execution.ptp)."""

import math

import numpy as np

from motion.execution.profile import Profile
from motion.planner.runs import Run
from motion.timing.law import Law, check_seconds
from motion.timing.two_ramps import TwoRamps, two_ramps

STRAIGHT = 1e-9  # largest second derivative of a path that counts as straight
STEP_S = 1e-3


def straight_law(run: Run) -> Law | None:
    """The jerk-limited optimum of a straight run with the same limits all along; None where it is not straight or they change."""
    path, limits = run.path, run.limits
    if any(abs(cap.start) > STRAIGHT or abs(cap.end - path.length) > STRAIGHT for cap in limits.caps):
        return None
    s = np.linspace(0.0, path.length, 2 * len(path.coefficients) + 1)
    first = path.at(s, 1)
    if float(np.abs(path.at(s, 2)).max()) > STRAIGHT or float(np.abs(first - first[0]).max()) > STRAIGHT:
        return None
    slope = np.abs(first[0])
    moving = slope > 1e-12
    middle = np.array([0.5 * path.length])
    top, _, jolt = limits.at(middle)
    speed, accel, decel, jerk = (
        float(np.min(rows[0][moving] / slope[moving], initial=math.inf)) for rows in (top, *limits.pulls(middle), jolt)
    )
    if not all(map(math.isfinite, (speed, accel, decel, jerk))):
        return None
    if accel != decel:
        return _law(two_ramps(path.length, speed, (accel, decel), jerk), path.length)
    profile = Profile()
    profile.configure(path.length, accel, jerk)
    if not profile.to_end((0.0, 0.0, 0.0), speed):
        return None
    return _law(profile, path.length)


def _law(profile: Profile | TwoRamps, length: float) -> Law:
    """On an even grid."""
    count = max(math.ceil(check_seconds(profile.duration) / STEP_S), 2)
    times = [profile.duration * k / count for k in range(count + 1)]
    states = profile.states(np.array(times)) if isinstance(profile, TwoRamps) else np.array([profile.at(t) for t in times])
    states[0], states[-1] = (0.0, 0.0, 0.0), (length, 0.0, 0.0)
    return Law(states[:, 0], states[:, 1], states[:, 2], profile.duration / count)
