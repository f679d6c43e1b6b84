"""Per corner the faster of passing and exact stop, in what the planner hands on (motion.md 0.9, goal 6)."""

import functools
import math

import pytest

from hil_tests.lab.cells import arms
from hil_tests.lab.cells.motion_paths import POINTING_DOWN, u_points
from motion.planner.planner import Planner
from motion.program.blocks import Blend, Block, Interpolation, PoseTarget, Program, Rounding

PLACE = (0.35, 0.0, 0.3)


@functools.cache
def u_of(radius: float) -> Program:
    """25 mm up, 300 mm across, 25 mm down with the six-axis arm, all LINEAR."""
    machine = arms.robot("tx60-like")
    poses = u_points(POINTING_DOWN, PLACE, along=1)
    start = machine.kinematics.inverse(poses[0], (math.atan2(-0.15, PLACE[0]), 0.5, 1.2, 0.0, 1.0, 0.0))
    blend = Blend(Rounding.CARTESIAN, radius, radius) if radius else Blend()
    blocks = [Block(Interpolation.LINEAR, PoseTarget(pose), blend=blend) for pose in poses[1:]]
    return Program("u", "tx60-like", start, tuple(blocks))


@functools.cache
def planned(radius: float) -> tuple[float, int]:
    """(seconds, runs from rest to rest) of the pieces."""
    program = u_of(radius)
    planner = Planner(arms.robot("tx60-like"), program.start)
    for block in program.blocks:
        planner.add(block)
    planner.finish()
    pieces = [piece for _ in range(4) for piece in planner.plan(planner.end, hurry=True)]
    assert pieces[-1].ends_at_rest and not planner.open
    return sum(piece.duration for piece in pieces), sum(piece.ends_at_rest for piece in pieces)


@pytest.mark.parametrize("radius", [0.002, 0.02499])
def test_passing_is_never_slower_than_exact_stops(radius: float) -> None:
    assert planned(radius)[0] <= planned(0.0)[0] * (1 + 1e-9)
    assert planned(0.0)[1] == 3


def test_a_small_corner_that_costs_time_is_driven_out_and_large_ones_are_passed() -> None:
    assert planned(0.002)[1] > 1, "the axes rest in at least one of both corners"
    assert planned(0.02499)[1] == 1
    assert planned(0.02499)[0] < 0.95 * planned(0.0)[0]


def test_a_run_that_follows_another_begins_after_a_rest_so_their_jerks_do_not_add_up() -> None:
    machine = arms.portal()
    planner = Planner(machine, (0.0, 0.0, 0.0))
    for x in (30.0, 0.0):
        planner.add(Block(Interpolation.LINEAR, arms.at(x)))
    pieces = planner.plan(0.0, hurry=True)
    second = next(k for k, piece in enumerate(pieces) if piece.block == 2)
    assert pieces[second - 1].ends_at_rest
    still = [node for node, time in zip(pieces[second].nodes, pieces[second].times, strict=True) if time <= 0.9e-3]
    assert len(still) >= 1 and all(node == pieces[second].nodes[0] for node in still)
    assert pieces[second].times[1] >= 0.5e-3 and pieces[second].nodes[1] == pieces[second].nodes[0]
    assert pieces[0].nodes[1] != pieces[0].nodes[0], "the first one begins at once"
