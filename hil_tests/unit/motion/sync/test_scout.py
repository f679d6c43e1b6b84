"""What the scout keeps of what it saw: the least share of all places the robot is not past yet."""

import random

import pytest

from motion.sync.joint_lookahead import Caps, allowed


@pytest.mark.parametrize("seed", range(5))
def test_the_least_share_is_that_of_all_that_were_noted_and_not_passed(seed: int) -> None:
    dice, caps, plain, tau, lows = random.Random(seed), Caps(), list[tuple[float, float]](), 0.0, set()
    for _ in range(2000):
        tau += 0.01 * dice.random()
        caps.past(tau)
        while plain and plain[0][0] < tau:
            del plain[0]
        if dice.random() < 0.7:  # one of ten stands nearer than those before it: the chain was cut
            place, share = tau + (0.15 if dice.random() < 0.9 else 0.05), round(dice.random() ** 0.2, 2)
            caps.note(place, share)
            plain.append((place, share))
        if dice.random() < 0.005:
            caps.clear()
            plain.clear()
        assert caps.least == min((share for _, share in plain), default=1.0)
        lows.add(caps.least)
    assert len(lows) > 10 and 1.0 in lows


def test_a_joint_has_what_the_belt_leaves_of_its_speed() -> None:
    assert allowed((0.5, 0.0), (0.0, 0.0), (1.0, 1.0), top=1.0) == 1.0
    assert allowed((2.0, 0.0), (0.5, 0.0), (1.0, 1.0), top=1.0) == 0.25, "belt and path in one direction"
    assert allowed((-2.0, 0.0), (0.5, 0.0), (1.0, 1.0), top=1.0) == 0.75, "against one another"
    assert allowed((2.0, -4.0), (-0.5, 0.0), (1.0, 1.0), top=1.0) == 0.25, "the slowest joint decides"
    assert allowed((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), top=1.0) == 0.0, "the belt alone takes all of it"
