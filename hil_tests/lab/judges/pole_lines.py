"""Straight lines close to the wrist pole of five six-axis arms, and what they ask of the joints by an independent solution: the closed form
of OPW, followed densely, with every step so short that the next joints are those before it and no others."""

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from py_opw_kinematics import _internal as internal

from motion.geometry.frames import Pose, product
from motion.geometry.limits import AxisLimits, limits_from
from motion.geometry.orientation import rotation_by
from motion.kinematics.arm6 import Arm6, ArmGeometry
from motion.planner.robot import Machine

Array = NDArray[np.float64]
Joints = tuple[float, ...]
WIDE = ((-180, 180, 435), (-127.5, 127.5, 410), (-142.5, 142.5, 540), (-270, 270, 995), (-122.5, 132.5, 1065), (-270, 270, 1445))
NARROW = ((-165, 165, 150), (-110, 110, 150), (-150, 150, 180), (-185, 185, 270), (-120, 120, 280), (-350, 350, 360))
ARMS = {
    "straight": (ArmGeometry(0.375, 0.29, 0.31, 0.07, side=0.02), WIDE),
    "offset elbow": (ArmGeometry(0.7, 0.65, 0.75, 0.12, delta=0.2, elbow=-0.1), NARROW),
    "turned axes": (
        ArmGeometry(0.5, 0.6, 0.7, 0.1, 0.15, -0.1, 0.02, signs=(1, -1, 1, -1, 1, -1), offsets=(0, -0.5, 0.3, 0, 0.1, 1.0)),
        WIDE,
    ),
    "small": (ArmGeometry(0.2, 0.15, 0.16, 0.04, delta=0.03, elbow=0.01), NARROW),
    "large": (
        ArmGeometry(0.8, 1.1, 1.2, 0.2, delta=0.3, elbow=0.15, signs=(-1, 1, 1, -1, 1, -1), offsets=(0, 0, math.pi / 2, 0, 0, 0)),
        NARROW,
    ),
}
CLOSE = 0.02  # rad between two steps at most
SHORTEST = 1e-13  # of the line
THROUGH = 2e-7  # rad of the wrist: a line that comes so near to the pole may as well go straight through it
MARGIN = 1e-4  # rad from the end of a travel, and m from the end of the reach: what ends so near to it is not judged


@dataclass(frozen=True)
class PoleLine:
    """start: joints at its beginning; a, b: its ends, of the flange; miss: its distance from the pole (m)."""

    arm: str
    start: Joints
    a: Pose
    b: Pose
    miss: float


@dataclass(frozen=True)
class Truth:
    """possible: None where that hangs by a hair, or the wrist may as well go straight through the pole; end: where the joints are then."""

    possible: bool | None
    end: Joints = ()


@cache
def machine(arm: str) -> Machine:
    geometry, travel = ARMS[arm]
    limits = tuple(
        limits_from(f"J{n}", "deg", lower=low, upper=high, speed=v, accel=10.0 * v, jerk=500.0 * v)
        for n, (low, high, v) in enumerate(travel, 1)
    )
    return Machine(Arm6(geometry, limits), limits)


@cache
def judge(arm: str) -> internal.Robot:
    g = ARMS[arm][0]
    o1, o2, o3, o4, o5, o6 = (-value for value in g.offsets)  # theirs are taken away
    f1, f2, f3, f4, f5, f6 = (sign < 0 for sign in g.signs)
    lengths = (g.delta, g.elbow, g.side, g.height, g.arm, g.forearm, g.flange)
    model = internal.KinematicModel(*lengths, offsets=(o1, o2, o3, o4, o5, o6), flip_axes=(f1, f2, f3, f4, f5, f6))
    return internal.Robot(model, degrees=False)


def pole_lines(seed: int, count: int) -> Iterator[PoleLine]:
    """Return `count` lines over all arms, each at a distance from a pole of 1e-6 .. 1/30 of the reach of its arm; every third turns the
    tool as well."""
    chance = random.Random(seed)
    arms = list(ARMS)
    made = 0
    while made < count:
        line = _drawn(chance, arms[made % len(arms)], turns=made % 3 == 2)
        if line is not None:
            made += 1
            yield line


