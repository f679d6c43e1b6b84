"""A program with tool, frame, PTP, lines with corners and an arc, and the judge of its way: geometry of the programmed points alone."""

import numpy as np

from hil_tests.lab.cells.arms import Array
from hil_tests.lab.virtual.planned_bench import Driven, off_circle, off_segment
from motion.geometry.conventions import convention
from motion.geometry.frames import Pose

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


def places_of(robot: str) -> tuple[Pose, Pose]:
    """Tool and frame."""
    return pose(robot, TOOLS[robot]), pose(robot, FRAMES[robot])


def program(robot: str) -> str:
    here, there = ANGLES[robot]
    words = {"tool": " ".join(map(str, TOOLS[robot])), "frame": " ".join(map(str, FRAMES[robot])), "here": here, "there": there}
    return PROGRAM.format(head=HEADS[robot], **words)


def judge_path(made: Driven, robot: str) -> None:
    """By set values and mechanics of the emulator's record."""
    tool, frame = places_of(robot)
    places = made.places(made.sets, tool, frame)
    first = int(np.argmax(np.linalg.norm(places - A, axis=1) < ROUNDED))
    assert first > 20, "a PTP leads to the first point"
    path = places[first:]
    on: Array = np.min(
        [off_segment(path, *leg) for leg in ((A, A_UP), (A_UP, B_UP), (B_UP, B))] + [off_circle(path, CENTRE, RADIUS)], axis=0
    )
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


def judge_limits(made: Driven) -> None:
    """Of speed and acceleration; every SYNC has to be there."""
    speed, accel = made.shares()
    assert 0.1 < speed <= 1.0 and 0.2 < accel <= 1.02, (speed, accel)


def judge_end(made: Driven, robot: str, limits: list[tuple[float, float]]) -> None:
    """limits: lower and upper of every axis."""
    spans = zip(limits, made.actual.min(0), made.actual.max(0), strict=True)
    assert all(lower <= low and high <= upper for (lower, upper), low, high in spans)
    end = made.places(made.actual[-1:], *places_of(robot))
    assert float(np.linalg.norm(end[0] - END)) < 1e-4, "where the program ends the mechanics stand"
