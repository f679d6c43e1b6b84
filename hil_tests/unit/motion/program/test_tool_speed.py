"""The tool is never faster than programmed: in corners, on arcs and splines, turning, and where a slow block follows a fast one."""

import math
import random

import numpy as np
import pytest

from hil_tests.lab.cells.arms import Array, at, differences, portal, robot, shares
from hil_tests.lab.judges.tool_speed import driven, excess, random_blocks, sampled
from motion.planner.arm import Arm
from motion.program.blocks import Blend, Block, Interpolation, Pace, PoseTarget, Rounding
from motion.program.text.reader import read

HEADS = {
    "portal": ("robot portal\nangles rho3\naxes mm mm mm deg\nstart 200 200 50 0\n", "pose {} {} {} 0 0 {}", (200, 200, 50)),
    "tx60-like": (
        "robot tx60-like\nangles val3\naxes deg deg deg deg deg deg\nstart 0 30 90 0 60 0\ntool g 20 0 100 0 0 0\nset tool=g\n"
        "ptp pose 350 -150 200 180 0 0\n",
        "pose {} {} {} 180 0 {}",
        (350, -150, 200),
    ),
    "sr60-like": (
        "robot sr60-like\nangles rho3\naxes deg deg mm deg\nstart 0 90 -200 0\nptp pose 350 -150 80 180 0 0\n",
        "pose {} {} {} 180 0 {}",
        (350, -150, 80),
    ),
    "tx60-on-track": (
        "robot tx60-on-track\nangles val3\naxes deg deg deg deg deg deg mm deg\nstart 0 30 90 0 60 0 500 0\ntool g 0 0 100 0 0 0\n"
        "set tool=g\nptp pose 400 500 300 180 0 0 extra=510mm,5deg\n",
        "pose {} {} {} 180 0 {}",
        (400, 500, 300),
    ),
}
KINDS = {
    "corners": "set path=300 radius=20\nlinear {0}\nlinear {1}\nlinear {2}\nlinear {3} blend=off\n",
    "turning corners": "set path=300 turn=60 radius=20\nlinear {0}\nlinear {4}\nlinear {5}\nlinear {3} blend=off\n",
    "arcs": "set path=250 radius=15 arcs=yes\nlinear {6}\ncircular via {7} to {1}\nlinear {2}\nlinear {3} blend=off\n",
    "spline": "set path=250 turn=40\nspline {6}\nspline {4}\nspline {5}\nspline {3}\n",
    "slow and fast": "set radius=20\nlinear {0} path=300\nlinear {1} path=100\nlinear {2} path=300\nlinear {3} path=50 blend=off\n",
    "acceleration": "set path=300 pathaccel=1000 pathdecel=1000 radius=20\nlinear {0}\nlinear {1}\nlinear {2}\nlinear {3} blend=off\n",
}


def text(name: str, kind: str) -> str:
    head, pose, (x, y, z) = HEADS[name]
    places = (
        (0, 0, 25, 0),
        (80, 0, 25, 0),
        (80, 60, 25, 0),
        (0, 60, 25, 0),
        (80, 0, 25, 60),
        (80, 60, 25, -30),
        (50, 20, 25, 0),
        (100, 30, 25, 0),
    )
    return head + KINDS[kind].format(*(pose.format(x + a, y + b, z + c, w) for a, b, c, w in places))


CASES = [("portal", kind) for kind in KINDS] + [("tx60-like", "turning corners"), ("tx60-like", "spline"), ("sr60-like", "turning corners")]


@pytest.mark.parametrize(("name", "kind"), CASES)
def test_speed_turning_and_acceleration_of_the_tool_are_those_programmed(name: str, kind: str) -> None:
    speed, turn, accel = sampled(read(text(name, kind)))
    assert 0.9 < max(speed, turn) <= 1.001 and speed <= 1.001 and turn <= 1.001
    assert accel <= 1.02


def test_of_a_carried_robot_it_is_the_speed_over_what_counts() -> None:
    speed, turn, _ = sampled(read(text("tx60-on-track", "turning corners")))
    assert 0.9 < max(speed, turn) <= 1.001 and speed <= 1.001 and turn <= 1.001


@pytest.mark.parametrize("kind", ("corners", "slow and fast", "acceleration"))
def test_blocks_that_come_one_by_one_are_no_faster(kind: str) -> None:
    """The law of a path that goes on is a mean over time: it must not carry speed into a slow block."""
    speed, _, accel = driven(read(text("portal", kind)), ahead=3)
    assert 0.9 < speed <= 1.001 and accel <= 1.02


@pytest.mark.parametrize("seed", (5, 8))
def test_blocks_that_come_late_are_no_faster_and_never_lost(seed: int) -> None:
    """What cannot be entered any more is begun from rest, where the blocks before it end."""
    dice = random.Random(seed)
    machine = portal(speed=1500, accel=8000, jerk=2e5) if seed % 2 == 0 else portal()
    blocks = random_blocks(dice)
    arm, left = Arm(machine, (0.0, 0.0, 0.0)), list(blocks)
    ahead, rows, numbers = dice.choice((1, 2, 3)), [arm.joints], [1]
    while left or not (arm.place().waiting == 0 and arm.resting):
        if left and arm.planner.waiting <= ahead and dice.random() < 0.05:
            arm.add(left.pop(0))
            if not left:
                arm.finish()
        rows.append(arm.step())
        numbers.append(arm.place().block)
        assert len(rows) < 30_000
    q = np.array(rows)
    assert excess(blocks, machine.forward, q, numbers)[0] <= 1.001
    target = blocks[-1].target
    assert isinstance(target, PoseTarget) and math.dist(q[-1], target.pose.position) < 1e-9
    speed, accel, jerk = shares(machine, q, 1e-3)
    assert speed <= 1.0 and accel <= 1.02 and jerk <= 1.10


def test_what_the_law_keeps_is_not_slower_than_it_has_to_be() -> None:
    """A quarter of a circle's worth of corner at 300 mm/s: the tool has its speed inside the corner, too."""
    machine = robot("portal")
    start = (0.2, 0.2, 0.05, 0.0)
    arm = Arm(machine, start)
    for x, y, z in ((200, 200, 250), (500, 200, 250)):
        arm.add(Block(Interpolation.LINEAR, at(x, y, z), pace=Pace(path_speed=0.1), blend=Blend(Rounding.CARTESIAN, 0.05, 0.05)))
    arm.finish()
    rows: list[tuple[float, ...]] = [arm.joints]
    while not (arm.place().waiting == 0 and arm.resting):
        rows.append(arm.step())
    speed: Array = np.linalg.norm(differences(np.array(rows)[:, :3], 1e-3, 1), axis=1)
    ramp = 300
    assert 0.0999 <= float(speed[ramp:-ramp].min()) <= float(speed.max()) <= 0.1001
