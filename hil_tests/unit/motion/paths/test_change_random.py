"""Changes of speed on random chains of lines and corners: the starts that were worst before the set value was looked at once more."""

import random

import numpy as np
import pytest

from hil_tests.bench.online_figures import loaded, random_pieces, reached, run_out
from hil_tests.lab.cells import arms
from hil_tests.lab.cells import motion_paths as lab
from hil_tests.lab.cells.motion_paths import portal_limits, worst_shares
from hil_tests.soak import motion as soak
from motion.execution.stepper import State
from motion.paths.corner import corner
from motion.paths.line import line
from motion.planner.commit import timed_pieces
from motion.timing.choice import Rounded, assembled
from motion.timing.jerk import jerk_limited
from motion.timing.limits import law_limits

LIMITS = portal_limits()


def dice_before(chain: int) -> random.Random:
    """As random_pieces leaves it after so many chains of seed 5: three numbers a point, one a corner."""
    dice = random.Random(5)
    for _ in range(chain):
        points = dice.randint(3, 5)
        for _ in range(3 * points + points - 2):
            dice.random()
    return dice


@pytest.mark.parametrize(("chain", "at"), [(24, 354), (21, 161), (12, 205), (39, 99)])
def test_override_100_30_100_keeps_the_limits_of_axes_that_turn_back_or_ride_on_their_jerk(chain: int, at: int) -> None:
    pieces = random_pieces(dice_before(chain), LIMITS, 3)
    samples = run_out(loaded(pieces, 3), {at: 0.3, at + 300: 1.0})
    speed, accel, jerk = worst_shares(np.array([pieces[0].start(), *(s.q for s in samples)]), LIMITS)
    assert speed <= 1.0 and accel <= 1.02 and jerk <= 1.10
    assert reached(run_out(loaded(pieces, 3), {}), samples, at, 0.31) <= 120.0


@pytest.mark.parametrize("seed", [1_000_354, 1_000_983, 1_000_447, 1_000_120, 1_000_301, 1_000_370])
def test_random_orders_keep_the_limits_of_axes_that_turn_back_as_the_path_comes_back_to_full_speed(seed: int) -> None:
    """The programs of a soak whose jerk had come to 1.54, 1.52 and 1.48 of the limit; then 1.11, where c was cut to less than it had to
    be; 1.18, where an axis turned back between two places at more u than any c could have met; 1.11, where a climb had nothing to spare."""
    driven = np.array(soak.ordered(soak.loaded(soak.pieces_of(seed), soak.MS), random.Random(seed)))
    shares = arms.shares(arms.portal(), driven, soak.MS)
    assert all(share <= top for share, top in zip(shares, soak.TOPS_CHANGING, strict=True)), shares


@pytest.mark.parametrize("at", [77, 95, 101])
def test_periods_of_10_ms_keep_the_limits_through_a_stop_and_the_climb_behind_it(at: int) -> None:
    """Set values 10 ms apart came to 1.047 of the acceleration, on twelve axes together to 1.26: of a corner a change saw three places."""
    limits, period = portal_limits(0.3, 1.5, 30.0), 0.01
    points = [lab.point(0.0, 0.0, 0.0), lab.point(0.11, -0.035, 0.0), lab.point(0.065, 0.092, 0.0)]
    first, second = line(*points[:2]), line(*points[1:])
    rounded = Rounded(0.01, 0.01, lab.portal_path(corner(first, second, 0.01, 0.01)))
    path, bounds = assembled([lab.portal_path(first), lab.portal_path(second)], [rounded]), law_limits(limits)
    pieces = timed_pieces(path, bounds, jerk_limited(path, bounds))
    stepper = loaded(pieces, 3, period)
    stepper.set_override(0.5)
    samples = [stepper.step() for _ in range(at)]
    stepper.stop()
    while stepper.state is State.STOPPING:
        samples.append(stepper.step())
    stepper.set_override(1.0)
    stepper.resume()
    samples += run_out(stepper, {})
    assert samples[-1].q == pytest.approx((0.065, 0.092, 0.0), abs=1e-9)
    speed, accel, jerk = worst_shares(np.array([pieces[0].start(), *(s.q for s in samples)]), limits, period)
    assert speed <= 1.001 and accel <= 1.02 and jerk <= 1.10
