"""Rows of block slope with sine squares whose tool or axes are limited by their blocks (AX-600), and corners in which the axes nearly
stand (AX-601): judged by set values at 1 ms, and by the other robot's kinematics in the lab."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hil_tests.lab.cells.arms import Array, at, portal, robot, run, shares
from hil_tests.lab.judges import pinned
from hil_tests.lab.judges.tool_speed import excess
from motion.geometry.frames import Pose
from motion.planner.arm import Arm
from motion.planner.quick_law import swift, width_s
from motion.planner.robot import Machine
from motion.planner.route import Route
from motion.planner.runs import make_run
from motion.planner.stretch import Kind, Stretch
from motion.planner.trace import Trace, trace
from motion.program.blocks import Blend, Block, Interpolation, JointTarget, Pace, PoseTarget, Rounding, Shape, Slope
from motion.timing.jerk import shares as judged

LINEAR, PTP = Interpolation.LINEAR, Interpolation.PTP
R20 = Blend(Rounding.CARTESIAN, 0.02, 0.02)
MOST = (1.0 + 1e-6, 1.02, 1.05)
START = (0.0, 0.5, 1.5, 0.0, 1.0, 0.0)


def row(machine: Machine, start: tuple[float, ...], blocks: list[Block]) -> list[Stretch]:
    route = Route(machine, start)
    for block in blocks:
        route.add(block)
    route.finish()
    return route.take()


def corners(stretches: list[Stretch]) -> int:
    return [stretch.kind for stretch in stretches].count(Kind.CORNER)


def lines(*paces: Pace) -> list[Block]:
    """A right angle of two lines of 200 mm."""
    targets = (at(200), at(200, 200))
    return [Block(LINEAR, t, pace=p, blend=R20, slope=Slope.BLOCK, shape=Shape.SIN2) for t, p in zip(targets, paces, strict=True)]


def whole(machine: Machine, start: tuple[float, ...], blocks: list[Block]) -> Trace:
    return trace(row(machine, start, blocks), machine)


def good(machine: Machine, q: Array) -> bool:
    return all(top <= most for top, most in zip(shares(machine, q, 1e-3), MOST, strict=True))


FAST, SLOW, HALF = Pace(path_speed=1.5), Pace(path_speed=0.1), Pace(path_speed=0.4)


@pytest.mark.parametrize(
    "paces",
    [
        (FAST, SLOW),
        (SLOW, FAST),
        (HALF, HALF),
        (Pace(), Pace(speed=0.2)),
        (replace(HALF, path_accel=2.0, path_decel=2.0), replace(HALF, path_accel=1.0, path_decel=1.0)),
    ],
)
def test_a_row_never_takes_longer_than_its_blocks_one_by_one_and_keeps_what_they_ask(paces: tuple[Pace, Pace]) -> None:
    """Each block's own pace, not the slowest of all, is what it runs at; only the start of the second is delayed."""
    machine, start = portal(), (0.0, 0.0, 0.0)
    blocks = lines(*paces)
    stretches = row(machine, start, blocks)
    found = trace(stretches, machine)
    stopped = whole(machine, start, [replace(block, blend=Blend()) for block in blocks])
    assert corners(stretches) == 1
    assert found.t[-1] < stopped.t[-1] - 0.005, "passing the point saves time"
    assert good(machine, found.q)
    speed, _, accel = excess(blocks, machine.forward, found.q, [int(b) for b in found.block])
    assert speed <= 1.001 and accel <= 1.03


def test_lines_without_a_limit_of_the_tool_overlap_as_before() -> None:
    curve = next(s for s in row(portal(), (0.0, 0.0, 0.0), lines(Pace(), Pace())) if s.kind is Kind.CORNER)
    limited = next(s for s in row(portal(), (0.0, 0.0, 0.0), lines(FAST, SLOW)) if s.kind is Kind.CORNER)
    assert curve.path.length > 2 * limited.path.length, "the sum of a fast and a slow line is delayed"


