"""A motion of a stream that ends at rest has no more pieces than it needs: it begins when the last of them is there (AX-1460)."""

import numpy as np
import pytest

from hil_tests.lab.cells.arms import Array, robot
from motion.execution.follower import WAITING
from motion.planner import commit
from motion.planner.arm import Arm
from motion.planner.planner import Planner
from motion.program.text.reader import read

SHORT = "robot tx60-like\nangles val3\nstart 5 30 90 0 60 0\nptp joints 8 30 90 0 60 0\n"
STEPS = 400  # of 4 ms


def pieces_of(text: str) -> int:
    """As long as nothing more becomes known."""
    planner = Planner(robot("tx60-like"), read(text).start, cuts=True)
    for block in read(text).blocks:
        planner.add(block)
    planner.finish()
    return sum(len(planner.plan(planner.end, hurry=True)) for _ in range(4))


def rows_of(text: str) -> Array:
    """Set values on the way."""
    arm = Arm(robot("tx60-like"), read(text).start)
    arm.planner = Planner(arm.machine, arm.joints, capacity=arm.capacity, cuts=True)
    for block in read(text).blocks:
        arm.add(block)
    arm.finish()
    return np.array([arm.step() for _ in range(STEPS)])


def test_a_short_move_is_three_pieces() -> None:
    assert pieces_of(SHORT) <= 3


@pytest.mark.parametrize("text", [SHORT, SHORT.replace("ptp joints 8 30", "ptp joints -60 80")])
def test_no_set_value_changes(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    few, count = rows_of(text), pieces_of(text)
    monkeypatch.setattr(commit, "FEW", WAITING)
    assert pieces_of(text) >= 3 * count
    assert np.abs(few - rows_of(text)).max() < 2e-9
