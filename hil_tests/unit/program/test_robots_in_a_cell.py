"""A six-axis arm (CiA 402 drives) and a portal (SERVODYN): tool, frame, PTP, lines with corners, an arc; slowed down, stopped, resumed.

Judged by the emulator's own record, against geometry of the programmed points.
"""

import functools
import pathlib

import numpy as np
import pytest

from gateway.axes import limits_of
from gateway.config import load_cell
from gateway.pure.command_block import Code
from gateway.pure.reasons import CommandState
from gateway.pure.records import Motion
from hil_tests.lab.belt_bench import CELL as PORTAL
from hil_tests.lab.cell402bench import Cell402Bench
from hil_tests.lab.planned_bench import Driven, Planned, ServodynRobot, off_circle, off_segment
from motion.conventions import convention
from motion.frames import Pose

ARM = load_cell(str(pathlib.Path(__file__).parents[3] / "configs" / "cells" / "arm6.toml"))
HEADS = {
    "arm": "robot tx60-like\nangles val3\naxes deg deg deg deg deg deg\nstart 0 30 90 0 60 0\n",
    "portal": "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\n",
}
TOOLS = {"arm": (0, 0, 100, 0, 0, 0), "portal": (0, 0, -50, 0, 0, 0)}
FRAMES = {"arm": (350, 0, 200, 0, 0, 90), "portal": (300, 300, 100, 0, 0, 90)}
ANGLES = {"arm": ("180 0 0", "180 0 20"), "portal": ("0 0 0", "0 0 20")}
PROGRAM = """{head}tool gripper {tool}
frame table {frame}
set tool=gripper frame=table
ptp pose -60 0 0 {here}
set radius=12 path=400
linear pose -60 0 30 {here}
linear pose 60 0 30 {here}
linear pose 60 0 0 {here} blend=off
set radius=0
circular via pose 30 -30 0 {here} to pose 0 0 0 {there}
"""
A, A_UP, B_UP, B, END = (-0.06, 0, 0), (-0.06, 0, 0.03), (0.06, 0, 0.03), (0.06, 0, 0), (0, 0, 0)
CENTRE, RADIUS, ROUND = (0.03, 0, 0), 0.03, 0.012
MISSED = 0.1875 * 2.0**0.5 * ROUND  # motion.md F, corner blend
ROUNDED = 25e-6  # m: half an increment of each axis (2 to 4 urad at 0.7 m; 1 um)
FOLLOWED = 1e-3  # m: a position loop cuts corners and arcs by the square of its lag


def pose(robot: str, values: tuple[int, ...]) -> Pose:
    return convention("val3" if robot == "arm" else "rho3").pose(values)


@functools.cache
def run(robot: str) -> Driven:
    """Slowly to the long line, a stop there, the rest of the line faster and faster."""
    planned = Planned(Cell402Bench(cell=ARM) if robot == "arm" else ServodynRobot(cell=PORTAL))
    tool, frame = pose(robot, TOOLS[robot]), pose(robot, FRAMES[robot])
    planned.done(Code.OVERRIDE, 0.3)
    planned.driven()
    here, there = ANGLES[robot]
    words = {"tool": " ".join(map(str, TOOLS[robot])), "frame": " ".join(map(str, FRAMES[robot])), "here": here, "there": there}
    job = planned.order(PROGRAM.format(head=HEADS[robot], **words))

    def tip() -> tuple[float, float, float]:
        sets = tuple(axis.set for axis in planned.state.axes[: planned.machine.arm])
        return (frame.inverse() @ planned.machine.kinematics.forward(sets) @ tool).position

    planned.until(lambda s: s.piece > 0 and tip()[2] > 0.0299 and abs(tip()[0]) < 0.045)
    planned.done(Code.STOP)
    planned.until(lambda s: s.motion is Motion.STOPPED)
    stands = tip()
    planned.bench.run(0.3)
    assert tip() == stands
    planned.done(Code.OVERRIDE, 0.6)
    planned.done(Code.RESUME)
    planned.done(Code.OVERRIDE, 1.0)
    planned.bench.settle(job)
    assert job.state is CommandState.DONE
    planned.bench.run(0.3)
    return planned.driven()


@pytest.mark.parametrize("robot", ["arm", "portal"])
def test_the_tool_keeps_lines_corners_and_arc_through_a_slow_stretch_a_stop_and_the_rest_of_the_way(robot: str) -> None:
    made, tool, frame = run(robot), pose(robot, TOOLS[robot]), pose(robot, FRAMES[robot])
    places = made.places(made.sets, tool, frame)
    first = int(np.argmax(np.linalg.norm(places - A, axis=1) < ROUNDED))
    assert first > 20, "a PTP leads to the first point"
    path = places[first:]
    on = np.min([off_segment(path, *leg) for leg in ((A, A_UP), (A_UP, B_UP), (B_UP, B))] + [off_circle(path, CENTRE, RADIUS)], axis=0)
    near = [np.linalg.norm(path - corner, axis=1) for corner in (A_UP, B_UP)]
    beside = (near[0] > ROUND) & (near[1] > ROUND)
    assert float(on[beside].max()) < ROUNDED
    for distance in near:
        assert 0.2 * MISSED < float(distance.min()) <= MISSED + ROUNDED
    assert float(on.max()) < MISSED
    for place in (A, B, END):
        assert float(np.linalg.norm(path - place, axis=1).min()) < ROUNDED, "where nothing is rounded the point itself is reached"
    went = made.places(made.actual[first:], tool, frame)
    away = np.array([np.linalg.norm(path - place, axis=1).min() for place in went])
    assert float(away.max()) < FOLLOWED, "the mechanics follow"


@pytest.mark.parametrize("robot", ["arm", "portal"])
def test_no_axis_is_beyond_its_limits_and_all_arrive(robot: str) -> None:
    made = run(robot)
    speed, accel = made.shares()
    assert 0.1 < speed <= 1.0 and 0.2 < accel <= 1.02
    spans = zip([limits_of(axis) for axis in made.axes], made.actual.min(0), made.actual.max(0), strict=True)
    assert all(axis.lower <= low and high <= axis.upper for axis, low, high in spans)
    end = made.places(made.actual[-1:], pose(robot, TOOLS[robot]), pose(robot, FRAMES[robot]))
    assert float(np.linalg.norm(end[0] - END)) < 1e-4, "where the program ends the mechanics stand"
