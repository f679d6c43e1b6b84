"""rho 3 option `Sinus*2-slope` (L5163): speed ramps whose acceleration is a sine square of the time, on paper and in a cell.  AX-575.

The closed form is judged by integrating the acceleration, the laws of blocks by the set values, the cell by the emulator's own record.
"""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from gateway.assembly.programs import machine_of_cell
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.arbitration.command_block import Code
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.cells.arms import Array, at, portal, robot, run, shares
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot
from motion.paths.joints import joint_line
from motion.planner.arm import Arm
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.planner.stretch import Kind
from motion.planner.trace import Trace, trace
from motion.program.blocks import Blend, Block, Interpolation, JointTarget, Rounding, Shape, Slope
from motion.program.errors import TextFaults
from motion.program.factors import Factors
from motion.program.slopes import earliest, overlap, ramped
from motion.program.text.reader import read
from motion.timing.sine_square import SineSquare, sine_square

CASES = [
    (0.3, 2.0, 20.0, 1e3),
    (0.01, 2.0, 20.0, 1e3),
    (1.5, 0.2, 20.0, 1e3),
    (0.05, 2.0, 20.0, 30.0),
    (3.0, 1.0, 2.0, 1e5),
    (1e-6, 1.0, 1.0, 1.0),
]
LINEAR = Interpolation.LINEAR
R20 = Blend(Rounding.CARTESIAN, 0.02, 0.02)
ARM = "angles val3\nstart 0 30 90 0 60 0\ntool g 0 0 100 0 0 0\nset tool=g {}\nptp pose 350 -150 200 180 0 0\n"
LINE, ARC = "linear pose 350 150 200 180 0 0 path=1500\n", "circular via pose 430 70 200 180 0 0 to pose 350 -150 200 180 0 0\n"
PATH = find_config("portal", "cells")
CELL = read_text(PATH).replace('by = "gateway", mode = 0', 'by = "none", mode = 0')


