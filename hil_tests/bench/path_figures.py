"""Figures of paths and their laws (motion.md E): one function a row, each with its anchor; none runs a stepper."""

import itertools
import math
import random
import statistics
import time
from typing import Any

import numpy as np
import ruckig
from numpy.typing import NDArray

from hil_tests.bench.figure_row import RECORDED, Figure, row
from hil_tests.lab.cells import arms
from hil_tests.lab.cells import motion_paths as lab
from motion.execution.ptp import nominal_duration, plan_ptp
from motion.geometry.limits import AxisLimits
from motion.paths.base import norm, sub
from motion.paths.corner import corner, deviation, radius_for
from motion.paths.joints import joint_blend, joint_line
from motion.paths.line import line
from motion.paths.spline import spline
from motion.planner.joint_path import joint_path_of
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.planner.round_corner import span
from motion.program.slopes import earliest, frozen, overlap, ramped, summed
from motion.program.text.reader import read
from motion.timing import topp
from motion.timing.choice import Rounded, assembled, duration, fastest
from motion.timing.jerk import jerk_limited
from motion.timing.limits import law_limits

Array = NDArray[np.float64]


# ---- geometry


def corner_dev(count: int = 1000) -> Figure:
    """How far a corner is missed beyond what was asked for, over random corners of 5 .. 175 deg."""
    dice, worst = random.Random(5), -math.inf
    for _ in range(count):
        interior = math.radians(dice.uniform(5.0, 175.0))
        a, b = dice.uniform(0.02, 0.5), dice.uniform(0.02, 0.5)
        u2 = (-math.cos(interior), math.sin(interior), 0.0)
        before = line(lab.point(-a, 0.0, 0.0), lab.point(0.0, 0.0, 0.0))
        after = line(lab.point(0.0, 0.0, 0.0), lab.point(b * u2[0], b * u2[1], 0.0))
        tolerance = dice.choice((1e-5, 5e-5, 1e-3, 5e-3))
        r = min(radius_for(tolerance, (1.0, 0.0, 0.0), u2), 0.5 * a, 0.5 * b)
        worst = max(worst, deviation(corner(before, after, r, r), (0.0, 0.0, 0.0)) - tolerance)
    return row("motion.corner_dev", worst * 1e6, "um beyond", 1.0, "asked for", 0.0)


# ---- laws


def u_portal() -> list[Figure]:
    """Block slope at its widest (middle of the block), one way; and how far the corners are missed."""
    limits = lab.portal_limits()
    points = [pose.position for pose in lab.u_points()]
    legs = [joint_line(a, b) for a, b in itertools.pairwise(points)]
    blocks = [ramped(leg, limits) for leg in legs]
    corners: list[Rounded | None] = []
    missed = 0.0
    for k, (a, b) in enumerate(itertools.pairwise(blocks)):
        found = overlap(a, b, earliest(a, 0.0125), limits)
        made = frozen(a, b, found) if found else None
        assert found is not None and made is not None
        way = summed(a, b, found.start, np.linspace(found.start, a.duration, 800))
        missed = max(missed, float(np.min(np.linalg.norm(way - np.array(points[k + 1]), axis=1))))
        corners.append(Rounded(found.leave, found.reach, made[0]))
    bounds = law_limits(limits)
    law = jerk_limited(assembled(legs, corners), bounds)
    stops = sum(block.duration for block in blocks)
    return [
        row("motion.u_portal", law.duration, "s", 0.366, "exact stops, same run", stops),
        row("motion.u_portal_cut", missed * 1e3, "mm", 3.3, f"Bezier R 12.5 ({RECORDED})", 3.3),
    ]


def by_text(machine: Machine, text: str) -> float:
    """Seconds of a program as a user writes it, from the planner a cell has."""
    program = read(text)
    planner = Planner(machine, program.start)
    for block in program.blocks:
        planner.add(block)
    planner.finish()
    while planner.plan(planner.end, hurry=True):
        pass
    return round(planner.end, 9)  # whole nanoseconds, as every clock here


def u_arm_text(radius: float) -> str:
    """25 mm up, 300 mm across, 25 mm down; radius in mm, 0: exact stops.  The short legs have one corner, which may have them whole."""
    machine, place = arms.robot("tx60-like"), (0.35, 0.0, 0.3)
    first = lab.u_points(lab.POINTING_DOWN, place, along=1)[0]
    start = machine.kinematics.inverse(first, (math.atan2(-0.15, place[0]), 0.5, 1.2, 0.0, 1.0, 0.0))
    head = "robot tx60-like\nangles val3\naxes deg deg deg deg deg deg\nstart " + " ".join(f"{math.degrees(q):.9f}" for q in start)
    blend = f"set radius={radius} share=99.9\n" if radius else ""
    lines = "linear pose 350 -150 325 180 0 0\nlinear pose 350 150 325 180 0 0\nlinear pose 350 150 300 180 0 0 blend=off\n"
    return f"{head}\n{blend}{lines}"


