"""What of a program cannot be run is told before anything moves: the manual's number, the block that is to blame, the axis."""

from itertools import pairwise

import numpy as np
import pytest

from gateway.motionpaper import sections_of
from hil_tests.lab import arms
from motion.errors import MotionError
from motion.limits import limits_from
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.program.blocks import Block, Curving, Interpolation, PoseTarget, Tool
from motion.program.errors import BlockError
from motion.program.text import read

ARM = """
angles val3
start 0 30 90 0 60 0
tool g 0 0 100 0 0 0
point A pose 350 -150 200 180 0 0
set tool=g
ptp A
"""
PORTAL = Machine(
    arms.portal().kinematics, (*arms.portal().limits, limits_from("E1", "mm", lower=0, upper=1000, speed=500, accel=5000, jerk=200_000))
)
ZIGZAG = [(4.0 * k, 3.0 * (k % 7 == 3)) for k in range(1, 15)]  # mm


def faults(blocks: str, text: str = ARM, robot: str = "tx60-like") -> list[tuple[int, str, int]]:
    """(block, axis, number) of everything that cannot be run, as `motion check` finds it."""
    found = sections_of(read(text + blocks), arms.robot(robot), ())[1]
    return [(fault.block, fault.axis, fault.code) for fault in found]


def splined(points: list[tuple[float, float]], **curving: float) -> np.ndarray:
    """(n, 4) m: the axes along a row of SPLINE blocks; the additional axis moves with the square of the point's number."""
    route = Route(PORTAL, (0.0, 0.0, 0.0, 0.0))
    for k, (x, y) in enumerate(points, 1):
        target = PoseTarget(arms.at(x, y).pose, extra=(1e-3 * k * k,))
        route.add(Block(Interpolation.SPLINE, target, curving=Curving(**curving)))
    route.finish()
    paths = [stretch.path for stretch in route.take()]
    return np.vstack([path.at(np.linspace(0.0, path.length, 41))[:, :4] for path in paths])


def test_a_row_of_splines_blames_its_own_block_and_the_blocks_behind_it_are_still_looked_at() -> None:
    row = "spline pose 350 -100 210 180 0 0\nspline A\nspline A\nlinear pose 350 -50 200 180 0 0\nlinear pose 1500 0 200 180 0 0\n"
    assert faults(row) == [(4, "", 620), (6, "", 530)]
    weights = "spline pose 350 0 210 180 0 0 weight=0\nspline pose 350 50 190 180 0 0 weight=0\nspline A\nptp joints 0 0 0 0 0 300\n"
    assert faults(weights) == [(3, "", 903), (5, "J6", 520)]
    assert faults("spline pose 350 0 200 180 0 0\nspline pose 350 50 200 180 0 0 config=enegative\n") == [(3, "", 533)]


def test_after_a_row_that_cannot_be_run_the_arm_stands_where_the_row_began() -> None:
    route = Route(arms.portal(), (0.0, 0.0, 0.0))
    for x in (10.0, 10.0):
        route.add(Block(Interpolation.SPLINE, arms.at(x)))
    with pytest.raises(BlockError, match="block 2: points 1 and 2 of the spline are the same") as caught:
        route.add(Block(Interpolation.LINEAR, arms.at(50.0)))
    assert caught.value.code == 620 and route.standing == (0.0, 0.0, 0.0) and not route.pending
    route.add(Block(Interpolation.LINEAR, arms.at(50.0)))
    assert [stretch.block for stretch in route.take()] == [3]


def test_a_straight_block_to_axis_positions_leads_exactly_there_or_is_refused() -> None:
    assert faults("linear joints 0 40 300 0 50 0\n") == [(2, "J3", 520)]
    assert faults("ptp joints 0 30 90 0 60 0\nlinear joints 0 30 90 0 60 200\n") == [(3, "J6", 533)], "the short way is -160"
    assert faults("ptp joints 0 30 90 0 60 0\nlinear joints 0 35 85 0 60 10\n") == []


def test_a_configuration_cannot_be_forced_by_a_block_without_way_either() -> None:
    assert faults("linear A config=enegative\nlinear A config=epositive\nlinear A\n") == [(2, "", 533)]


def test_a_start_outside_the_travel_is_named_as_such() -> None:
    start = "angles rho3\naxes mm mm mm deg\nstart -9999 10 5 0\n"
    found = sections_of(read(start + "ptp joints 10 10 5 0\n"), arms.robot("portal"), ())[1]
    assert str(found[0]) == "block 1, axis X: the path begins at -9999 mm, outside -50 .. 1500 mm (VAL 3 520)"


def test_dense_points_are_run_inside_a_tube_that_the_block_asks_for() -> None:
    def leaves(rows: np.ndarray) -> float:
        """How far the path is from the straight lines through the points, m."""
        ends = 1e-3 * np.array([(0.0, 0.0), *ZIGZAG])
        worst = np.full(len(rows), np.inf)
        for a, b in pairwise(ends):
            share = np.clip((rows[:, :2] - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
            worst = np.minimum(worst, np.linalg.norm(rows[:, :2] - a - share[:, None] * (b - a), axis=1))
        return float(worst.max())

    assert leaves(splined(ZIGZAG)) > 60e-6
    assert leaves(splined(ZIGZAG, tube=50e-6)) <= 50e-6 + 1e-9
    with pytest.raises(MotionError, match=r"block 1: no smooth curve stays within 0\.0001 mm") as caught:
        splined(ZIGZAG, tube=1e-7)
    assert isinstance(caught.value, BlockError)


def test_an_additional_axis_goes_along_a_spline_without_a_jump_of_its_speed() -> None:
    rows = splined([(20.0 * k, 5.0 * (k % 2)) for k in range(1, 6)])
    assert rows[[40, 81, 122, 163, 204], 3] == pytest.approx([1e-3 * k * k for k in range(1, 6)], abs=1e-9)
    slopes = np.diff(rows[:, 3]) / 0.5e-3
    joined = [(slopes[n - 2], slopes[n]) for n in (41, 82, 123, 164)]  # last of one block, first of the next
    assert all(abs(before - after) < 0.05 * abs(before) for before, after in joined)


def test_another_tool_ends_a_row_of_splines_and_nothing_jumps() -> None:
    route = Route(arms.portal(), (0.0, 0.0, 0.0))
    long = Tool("long", arms.at(0.0, 0.0, 30.0).pose)
    for x, tool in ((10.0, Tool()), (20.0, Tool()), (30.0, long), (40.0, long)):
        route.add(Block(Interpolation.SPLINE, arms.at(x), tool=tool))
    route.finish()
    stretches = route.take()
    assert [stretch.stop for stretch in stretches] == [False, True, False, True]
    for one, other in pairwise(stretches):
        assert one.path.q(one.path.length) == pytest.approx(other.path.q(0.0), abs=1e-9)
