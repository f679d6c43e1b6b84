"""The skin over ruckig: plans that touch a limit to the last bit, plans that may not be."""

import random

import pytest

from motion.execution.profile import Profile


def test_a_state_that_just_reaches_the_speed_limit_has_a_plan_at_once() -> None:
    """sdot + sddot^2 / 2 jerk = limit: the state every re-plan in the last jerk phase before the limit starts from."""
    dice = random.Random(1)
    for _ in range(500):
        length, accel, jerk, limit = dice.uniform(5, 100), dice.uniform(1, 10), dice.uniform(10, 100), dice.uniform(0.05, 1)
        rising = dice.uniform(0, min(accel, (2 * jerk * limit) ** 0.5))
        profile = Profile()
        profile.configure(length, accel, jerk)
        assert profile.to_end((0.1 * length, limit - rising * rising / (2 * jerk), rising), limit)
        # to ruckig's own tolerance; the stepper ends exactly
        assert profile.at(profile.duration)[0] == pytest.approx(length, abs=1e-8 * length)
        assert max(profile.at(profile.duration * n / 50)[1] for n in range(51)) <= limit * (1 + 2e-6)


def test_a_plan_that_would_overshoot_the_end_is_none_and_the_old_one_stays() -> None:
    profile = Profile()
    profile.configure(10.0, 1.0, 10.0)
    assert profile.to_end((0.0, 0.0, 0.0), 1.0)
    before = profile.duration
    assert not profile.to_end((9.9, 1.0, 0.0), 1.0)
    assert not profile.to_speed((9.9, 1.0, 0.0), 0.0)
    assert not profile.to_speed((5.0, 1.0, 0.0), 0.5, latest=5.1)
    assert profile.duration == before
    assert profile.to_speed((5.0, 1.0, 0.0), 0.0)
