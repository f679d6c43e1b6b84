"""path= and turn= of PTP blocks, tvel and rvel of a movej: the tool keeps them on its curve, in passed points, at every override.

VAL 3 10.3.1 (L5635-5644, L5701-5705): at every moment the arm moves as hard as its joints and the tool's speeds allow.  The judge is
pinocchio's forward kinematics and the set values at 1 ms.
"""

import math
import random
from dataclasses import replace

import numpy as np
import pytest

from hil_tests.lab.cells.arms import robot, run
from hil_tests.lab.judges import pinned
from hil_tests.lab.judges.tool_speed import excess, sampled
from motion.geometry.frames import translation
from motion.paths.joints import joint_line
from motion.planner.arm import Arm
from motion.planner.trace import route_of, trace
from motion.program.blocks import Block, Interpolation, JointTarget, Tool
from motion.program.text.reader import read
from motion.val3.mdesc import BlendKind, Mdesc
from motion.val3.stack import MotionStack

ARM = "robot tx60-like\nangles val3\naxes deg deg deg deg deg deg\nstart 0 30 90 0 60 0\ntool g 20 0 100 0 0 0\nset tool=g\n"
SCARA = "robot sr60-like\nangles rho3\naxes deg deg mm deg\nstart 0 90 -100 0\ntool g 30 0 50 0 0 0\nset tool=g\n"
FAR, BACK, ASIDE = "joints 80 -20 120 60 -40 100", "joints 20 30 60 0 40 10", "joints -50 10 100 -60 60 40"
START = tuple(math.radians(value) for value in (0, 30, 90, 0, 60, 0))
GRIPPER = Tool("g", translation(0.02, 0.0, 0.1))
PROGRAMS = {
    "path": f"ptp {FAR} path=400\n",
    "turn": f"ptp {FAR} turn=90\n",
    "both": f"ptp {FAR} path=500 turn=200\n",
    "passed": f"set path=600 turn=300 radius=40 blend=joint\nptp {FAR}\nptp {BACK}\nptp {ASIDE} blend=off\n",
    "zone": f"set zone=20,20,20,20,20,20 blend=joint\nptp {FAR} path=500\nptp {BACK}\nptp {ASIDE} turn=150 blend=off\n",
    "to a line and on": (
        "set path=300 turn=90 radius=30 blend=joint arcs=yes\nptp pose 350 -150 200 180 0 0\nlinear pose 350 50 200 180 0 30\n"
        "linear pose 450 50 250 180 0 60\nptp joints 20 30 60 0 40 10 blend=off\n"
    ),
    "another tool": (
        f"tool h 0 -80 220 0 0 0\nset path=600 turn=300 radius=40 blend=joint\nptp {FAR}\nptp {BACK} tool=h\nptp {ASIDE} blend=off\n"
    ),
    "block slope": f"set path=600 turn=300 radius=40 slope=block blend=joint\nptp {FAR}\nptp {BACK}\nptp {ASIDE} blend=off\n",
    "block slope, another tool": (
        f"tool h 0 -80 220 0 0 0\nset turn=300 radius=40 slope=block blend=joint\nptp {FAR}\nptp {BACK} tool=h path=600\n"
        f"ptp {ASIDE} blend=off\n"
    ),
    "sine": f"set shape=sin2\nptp {FAR} path=700\nptp {BACK} turn=200\n",
}


@pytest.mark.parametrize("kind", PROGRAMS)
def test_the_tool_of_an_arm_is_as_fast_as_its_ptp_may_be_and_no_faster(kind: str) -> None:
    speed, turn, _ = sampled(read(ARM + PROGRAMS[kind]), pinned.tx60().forward)
    assert max(speed, turn) > 0.9 and speed <= 1.001 and turn <= 1.001


def test_so_is_that_of_a_scara() -> None:
    text = (
        SCARA
        + "set path=350 turn=120 radius=30 blend=joint\nptp joints 100 -60 -20 90\nptp joints -40 100 -150 0\nptp joints 0 90 -100 200\n"
    )
    speed, turn, _ = sampled(read(text), pinned.sr60().forward)
    assert max(speed, turn) > 0.9 and speed <= 1.001 and turn <= 1.001


