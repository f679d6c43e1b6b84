"""Figures of belts (motion.md C.7, E 11): how near the tool is to a belt that varies and stops, the cam, and what a whole period costs.

The chain is the one of the product: increments, counter, filter with prediction, catching up, stepper, frame, inverse kinematics.
Belt: 300 mm/s +-10 % at 1 Hz, a stop in 0.3 s, encoder of 0.1 mm, one sample a ms.
"""

import math
import time
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from hil_tests.bench.figure_row import RECORDED, Figure, row
from hil_tests.bench.step_costs import cost_rows
from hil_tests.lab.cells import motion_paths as lab
from hil_tests.lab.cells.arms import portal
from motion.execution.stepper import State, Stepper
from motion.execution.timed import TimedPiece
from motion.geometry.frames import NO_ROTATION, Pose
from motion.geometry.limits import AxisLimits
from motion.kinematics.arm6 import Arm6
from motion.kinematics.base import Joints
from motion.paths.line import line
from motion.planner.commit import timed_pieces
from motion.planner.joint_path import joint_path_of
from motion.sync.belt_frame import Carried
from motion.sync.belts import BeltData, Belts
from motion.sync.cam import cam
from motion.sync.join import SyncStepper
from motion.sync.parallel import Carrier, Coupling, ParallelPart
from motion.sync.reserve import reserved
from motion.sync.tracker import ALPHA, BETA, GAMMA, Tracker
from motion.timing.foresight import Foresight
from motion.timing.jerk import jerk_limited
from motion.timing.limits import law_limits

MS = lab.MS
SPEED, INCREMENT, CYCLE = 0.3, 1e-4, 4e-3
STOPS_AT, STOPS_IN, ENGAGED_AT = 3.0, 0.3, 0.2


def belt_way(seconds: float, fine: int = 20) -> list[float]:
    """m at every ms."""
    ways, place = [], 0.0
    for k in range(round(seconds / MS)):
        ways.append(place)
        for n in range(fine):
            t = (k + n / fine) * MS
            left = min(max(1.0 - (t - STOPS_AT) / STOPS_IN, 0.0), 1.0)
            place += SPEED * (1 + 0.1 * math.sin(2 * math.pi * t)) * left * MS / fine
    return ways


def carried(latency_ms: int, gains: tuple[float, float, float]) -> tuple[Belts, Carried]:
    belts = Belts([BeltData(INCREMENT)], MS, CYCLE)
    tracker = Tracker(MS, latency_ms * MS, *gains)
    return belts, Carried(ParallelPart(belts.belt(1), Carrier(factors=(0.0, 1.0, 0.0))), tracker, Coupling(5.0, 200.0))


def tracking(latency_ms: int, gains: tuple[float, float, float] = (ALPHA, BETA, GAMMA)) -> tuple[float, float]:
    """(rms, largest) distance of the tool from its point on the belt, mm, from where the robot has caught up to after the stop."""
    machine = portal()
    ways = belt_way(4.0 + 0.05)
    belts, frame = carried(latency_ms, gains)
    start = Pose((0.0, -0.6, 0.0), NO_ROTATION)
    rig = SyncStepper(Stepper(3, MS, start.position), machine.kinematics, [axis.speed for axis in machine.limits], MS, start.position)
    zero, errors = 0.0, []
    for k in range(len(ways) - latency_ms):
        belts.update([math.floor(ways[k] / INCREMENT)])
        frame.step(MS)
        if k == round(ENGAGED_AT / MS):
            zero = frame.part.belt.zero
            rig.place(frame.engage())
            path = joint_path_of(line(_seen(start, frame), _seen(Pose((0.3, -0.5, 0.1), NO_ROTATION), frame)), machine.kinematics, rig.q)
            bounds = law_limits(reserved(machine.limits), way=(0.2, 2.0, 50.0))
            for piece in timed_pieces(path, law_limits(machine.limits), jerk_limited(path, bounds)):
                rig.load(piece)
        made = rig.step(frame.frame)
        if frame.caught:
            x, y, z = made.path.q
            goal = (x, y + ways[k + latency_ms] - zero, z)
            errors.append(math.dist(machine.kinematics.forward(made.q).position, goal) * 1e3)
    values = np.array(errors)
    assert len(errors) > 3000 and rig.fault is None
    return float(np.sqrt(np.mean(values * values))), float(values.max())


