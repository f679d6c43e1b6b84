"""What the inverse kinematics costs and whether it finds everything: our closed forms in Python, EAIK (C++) in the same run.

10,000 poses that the joints of an arm reach: found = the joints are among the branches, every branch leads back to 1e-9 (m and
matrix), and the flags of every branch are those of the manual's formulas for its joints.
"""

import functools
import gc
import math
import random
import time
from collections.abc import Callable, Sequence

import numpy as np
from eaik.IK_DH import DhRobot

from gateway.files.robots import load_robot
from motion.geometry.frames import Pose
from motion.kinematics.arm6 import Arm6
from motion.kinematics.base import Joints, Kinematics
from motion.kinematics.dh import default_dh
from motion.robot import kinematics_of

POSES = 10_000
RESIDUAL = 1e-9
Figure = dict[str, str | float | bool]


def spread(robot: str, count: int, seed: int = 1) -> tuple[Kinematics, list[Joints]]:
    """A robot of configs/robots and joints anywhere in its travel."""
    model = load_robot(robot)
    dice = random.Random(seed)
    return kinematics_of(model), [tuple(dice.uniform(axis.lower, axis.upper) for axis in model.limits) for _ in range(count)]


def residual(one: Pose, two: Pose) -> float:
    """The largest difference of the twelve numbers."""
    return max(abs(a - b) for a, b in zip((*one.position, *one.rotation), (*two.position, *two.rotation), strict=True))


def found_of(kinematics: Kinematics, joints: Sequence[Joints]) -> tuple[int, float, int]:
    """(poses found, worst residual, branches whose flags differ from the formulas)."""
    found, worst, wrong = 0, 0.0, 0
    for q in joints:
        pose = kinematics.forward(q)
        branches = kinematics.branches(pose)
        worst = max([worst, *(residual(kinematics.forward(one), pose) for one, _ in branches)])
        wrong += sum(kinematics.configuration(one) != flags for one, flags in branches)
        found += any(max(abs(math.remainder(a - b, 2 * math.pi)) for a, b in zip(one, q, strict=True)) < 1e-6 for one, _ in branches)
    return found, worst, wrong


def costs_us(action: Callable[[int], object], count: int, rounds: int = 3) -> float:
    """Median of single calls, microseconds; the best of some rounds, since others use this machine too."""
    medians = []
    for _ in range(rounds):
        costs = []
        for number in range(count):
            begin = time.perf_counter_ns()
            action(number)
            costs.append(time.perf_counter_ns() - begin)
        medians.append(sorted(costs)[count // 2] / 1000)
    return min(medians)


def eaik_us(arm: Arm6, poses: Sequence[Pose]) -> float:
    """The same arm and poses with EAIK, all branches."""
    dh = default_dh(arm.geometry)
    judge = DhRobot(np.radians([*dh.alpha[:5], 0.0]), np.array(dh.a) / 1e3, np.array(dh.d) / 1e3)
    matrices = []
    for pose in poses:
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = np.array(pose.rotation).reshape(3, 3), pose.position
        matrices.append(matrix)
    return costs_us(lambda n: judge.IK(matrices[n]), len(matrices))


def run(poses: int = POSES) -> list[Figure]:
    """Rows motion.ik_found, motion.ik_us and their companions, as `axisgate bench` prints them."""
    arm, joints = spread("tx60-like", poses)
    assert isinstance(arm, Arm6)
    found, worst, wrong = found_of(arm, joints)
    near = [tuple(value + 1e-3 for value in q) for q in joints]
    targets = [arm.forward(q) for q in joints]
    inner = [n for n, q in enumerate(near) if all(axis.lower < value < axis.upper for axis, value in zip(arm.limits, q, strict=True))]
    gc.collect()
    gc.disable()
    try:
        judge = eaik_us(arm, targets)
        rows = [
            row("motion.ik_found", float(found), f"poses of {poses}", float(poses), float(poses), found == poses and worst <= RESIDUAL),
            row("motion.ik_residual", worst, "m and 1", RESIDUAL, RESIDUAL, worst <= RESIDUAL),
            row("motion.ik_flags_wrong", float(wrong), "branches", 0.0, 0.0, wrong == 0),
            timed("motion.ik_us", lambda n: arm.branches(targets[n]), poses, judge, 15.0),
            timed("motion.ik_follow_us", lambda n: arm.follow(targets[inner[n]], near[inner[n]]), len(inner), judge, 15.0),
            *others(poses, judge),
        ]
    finally:
        gc.enable()
    return rows


def others(poses: int, judge: float) -> list[Figure]:
    """SCARA and portal."""
    rows = []
    for name, title, goal in (("sr60-like", "motion.ik_scara_us", 3.0), ("portal", "motion.ik_portal_us", 2.0)):
        kinematics, joints = spread(name, poses)
        targets = [kinematics.forward(q) for q in joints]
        rows.append(timed(title, functools.partial(_ask, kinematics, targets), poses, judge, goal))
    return rows


def _ask(kinematics: Kinematics, targets: Sequence[Pose], number: int) -> object:
    return kinematics.branches(targets[number])


def timed(figure: str, action: Callable[[int], object], count: int, judge: float, goal: float) -> Figure:
    """A row of microseconds against EAIK's."""
    value = costs_us(action, count)
    return row(figure, round(value, 2), "us, median", round(judge, 2), goal, value <= goal)


def row(figure: str, value: float, unit: str, reference: float, goal: float, met: bool) -> Figure:
    """As `axisgate bench --json` has them."""
    words = "EAIK, all branches of the 6R arm, in this run" if unit.startswith("us") else "what is owed"
    ratio = round(value / reference, 2) if reference else 1.0
    return {
        "figure": figure,
        "value": value,
        "unit": unit,
        "reference": words,
        "reference_value": reference,
        "ratio": ratio,
        "goal": goal,
        "met": met,
    }


if __name__ == "__main__":
    for figure in run():
        print(figure)