def test_movej_keeps_tvel_and_rvel_while_the_monitor_speed_changes_and_the_arm_stops_and_goes_on() -> None:
    mdesc = Mdesc(tvel=300.0, rvel=120.0, blend=BlendKind.JOINT, leave=40.0, reach=40.0)
    arm = Arm(robot("tx60-like"), START)
    moves, rows = MotionStack(arm), [arm.joints]
    for target in ((80, -20, 120, 60, -40, 100), (20, 30, 60, 0, 40, 10), (-50, 10, 100, -60, 60, 40)):
        moves.movej(JointTarget(tuple(math.radians(value) for value in target)), GRIPPER, mdesc)
    speeds = iter((1.0, 0.4, 1.0, 0.1, 0.7, 1.0))
    while not moves.wait_end_move():
        if len(rows) % 400 == 0:
            arm.override = next(speeds, 1.0)
        if len(rows) in (1900, 2300):
            (moves.stop_move if len(rows) == 1900 else moves.restart_move)()
        rows.append(arm.step())
    asked = Block(Interpolation.PTP, JointTarget(START), pace=mdesc.pace(), tool=GRIPPER)
    speed, turn, _ = excess([asked], pinned.tx60().forward, np.array(rows), [1] * len(rows))
    assert max(speed, turn) > 0.9 and speed <= 1.001 and turn <= 1.001
    assert rows[-1] == pytest.approx(np.radians([-50, 10, 100, -60, 60, 40]), abs=1e-9)


def test_blocks_that_come_one_by_one_are_no_faster() -> None:
    """The law of a path that goes on is another one: a mean over time."""
    dice, machine = random.Random(2), robot("tx60-like")
    blocks = list(read(ARM + PROGRAMS["passed"]).blocks)
    arm, left, rows, numbers = Arm(machine, START), list(blocks), [], []
    while left or not (arm.place().waiting == 0 and arm.resting):
        if left and arm.planner.waiting <= 1 and dice.random() < 0.05:
            arm.add(left.pop(0))
            if not left:
                arm.finish()
        rows.append(arm.step())
        numbers.append(arm.place().block)
    speed, turn, _ = excess(blocks, pinned.tx60().forward, np.array(rows), numbers)
    assert max(speed, turn) > 0.9 and speed <= 1.001 and turn <= 1.001


@pytest.mark.parametrize("keys", ("speed=100", "path=9999 turn=9999"))
def test_a_ptp_whose_tool_reaches_no_limit_is_straight_in_the_axes_and_nothing_else(keys: str) -> None:
    """movej with the default descriptor (tvel = 9999 mm/s, rvel = 9999 deg/s): to the last bit what it is without any."""
    machine = robot("tx60-like")
    found = route_of(read(ARM + f"set radius=40 blend=joint {keys}\nptp {FAR}\nptp {BACK}\nptp {ASIDE} blend=off\n"), machine)
    assert [len(stretch.path.coefficients) for stretch in found.stretches] == [1] * 5
    assert not any(stretch.path.coefficients[:, :, -2:].any() for stretch in found.stretches)
    alone = route_of(read(ARM + f"ptp {FAR} {keys}\n"), machine).stretches[0].path
    line = joint_line(START, [math.radians(value) for value in (80, -20, 120, 60, -40, 100)])
    assert np.array_equal(alone.coefficients, line.coefficients)


def test_a_time_of_the_block_wins_over_its_speeds() -> None:
    machine = robot("tx60-like")
    free, asked = (trace(route_of(read(ARM + f"ptp {FAR} time=1.5{keys}\n"), machine).stretches, machine).q for keys in ("", " path=100"))
    assert np.array_equal(free, asked)


def test_without_transformation_the_main_axes_keep_it() -> None:
    """Five turning axes, the first alone makes the path (P303 = 3, 4, 4, 4, 4): turn= is its speed, in a passed point as well."""
    machine = robot("turntables")
    limits = tuple(replace(axis, manual=n > 0) for n, axis in enumerate(machine.limits))
    arm = Arm(replace(machine, limits=limits), (0.0,) * 5)
    text = "robot turntables\naxes deg deg deg deg deg\nstart 0 0 0 0 0\nset turn=90 zone=20,20,20,20,20 blend=joint\n"
    for block in read(text + "ptp joints 100 200 0 0 0\nptp joints 200 150 0 90 0 blend=off\n").blocks:
        arm.add(block)
    arm.finish()
    rates = np.degrees(np.diff(run(arm), axis=0)) / 1e-3
    assert 89.9 < rates[:, 0].max() <= 90.09 and rates[:, 1].max() > 170.0
