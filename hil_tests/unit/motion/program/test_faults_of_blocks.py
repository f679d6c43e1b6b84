"""What of a program cannot be run is told before anything moves: the manual's number, the block that is to blame, the axis."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from gateway.assembly.programs import machine_of_cell
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.tools.motion.dry_run import sections_of
from hil_tests.lab.cells import arms
from motion.errors import MotionError
from motion.geometry.limits import limits_from
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.program.blocks import Block, Curving, Interpolation, PoseTarget, Tool
from motion.program.errors import BlockError
from motion.program.text.reader import read
from motion.timing.limiter import TooFast

ARM = """
angles val3
start 0 30 90 0 60 0
tool g 0 0 100 0 0 0
point A pose 350 -150 200 180 0 0
set tool=g
ptp A
"""
PATH = find_config("portal", "cells")
CELL = read_text(PATH).replace("[robot]\n", '[robot]\ntoo_fast = "abort"\n')
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
    assert caught.value.code == 620 and route.position == (0.0, 0.0, 0.0) and not route.pending
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
    inside = splined(ZIGZAG, tube=50e-6)
    assert leaves(inside) <= 50e-6 + 1e-9
    assert inside[40::41, 3] == pytest.approx([1e-3 * k * k for k in range(1, 15)], abs=1e-9), "beside the points its blocks end"
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


def test_the_tool_stays_inside_its_working_range_on_the_way_as_at_the_end() -> None:
    box = "set limitmin=100,-400,150 limitmax=420,400,400\n"
    assert faults(box + "linear pose 350 150 149.9 180 0 0\nlinear pose 350 150 150 180 0 0\n") == [(2, "", 532)]
    over = "circular via pose {} 0 200 180 0 0 to pose 350 150 200 180 0 0\n"
    assert faults(box + over.format(421) + over.format(419)) == [(2, "", 532)], "both end inside"
    assert faults(box + "spline pose 415 0 200 180 0 0\nspline A\n") == []
    assert faults(box + "spline pose 421 0 200 180 0 0\nspline A\n") == [(2, "", 532)]
    assert faults(box + "ptp pose 350 150 149 180 0 0 limitmin=-\nptp pose 350 150 149 180 0 0\nptp A\n") == []
    assert faults("ptp pose 350 150 149 180 0 0\n" + box + "ptp pose 350 150 149 180 0 1\nlinear A\n") == [(3, "", 532)]
    moved = "frame up 0 0 60 0 0 0\n" + box + "linear A\nlinear pose 350 -150 150 180 0 0 frame=up\n"
    assert faults(moved) == [], "z 210 of the base is 150 of the frame"
    assert faults(moved + "linear pose 350 -150 149 180 0 0 frame=up\n") == [(4, "", 532)]


@pytest.mark.requirement("RHO-MOT-45", by="motion.planner.path_checks:check_speed")
def test_an_axis_the_programmed_speed_asks_too_much_of_is_an_error_before_anything_moves_where_that_is_wanted() -> None:
    robot = arms.robot("tx60-like")

    def fault(path: float, too_fast: TooFast) -> BlockError | None:
        text = f"{ARM}linear pose 350 150 200 180 0 0 path={path}\n"
        found = sections_of(read(text), replace(robot, too_fast=too_fast), ())[1]
        return found[0] if found else None

    assert fault(20_000.0, TooFast.SLOW) is None, "it is run as fast as the axes can"
    abort, error = fault(20_000.0, TooFast.ABORT), fault(20_000.0, TooFast.ERROR)
    assert abort is not None and error is not None
    assert (abort.block, abort.code, abort.source) == (2, 0, "rho 3") and abort.what.startswith("Ax-Velocity exceeded")
    assert (error.block, error.code, error.source) == (2, 540, "VAL 3") and error.axis == abort.axis == "J1"
    told = re.search(r"([0-9.]+) times its speed", abort.what)
    assert told is not None
    most = 20_000.0 / float(told[1])  # mm/s
    assert fault(0.99 * most, TooFast.ABORT) is None and fault(1.01 * most, TooFast.ABORT) is not None


def test_a_cell_says_what_becomes_of_a_path_that_is_too_fast() -> None:
    assert machine_of_cell(load_cell(str(PATH), CELL)).too_fast is TooFast.ABORT
    assert machine_of_cell(load_cell(str(PATH), CELL.replace('"abort"', '"slow"'))).too_fast is TooFast.SLOW


def test_a_circle_goes_on_round_and_up_where_its_angle_says_so() -> None:
    route = Route(arms.portal(), (0.1, 0.0, 0.0))
    around = Block(Interpolation.CIRCULAR, arms.at(-100.0), arms.at(0.0, 100.0), angle=4.5 * np.pi, rise=0.045)
    route.add(around)
    (found,) = route.take()
    s = np.linspace(0.0, found.path.length, 451)
    turn = 4.5 * np.pi * s / found.path.length
    wanted = np.stack([0.1 * np.cos(turn), 0.1 * np.sin(turn), 0.045 * s / found.path.length], axis=1)
    assert np.abs(found.path.at(s)[:, :3] - wanted).max() < 1e-8
    assert route.position == pytest.approx((0.0, 0.1, 0.045), abs=1e-9)
    route.add(replace(around, target=arms.at(0.0, -100.0, 45.0), via=arms.at(100.0, 0.0, 45.0), angle=2 * np.pi, rise=0.0))
    assert route.position == pytest.approx((0.0, 0.1, 0.045), abs=1e-9), "a full circle"
    for wrong, code in (
        ({"angle": -1.0}, 552),
        ({"angle": np.nan}, 154),
        ({"rise": np.inf}, 154),
        ({"via": arms.at(0.0, 100.0, 45.0)}, 552),
    ):
        with pytest.raises(BlockError) as caught:
            route.add(replace(around, **wrong))
        assert caught.value.code == code
    near = "circular via pose 430 -70 200 180 0 0 to pose 350 10 200 180 0 0 angle={} rise=20 turning=path\n"
    assert faults(near.format(360)) == []
    assert [block for block, _, _ in faults(near.format(3600))] == [2], "no axis turns ten times"