def _drawn(chance: random.Random, arm: str, *, turns: bool) -> PoleLine | None:
    robot, g = machine(arm), ARMS[arm][0]
    reach = g.arm + g.forearm
    angles = [
        chance.uniform(-2, 2),
        chance.uniform(-0.4, 1.2),
        chance.uniform(0.5, 2.0),
        chance.uniform(-2.5, 2.5),
        0.0,
        chance.uniform(-2.5, 2.5),
    ]
    q = tuple(sign * (angle - offset) for angle, sign, offset in zip(angles, g.signs, g.offsets, strict=True))
    if any(not axis.lower < value < axis.upper for axis, value in zip(robot.limits, q, strict=True)):
        return None
    pole = robot.forward(q)
    along = np.array([chance.gauss(0, 1) for _ in range(3)])
    aside = np.cross(along, [chance.gauss(0, 1) for _ in range(3)])
    along, aside = along / np.linalg.norm(along), aside / np.linalg.norm(aside)
    miss = reach * 10 ** chance.uniform(-6, -1.5)
    middle = np.array(pole.position) + miss * aside
    before, behind = (reach * chance.uniform(0.05, 0.3) for _ in range(2))
    turn = rotation_by(_three(np.array([chance.uniform(-0.5, 0.5) for _ in range(3)])) if turns else (0.0, 0.0, 0.0))
    a = Pose(_three(middle - before * along), pole.rotation)
    b = Pose(_three(middle + behind * along), product(pole.rotation, turn))
    found = [row for row in _rows(arm, a, q) if _within(robot.limits, row) > MARGIN]
    if not found:
        return None
    return PoleLine(arm, tuple(min(found, key=lambda row: max(abs(x - y) for x, y in zip(row, q, strict=True)))), a, b, miss)


def _three(values: Array) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def matrix(pose: Pose) -> Array:
    """4 x 4."""
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = np.array(pose.rotation).reshape(3, 3), pose.position
    return result


def _rows(arm: str, pose: Pose, near: Joints) -> list[Joints]:
    """All ways of OPW, by the turns nearest to `near`."""
    turned = []
    for row in judge(arm).inverse(matrix(pose)):
        turned.append(tuple(float(v) + math.tau * round((n - float(v)) / math.tau) for v, n in zip(row, near, strict=True)))
    return turned


def _within(limits: tuple[AxisLimits, ...], q: Joints) -> float:
    """rad from the end of the travel that is nearest; negative: beyond it."""
    return min(min(value - axis.lower, axis.upper - value) for axis, value in zip(limits, q, strict=True))


def _bend(arm: str, q: Joints) -> float:
    """Sine of the angle of the wrist: a line that misses the pole keeps its sign."""
    g = ARMS[arm][0]
    return math.sin(g.signs[4] * q[4] + g.offsets[4])


def pose_on(line: PoleLine, share: float) -> Pose:
    """Straight and with the least rotation, by a quaternion of its own."""
    place = np.array(line.a.position) + share * (np.array(line.b.position) - np.array(line.a.position))
    turned = np.array(line.a.rotation).reshape(3, 3).T @ np.array(line.b.rotation).reshape(3, 3)
    angle = math.acos(min(max((float(np.trace(turned)) - 1.0) / 2.0, -1.0), 1.0))
    if angle < 1e-9:
        return Pose(_three(place), line.a.rotation)
    skew = (turned - turned.T) / (2.0 * math.sin(angle))
    part = np.eye(3) + math.sin(share * angle) * skew + (1.0 - math.cos(share * angle)) * skew @ skew
    rotation = (np.array(line.a.rotation).reshape(3, 3) @ part).ravel()
    return Pose(_three(place), tuple(float(v) for v in rotation))  # type: ignore[arg-type]  # nine numbers, as a matrix has


def truth(line: PoleLine) -> Truth:
    """The continuous solution from its start."""
    limits, q, share, step = machine(line.arm).limits, line.start, 0.0, 0.01
    least = bend = math.inf
    while share < 1.0:
        step = min(step, 1.0 - share)
        rows = [row for row in _rows(line.arm, pose_on(line, share + step), q) if _bend(line.arm, row) * _bend(line.arm, q) > 0.0]
        best = min(rows, key=lambda row: max(abs(x - y) for x, y in zip(row, q, strict=True)), default=None)
        if best is None or max(abs(x - y) for x, y in zip(best, q, strict=True)) > CLOSE:
            step *= 0.5
            if step < SHORTEST:
                return Truth(None if min(least, bend) < MARGIN else False)
            continue
        q, share, step = best, share + step, step * 1.6
        least, bend = min(least, _within(limits, q)), min(bend, abs(_bend(line.arm, q)))
        if least < -MARGIN:
            return Truth(None if bend < THROUGH else False)
    return Truth(True, q) if least > MARGIN and bend > THROUGH else Truth(None)
