"""A motion of a stream that ends at rest has no more pieces than it needs: it begins when the last of them is there (AX-1460)."""

import numpy as np
import pytest

from gateway.pure.planning.chain import Chain
from hil_tests.lab.cells.arms import Array, robot
from motion.execution.follower import WAITING
from motion.execution.timed import TimedPiece
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


LONG = SHORT.replace("ptp joints 8 30", "ptp joints -160 80") + "ptp joints 8 30 90 0 60 0 speed=20\n"


LINE = SHORT + "linear pose 406.661 77.349 301.147 180 0 172 path=150\n"


def chained(text: str) -> tuple[Chain, list[TimedPiece], float]:
    """All pieces of the path, handed on."""
    planner = Planner(robot("tx60-like"), read(text).start, cuts=True)
    for block in read(text).blocks:
        planner.add(block)
    planner.finish()
    chain, end = Chain(), 0.0
    pieces = [made for _ in range(4) for made in planner.plan(planner.end, hurry=True)]
    for made in pieces:
        chain.add(made, end)
        end += made.duration
    return chain, pieces, end


@pytest.mark.parametrize("kind", ["ptp", "lin"])
def test_on_a_long_piece_the_axes_are_where_the_cycle_reports_them(kind: str) -> None:
    chain, pieces, end = chained(LONG if kind == "ptp" else LINE)
    begin = 0.0
    assert any(made.duration > 0.05 for made in pieces)
    for made in pieces:
        for time, node in zip(made.times[:-1], made.nodes[:-1], strict=True):
            found = chain.near_to(chain.tau(made.id, end), made.id, node[:-3:3], node[-3])
            assert begin + time - 1e-9 <= found <= min(begin + time + 0.017, begin + made.duration) + 1e-9
        begin += made.duration


def test_behind_the_last_piece_all_is_run_however_long_it_was() -> None:
    chain, pieces, end = chained(LONG)
    for made in pieces:
        chain.tau(made.id, end)
    assert chain.tau(0, end + 0.5) == pytest.approx(end + 0.5)


def test_a_slow_move_of_two_minutes_is_still_one_law() -> None:
    _, pieces, end = chained(LONG.replace("speed=20", "speed=0.3"))
    assert end > 100.0 and len(pieces) < 900