def test_an_arm_of_six_axes_keeps_the_speed_of_its_tool_in_the_sum() -> None:
    machine, ends = robot("tx60-like"), ((0.6, 0.8, 1.2, 0.3, 0.8, 0.2), (0.9, 0.2, 1.0, 0.6, 0.5, 0.9), (0.2, 0.4, 1.3, 0.1, 0.9, 0.3))
    blend = Blend(Rounding.JOINT, axes=(0.2,) * 6)
    blocks = [
        Block(PTP, JointTarget(end), pace=Pace(path_speed=v), blend=blend, slope=Slope.BLOCK, shape=Shape.SIN2)
        for end, v in zip(ends, (1.5, 0.2, 0.8), strict=True)
    ]
    found = whole(machine, START, blocks)
    stopped = whole(machine, START, [replace(block, blend=Blend()) for block in blocks])
    assert found.t[-1] < stopped.t[-1] and good(machine, found.q)
    assert excess(blocks, pinned.tx60().forward, found.q, [int(b) for b in found.block])[0] <= 1.001


def test_a_point_where_the_axes_turn_back_is_not_passed_in_a_bend_of_a_tenth_of_a_millimetre() -> None:
    """Their sum would keep the limits only where both nearly stand; a law of its own along that bend took for ever, or left the limits."""
    machine = robot("tx60-like")
    ends = ((0.279, 0.641, 1.392, -0.287, 0.993, -0.181), (0.305, 0.661, 1.421, -0.327, 0.948, -0.141))
    blend = Blend(Rounding.JOINT, 0.06, 0.12)
    paces = (Pace(), Pace(path_speed=0.4, turn_speed=0.5))
    blocks = [
        Block(PTP, JointTarget(end), pace=pace, blend=blend, slope=Slope.BLOCK, shape=Shape.SIN2)
        for end, pace in zip(ends, paces, strict=True)
    ]
    assert corners(row(machine, START, blocks)) == 0
    arm = Arm(machine, START)
    arm.add(blocks[0])
    rows = [arm.joints, *(arm.step() for _ in range(14))]
    arm.add(blocks[1])
    arm.finish()
    found = np.concatenate([rows[:-1], run(arm)])
    assert good(machine, found) and len(found) < 500
    assert found[-1] == pytest.approx(ends[1], abs=1e-9)


@pytest.mark.parametrize(("angle", "radius"), [(0.02, 1e-4), (0.3, 5e-5), (math.pi / 2, 2e-5)])
def test_the_quick_law_of_an_open_path_slows_down_for_a_corner_smaller_than_its_grid(angle: float, radius: float) -> None:
    machine, route = portal(), Route(portal(), (0.0, 0.0, 0.0))
    blend = Blend(Rounding.CARTESIAN, radius, radius)
    route.add(Block(LINEAR, at(100), blend=blend))
    route.add(Block(LINEAR, at(100 + 300 * math.cos(angle), 300 * math.sin(angle)), blend=R20))
    found = make_run(route.take(), machine)
    law = swift(found.path, found.limits, width_s(found.limits)).law
    assert [top <= most for top, most in zip(judged(found.path, found.limits, law), MOST, strict=True)] == [True] * 3


def test_a_law_planned_again_never_comes_to_stand_at_a_corner() -> None:
    """At this one, planned again with less of the jerk limit, the law crept for 77 s where the two blocks take 0.8 s one by one."""
    machine, start = robot("sr60-like"), (0.0, 1.5, -0.1, 0.0)
    first, second = (0.015, 1.540, -0.104, -0.003), (0.401, 0.225, 0.243)
    fast = Pace(speed=0.3, path_speed=1.5, turn_speed=2.0, lead=True)
    blend = Blend(Rounding.JOINT, 0.005, 0.005, past_circles=True)
    there = PoseTarget(Pose(second, machine.forward(first).rotation))
    blocks = [
        Block(PTP, JointTarget(first), pace=fast, blend=blend, slope=Slope.BLOCK),
        Block(LINEAR, there, pace=Pace(speed=0.3, path_speed=0.1), slope=Slope.BLOCK),
    ]
    found = whole(machine, start, blocks)
    stopped = whole(machine, start, [replace(block, blend=Blend()) for block in blocks])
    assert found.t[-1] < 1.5 * stopped.t[-1] and good(machine, found.q)