def made(machine: Machine, blocks: list[Block], start: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Trace:
    route = Route(machine, start)
    for block in blocks:
        route.add(block)
    route.finish()
    return trace(route.take(), machine)


def integrated(slope: SineSquare, t: Array) -> Array:
    """(n, 3) s, v, a out of A sin^2 alone, by Simpson's rule."""
    fine = np.linspace(0.0, slope.duration, 400_001)
    h = fine[1]

    def accel(x: Array) -> Array:
        up, down = x / slope.ramp, (slope.duration - x) / slope.ramp
        return slope.accel * (np.where(up < 1.0, np.sin(np.pi * up) ** 2, 0.0) - np.where(down < 1.0, np.sin(np.pi * down) ** 2, 0.0))

    middle = accel(fine[:-1] + 0.5 * h)
    v = np.concatenate([[0.0], np.cumsum((accel(fine)[:-1] + 4 * middle + accel(fine)[1:]) * h / 6)])
    s = np.concatenate([[0.0], np.cumsum(0.5 * h * (v[1:] + v[:-1]) - h * h * (accel(fine)[1:] - accel(fine)[:-1]) / 12)])
    return np.stack([np.interp(t, fine, s), np.interp(t, fine, v), accel(t)], axis=1)


@pytest.mark.parametrize("case", CASES)
def test_the_closed_form_is_the_integral_of_a_sine_square_within_its_limits(case: tuple[float, float, float, float]) -> None:
    length, speed, accel, jerk = case
    slope = sine_square(*case)
    t = np.linspace(0.0, slope.duration, 997)
    found, wanted = slope.states(t), integrated(slope, t)
    for column, size in enumerate((length, slope.speed, slope.accel)):
        assert float(np.abs(found[:, column] - wanted[:, column]).max()) < 2e-6 * size
    assert slope.speed <= speed * (1 + 1e-12) and slope.accel <= accel * (1 + 1e-12) and slope.jerk <= jerk * (1 + 1e-12)
    third = np.diff(slope.states(np.linspace(0.0, slope.ramp, 2001))[:, 2]) / slope.ramp * 2000
    assert float(np.abs(third).max()) == pytest.approx(slope.jerk, rel=1e-3), "pi A / T"
    assert max(slope.accel / accel, slope.jerk / jerk) == pytest.approx(1.0), "no longer a ramp than the limits ask for"


@pytest.mark.parametrize("case", CASES)
def test_no_other_speed_of_such_a_slope_is_quicker(case: tuple[float, float, float, float]) -> None:
    length, speed, accel, jerk = case
    best = sine_square(*case).duration
    for other in np.geomspace(1e-3, 1.0, 200) * speed:
        ramp = max(2 * other / accel, math.sqrt(2 * math.pi * other / jerk))
        if other * ramp <= length:
            assert SineSquare(length, float(other), ramp, ramp).duration >= best * (1 - 1e-9)


def test_a_block_between_exact_stops_follows_it_and_the_robots_default_is_the_same() -> None:
    machine, share = portal(), 0.3 / math.hypot(0.3, 0.04)  # X has the largest part of the way
    default = replace(machine, shape=Shape.SIN2)
    found = made(machine, [Block(LINEAR, at(300, 40), shape=Shape.SIN2), Block(LINEAR, at(250, 40), shape=Shape.SIN2)])
    slope = sine_square(math.hypot(0.3, 0.04), 2.0 / share, 20.0 / share, 1e3 / share)
    first = found.q[found.block == 1]
    assert np.linalg.norm(first[:, :2], axis=1) == pytest.approx(slope.way(np.arange(len(first), dtype=np.float64) * 1e-3), abs=1e-9)
    assert np.array_equal(made(default, [Block(LINEAR, at(300, 40)), Block(LINEAR, at(250, 40))]).q, found.q)
    plain = made(default, [Block(LINEAR, at(300, 40), shape=Shape.JERK)])
    assert plain.t[-1] < slope.duration - 0.02, "the jerk-limited one is quicker"


def test_lines_and_arcs_of_an_arm_keep_every_limit_and_the_speed_of_the_tool() -> None:
    machine = robot("tx60-like")
    program = read(ARM.format("shape=sin2") + LINE.replace("1500", "300") + ARC)
    found = made(machine, list(program.blocks), program.start)
    tops = [float(np.max(found.loads(machine, order))) for order in (1, 2, 3)]
    assert all(top <= most for top, most in zip(tops, (1.0, 1.01, 1.045), strict=True)) and max(tops) > 0.95, "and uses them"
    assert float(found.tool_speed()[found.block == 2].max()) == pytest.approx(0.3, abs=1e-4)


def test_one_ramp_up_and_one_down_on_a_curve() -> None:
    machine = robot("tx60-like")
    program = read(ARM.format("shape=sin2") + LINE)
    found = made(machine, list(program.blocks), program.start)
    speed = found.tool_speed()[found.block == 2]
    top, length = float(speed.max()), 0.3
    ramp = (np.count_nonzero(found.block == 2) - 1) * 1e-3 - length / top
    wanted = SineSquare(length, top, ramp, ramp).states(np.arange(len(speed), dtype=np.float64) * 1e-3)[:, 1]
    assert float(np.abs(speed - wanted).max()) < 0.01 * top


def test_blocks_with_block_slope_are_added_in_time_as_their_curve_was() -> None:
    machine = portal()
    points = [(0, 0, 50), (200, 0, 50), (200, 100, 50)]
    blocks = [Block(LINEAR, at(*point), blend=R20, slope=Slope.BLOCK, shape=Shape.SIN2) for point in points]
    route = Route(machine, (0.0, 0.0, 0.0))
    for block in blocks:
        route.add(block)
    route.finish()
    row = route.take()
    assert [stretch.kind for stretch in row].count(Kind.CORNER) == 2
    found = trace(row, machine)
    legs = [
        ramped(joint_line([1e-3 * v for v in a], [1e-3 * v for v in b]), machine.limits, sine=True)
        for a, b in pairwise([(0, 0, 0), *points])
    ]
    starts, q, t = [0.0], np.zeros((len(found.t), 3)), found.t
    for before, after in pairwise(legs):
        one = overlap(before, after, earliest(before, 0.02), machine.limits)
        assert one is not None
        starts.append(starts[-1] + one.start)
    for start, leg in zip(starts, legs, strict=True):
        q += leg.motion(t - start)[0]
    assert float(np.abs(found.q - q).max()) < 2e-5
    assert t[-1] == pytest.approx(starts[-1] + legs[-1].duration, abs=2e-3)
    assert [float(np.max(found.loads(machine, order))) <= 1.02 for order in (1, 2, 3)] == [True] * 3


def test_a_block_that_comes_late_leaves_no_ramp_begun_in_the_middle() -> None:
    """What is known of the first block is run to its rest; the sum with the second one begins there, where no block's own ramp does."""
    machine = robot("tx60-like")
    arm = Arm(machine, (0.0, 0.5, 1.5, 0.0, 1.0, 0.0))
    blend = Blend(Rounding.JOINT, axes=(0.2,) * 6)
    first, second = (0.1, 0.9, 1.2, 0.1, 0.6, -0.3), (-0.8, 0.4, 1.1, 0.1, 0.1, -0.8)
    blocks = [Block(Interpolation.PTP, JointTarget(end), blend=blend, slope=Slope.BLOCK, shape=Shape.SIN2) for end in (first, second)]
    arm.add(blocks[0])
    rows = [arm.joints, *(arm.step() for _ in range(14))]
    arm.add(blocks[1])
    arm.finish()
    found = np.concatenate([rows[:-1], run(arm)])
    assert found[-1] == pytest.approx(second, abs=1e-9)
    assert [top <= most for top, most in zip(shares(machine, found, 1e-3), (1.0, 1.02, 1.05), strict=True)] == [True] * 3


def test_points_passed_with_program_slope_have_the_jerk_limited_law() -> None:
    def seconds(shape: Shape) -> float:
        return float(
            made(portal(), [Block(LINEAR, at(100, 0, 50), blend=R20, shape=shape), Block(LINEAR, at(200, 100, 50), shape=shape)]).t[-1]
        )

    assert seconds(Shape.SIN2) == seconds(Shape.JERK)


def test_the_speed_factor_of_an_order_lowers_its_speed_as_any() -> None:
    planner = Planner(portal(), (0.0, 0.0, 0.0), factors=Factors(0.5, 1.0, 1.0))
    planner.add(Block(LINEAR, at(300), shape=Shape.SIN2))
    planner.finish()
    planner.plan(0.0, hurry=True)
    assert planner.end == pytest.approx(sine_square(0.3, 1.0, 20.0, 1e3).duration, abs=1e-6)


def test_text_and_cell_name_the_shapes_there_are() -> None:
    head = "axes mm mm mm\nstart 0 0 0\n"
    assert [
        block.shape for block in read(head + "linear pose 1 0 0 0 0 0 shape=sin2\nset shape=jerk\nlinear pose 2 0 0 0 0 0\n").blocks
    ] == [Shape.SIN2, Shape.JERK]
    for word, said in (("trapezoid", "steps the acceleration.*BAHN_ZEIT"), ("sine", "one of robot, jerk, sin2")):
        with pytest.raises(TextFaults, match=said):
            read(head + f"linear pose 1 0 0 0 0 0 shape={word}\n")
    assert machine_of_cell(load_cell(str(PATH), CELL.replace("[robot]\n", '[robot]\nshape = "sin2"\n'))).shape is Shape.SIN2
    assert machine_of_cell(load_cell(str(PATH), CELL)).shape is Shape.JERK
    with pytest.raises(CellFaults, match=r'shape = "trapezoid": allowed jerk \| sin2'):
        load_cell(str(PATH), CELL.replace("[robot]\n", '[robot]\nshape = "trapezoid"\n'))


@pytest.fixture(scope="module")
def planned() -> Planned:
    return Planned(ServodynRobot(cell=load_cell(str(PATH), CELL.replace("[robot]\n", '[robot]\nshape = "sin2"\n'))))


HEAD = "angles rho3\naxes mm mm mm deg\nstart 50 50 50 0\n"
AXIS = (0.8, 3.0, 30.0)  # of X


def sets(planned: Planned, target: float) -> Array:
    """(n,) m: X as it was set on the way there."""
    planned.bench.run(0.1)
    planned.driven()
    job = planned.order(f"{HEAD}linear pose {target} 50 50 0 0 0\n")
    assert planned.bench.settle(job).state is CommandState.DONE
    planned.bench.run(0.1)
    return planned.driven().sets[:, 0]


@pytest.mark.parametrize("override", [1.0, 0.5])
def test_the_set_values_of_a_cell_are_those_of_the_closed_form_also_at_a_steady_override(planned: Planned, override: float) -> None:
    sets(planned, 50.0)
    planned.done(Code.OVERRIDE, override)
    rows = sets(planned, 450.0) - 0.05
    planned.done(Code.OVERRIDE, 1.0)
    slope = sine_square(0.4, *AXIS)
    t = np.arange(len(rows)) * planned.bench.period_ns * 1e-9 * override
    away = [float(np.abs(rows - slope.way(np.clip(t - t[k], 0.0, None))).max()) for k in range(len(rows))]
    assert min(away) < 2e-6, "an increment is 1.2 um"
    accel = np.diff(rows, 2) / (planned.bench.period_ns * 1e-9) ** 2
    assert float(accel.max()) == pytest.approx(slope.accel * override**2, abs=2 * 1.3e-6 / (planned.bench.period_ns * 1e-9) ** 2)


def test_stop_and_resume_on_such_a_block_go_by_the_normal_law_within_all_limits(planned: Planned) -> None:
    sets(planned, 50.0)
    planned.bench.run(0.1)
    planned.driven()
    job = planned.order(f"{HEAD}linear pose 450 50 50 0 0 0\n")
    planned.until(lambda s: s.axes[0].set > 0.15)
    planned.done(Code.STOP)
    planned.until(lambda s: s.motion is Motion.STOPPED)
    stands = planned.state.axes[0].set
    assert 0.15 < stands < 0.45
    planned.done(Code.RESUME)
    assert planned.bench.settle(job).state is CommandState.DONE
    found = planned.driven()
    assert max(found.shares()) <= 1.02 and planned.state.axes[0].set == pytest.approx(0.45, abs=1e-9)
    assert float(np.abs(found.sets[:, 1:3] - 0.05).max()) < 2e-6, "on the path"