def _seen(pose: Pose, frame: Carried) -> Pose:
    return frame.frame.inverse() @ pose


def belt_rms() -> list[Figure]:
    """Tracking with 1 and 4 ms from reading the encoder to the moment the set value acts; anchor: a plain alpha-beta filter."""
    rms, most = tracking(1)
    plain, plain_most = tracking(1, (0.35, 0.05, 0.0))
    late, late_most = tracking(4)
    anchor = "alpha-beta 0.35/0.05, same run"
    return [
        row("motion.belt_rms", rms, "mm", 0.10, anchor, plain),
        row("motion.belt_max", most, "mm", 0.7, anchor, plain_most),
        row("motion.belt_rms_4ms", late, "mm", 0.12, f"alpha-beta ({RECORDED})", 0.059),
        row("motion.belt_max_4ms", late_most, "mm", 1.37, f"alpha-beta ({RECORDED})", 1.37),
    ]


def belt_cam() -> Figure:
    """The cam of the manual's program against exact fractions, largest difference in mm of 150."""
    curve, worst = cam(0.150, 0.030, 0.070), 0.0
    slope = Fraction(150) / (150 - Fraction(30 + 70, 2))
    for tenth in range(1501):
        belt = Fraction(tenth, 10)
        if belt <= 30:
            exact = slope * belt * belt / 60
        elif belt <= 80:
            exact = slope * (belt - 15)
        else:
            exact = 150 - slope * (150 - belt) ** 2 / 140
        worst = max(worst, abs(curve.at(tenth * 1e-4)[0] * 150.0 - float(exact)))
    return row("motion.belt_cam", worst, "mm off", 1e-9, "fractions, same run", 0.0)


def step_costs(rounds: int = 8, repeats: int = 3) -> list[Figure]:
    """A whole period of the six-axis arm on LIN on a running belt: belt, filter, stepper with override changes, frame, inverse, scout.

    Each round is run `repeats` times and the median of each period counts.
    """
    robot, limits = lab.arm()
    start, end = lab.point(0.35, -0.25, 0.3, lab.POINTING_DOWN), lab.point(0.4, 0.0, 0.3, lab.POINTING_DOWN)
    near = robot.inverse(start, (0.0, 0.5, 1.2, 0.0, 1.0, 0.0))
    path = joint_path_of(line(start, end), robot, near)
    pieces = timed_pieces(path, law_limits(limits), jerk_limited(path, law_limits(reserved(limits), way=(0.25, 4.0, 100.0))))
    anchor = f"stepper, frame, analytic IK ({RECORDED})", 9.0, 15.0
    return cost_rows("motion.belt_step", anchor, rounds, repeats, lambda n, foresight: _periods(robot, limits, near, pieces, n, foresight))


def _periods(
    robot: Arm6, limits: Sequence[AxisLimits], near: Joints, pieces: Sequence[TimedPiece], n: int, foresight: type[Foresight]
) -> list[int]:
    """ns of each period; n: where the override changes."""
    costs: list[int] = []
    belts, frame = carried(1, (ALPHA, BETA, GAMMA))
    rig = SyncStepper(Stepper(6, MS, near, foresight), robot, [axis.speed for axis in limits], MS, near)
    for piece in pieces:
        rig.load(piece)
    frame.step(MS)
    frame.engage()
    for k in range(5000):
        if (k + 37 * n) % 400 == 399:
            rig.set_override((0.3, 0.6, 1.0)[k // 400 % 3])
        count = [int(0.05 * k * MS / INCREMENT)]
        begin = time.thread_time_ns()
        belts.update(count)
        made = rig.step(frame.step(MS))
        inside = all(axis.lower <= value <= axis.upper for axis, value in zip(limits, made.q, strict=True))
        costs.append(time.thread_time_ns() - begin)
        assert inside and rig.fault is None
        if made.path.state is State.IDLE:
            break
    return costs


def figures() -> list[Figure]:
    """All rows."""
    return [*belt_rms(), belt_cam(), *step_costs()]


if __name__ == "__main__":
    for figure in figures():
        verdict = "met" if figure["met"] else "MISSED"
        print(f"{figure['figure']:24} {figure['value']:>12} {figure['unit']:8} goal {figure['goal']:<8} {verdict}")