def u_6r() -> list[Figure]:
    """R 25 mm (the 25 mm legs whole), and the ratio to exact stops over all R, by program text."""
    machine = arms.robot("tx60-like")
    stops = by_text(machine, u_arm_text(0.0))
    each = [by_text(machine, u_arm_text(radius)) for radius in (2.0, 5.0, 12.5, 24.97)]
    return [
        row("motion.u_6r", each[-1], "s", 0.345, "exact stops, same run", stops),
        row("motion.u_6r_never_slower", max(each) / stops, "x exact stops", 1.0, "exact stops, same run", 1.0),
    ]


def u_portal_text(radius: float) -> str:
    """The U of the portal; radius in mm."""
    lines = "linear pose 0 0 25 0 0 0\nlinear pose 300 0 25 0 0 0\nlinear pose 300 0 0 0 0 0 blend=off\n"
    return f"robot portal\naxes mm mm mm\nstart 0 0 0\nset radius={radius:.4f} share=99.9\n{lines}"


def u_portal_wide() -> list[Figure]:
    """Corners cut by 6.6 mm, one way, by program text; and both ways of the narrow one, with a rest where the way turns back."""
    radius = radius_for(6.6e-3, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    wide = by_text(arms.portal(), u_portal_text(radius * 1e3))
    narrow = u_portal()[0]["value"]
    assert isinstance(narrow, float)
    return [
        row("motion.u_portal_wide", wide, "s", 0.356, "corners of 3.0 mm, same run", narrow),
        row("motion.u_portal_both", 2.0 * narrow, "s", 0.735, f"3.3 mm ({RECORDED})", 0.735),
    ]


def ptp_passing() -> Figure:
    """The U of the arm point to point, its points passed with half of the shorter block on each side (the most a P213 gives)."""
    legs, _, limits = lab.u_arm(0.0125)
    axes = lab.arm()[1]
    places = [legs[0].q(0.0), *(leg.q(leg.length) for leg in legs)]
    lines = [joint_line(a, b) for a, b in itertools.pairwise(places)]
    corners: list[Rounded | None] = []
    for a, b in itertools.pairwise(lines):
        half = 0.5 * min(a.length, b.length)
        corners.append(Rounded(half, half, joint_blend(a, a.length - half, b, half, span(a, b, half, axes))))
    stops = duration(fastest(lines, [None, None], limits)[0])
    share = duration(fastest(lines, corners, limits)[0]) / stops
    return row("motion.ptp_passing", share, "x exact stops", 0.85, "exact stops, same run", 1.0)


def contour_text() -> str:
    """A row of 200 splines."""
    points = [pose.position for pose in lab.contour_points()]
    lines = "".join(f"spline pose {x * 1e3:.6f} {y * 1e3:.6f} 0 0 0 0\n" for x, y, _ in points[1:])
    return f"robot portal\naxes mm mm mm\nstart 100 0 0\n{lines}"


def contour() -> list[Figure]:
    """200 points, jerk-limited, by program text; distance from the true curve."""
    chain = spline(lab.contour_points())
    off = 0.0
    for s in np.linspace(0.0, chain.length, 4001):
        x, y, _ = chain.at(float(s)).position
        off = max(off, abs(math.hypot(x, y) - lab.contour_radius(math.atan2(y, x))))
    return [
        row(
            "motion.contour",
            by_text(arms.portal("xyz", 500.0, 5000.0, 2e5), contour_text()),
            "s",
            1.90,
            f"sequential LP ({RECORDED})",
            1.872,
        ),
        row("motion.contour_off", off * 1e6, "um", 5.0, f"cubic spline ({RECORDED})", 2.2),
    ]


def singularity() -> list[Figure]:
    """LIN 500 mm/s past the wrist singularity at 0.57 deg."""
    curve, near, robot, limits = lab.past_singularity(0.57)
    path = joint_path_of(curve, robot, near)
    law = jerk_limited(path, limits)
    samples = path.at(law.at(np.arange(0.0, law.duration + lab.MS, lab.MS)))
    speed = lab.worst_shares(samples[:, :6], robot.limits)[0]
    start, end = curve.at(0.0).position, curve.at(curve.length).position
    u = sub(end, start)
    off = 0.0
    for q in samples[:, :6]:
        step = sub(robot.forward(tuple(q)).position, start)
        along = sum(a * b for a, b in zip(step, u, strict=True)) / norm(u) ** 2
        off = max(off, norm(sub(step, (u[0] * along, u[1] * along, u[2] * along))))
    return [
        row("motion.singularity", law.duration, "s", 0.86, f"acceleration-limited ({RECORDED})", 0.841),
        row("motion.singularity_joints", speed, "x limit", 1.0, f"needed at full speed ({RECORDED})", 6.0),
        row("motion.singularity_path", off * 1e6, "um", 10.0, f"damped least squares ({RECORDED})", 4500.0),
    ]


def topp_vs_toppra(count: int = 200, grid: int = 1000) -> Figure:
    """Largest difference of the duration on random 5-point splines of six axes."""
    import toppra

    chance, worst = np.random.default_rng(1), 0.0
    at = np.linspace(0.0, 1.0, grid + 1)
    for _ in range(count):
        curve = toppra.SplineInterpolator(np.linspace(0.0, 1.0, 5), chance.uniform(-2.0, 2.0, (5, 6)))
        speed, accel = chance.uniform(1.0, 3.0, 6), chance.uniform(3.0, 12.0, 6)
        first, second = curve.evald(at), curve.evaldd(at)
        ours = topp.solve(first, second, 1.0 / grid, accel, topp.speed_limit(first, speed)).duration
        sdot = _toppra(curve, at, speed, accel).compute_parameterization(0.0, 0.0)[1]
        theirs = float(np.sum(2.0 / grid / (sdot[1:] + sdot[:-1])))
        worst = max(worst, abs(ours / theirs - 1.0))
    return row("motion.topp_vs_toppra", worst * 100.0, "%", 0.2, "toppra, same run", 0.0)


def ptp_vs_ruckig(count: int = 500) -> Figure:
    """PTP duration against ruckig with phase synchronisation."""
    dice, worst, found = random.Random(3), 0.0, 0
    for _ in range(count):
        limits = [
            AxisLimits(f"A{n}", -10.0, 10.0, dice.uniform(0.5, 3.0), dice.uniform(3.0, 20.0), dice.uniform(50.0, 500.0)) for n in range(6)
        ]
        start, end = ([dice.uniform(-3.0, 3.0) for _ in range(6)] for _ in range(2))
        wish, answer = ruckig.InputParameter(6), ruckig.Trajectory(6)
        wish.synchronization = ruckig.Synchronization.Phase
        wish.current_position, wish.target_position = start, end
        wish.max_velocity, wish.max_acceleration, wish.max_jerk = (
            [getattr(axis, n) for axis in limits] for n in ("speed", "accel", "jerk")
        )
        ruckig.Ruckig(6).calculate(wish, answer)
        if _straight(answer, start, end):  # where no straight line keeps all limits at once ruckig gives up the line, we do not
            found += 1
            worst = max(worst, abs(nominal_duration(plan_ptp(start, end, limits)) / answer.duration - 1.0))
    assert found >= count // 10
    return row("motion.ptp_vs_ruckig", worst * 100.0, "%", 0.1, "ruckig, phase, same run", 0.0)


def _straight(answer: ruckig.Trajectory, start: list[float], end: list[float]) -> bool:
    """Whether all axes make the same share of their way at a quarter of the time."""
    q, _, _ = answer.at_time(0.25 * answer.duration)
    shares = [(x - a) / (b - a) for x, a, b in zip(q, start, end, strict=True)]
    return bool(max(shares) - min(shares) < 1e-9)


def plan_ms(points: int = 2000, repeats: int = 7) -> Figure:
    """One TOPP pass over 2,000 points of a six-axis path."""
    import toppra

    at = np.linspace(0.0, 1.0, points + 1)
    k = np.arange(1.0, 7.0)[None, :]
    first, second = k * np.cos(k * at[:, None]), -k * k * np.sin(k * at[:, None])
    curve = toppra.SplineInterpolator(np.linspace(0.0, 1.0, 41), np.sin(k * np.linspace(0.0, 1.0, 41)[:, None]))
    ours, theirs = [], []
    for _ in range(repeats):
        begin = time.process_time()
        topp.solve(first, second, 1.0 / points, np.full(6, 10.0), topp.speed_limit(first, np.full(6, 2.0)))
        ours.append(time.process_time() - begin)
        judge = _toppra(curve, at, np.full(6, 2.0), np.full(6, 10.0))
        begin = time.process_time()
        judge.compute_parameterization(0.0, 0.0)
        theirs.append(time.process_time() - begin)
    anchor = statistics.median(theirs) * 1e3
    return row(
        "motion.plan_ms", statistics.median(ours) * 1e3, "ms of processor time", 50.0, f"toppra, {points + 1:,} points, same run", anchor
    )


def _toppra(curve: Any, at: Array, speed: Array, accel: Array) -> Any:
    """The judge of laws under acceleration limits, interpolation scheme."""
    import toppra.algorithm
    import toppra.constraint

    kind = toppra.constraint.DiscretizationType.Interpolation
    limits = [
        toppra.constraint.JointVelocityConstraint(np.stack([-speed, speed], axis=1)),
        toppra.constraint.JointAccelerationConstraint(np.stack([-accel, accel], axis=1), discretization_scheme=kind),
    ]
    return toppra.algorithm.TOPPRA(limits, curve, gridpoints=at)
