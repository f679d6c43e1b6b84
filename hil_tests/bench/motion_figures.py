"""Figures of paths, laws and the stepper (motion.md E): one function a row, each with its anchor.  `figures()` runs all of them.

A row: figure, value, unit, goal, met, reference, reference_value.  Anchors are measured in the same run where they can be (toppra,
ruckig, exact stops); the others are the measured values of motion.md C.5 to C.7 and say so.
"""

import gc
import itertools
import math
import random
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import ruckig
from numpy.typing import NDArray

from hil_tests.lab import motionpaths as lab
from motion.limits import AxisLimits
from motion.paths.base import norm, sub
from motion.paths.corner import corner, deviation, radius_for
from motion.paths.joints import joint_line
from motion.paths.line import line
from motion.paths.spline import spline
from motion.planner.commit import timed_pieces
from motion.planner.jointpath import joint_path_of
from motion.program.slopes import earliest, frozen, overlap, ramped, summed
from motion.ptp import nominal_duration, plan_ptp
from motion.stepper import Sample, State, Stepper
from motion.timed import TimedPiece
from motion.timing import topp
from motion.timing.choice import Rounded, assembled, duration, fastest
from motion.timing.jerk import jerk_limited
from motion.timing.limits import law_limits

Array = NDArray[np.float64]
Figure = dict[str, str | float | bool]
RECORDED = "motion.md, recorded"


def row(
    figure: str, value: float, unit: str, goal: float, reference: str = "", anchor: float = math.nan, *, at_least: bool = False
) -> Figure:
    met = value >= goal if at_least else value <= goal
    return {
        "figure": figure,
        "value": float(f"{value:.6g}"),
        "unit": unit,
        "goal": goal,
        "met": bool(met),
        "reference": reference,
        "reference_value": float(f"{anchor:.6g}"),
    }


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
        curve = frozen(a, b, found) if found else None
        assert found is not None and curve is not None
        way = summed(a, b, found.start, np.linspace(found.start, a.duration, 800))
        missed = max(missed, float(np.min(np.linalg.norm(way - np.array(points[k + 1]), axis=1))))
        corners.append(Rounded(found.leave, found.reach, curve))
    bounds = law_limits(limits)
    law = jerk_limited(assembled(legs, corners), bounds)
    stops = sum(block.duration for block in blocks)
    return [
        row("motion.u_portal", law.duration, "s", 0.366, "exact stops, same run", stops),
        row("motion.u_portal_cut", missed * 1e3, "mm", 3.3, f"Bezier R 12.5 ({RECORDED})", 3.3),
    ]


def u_6r() -> list[Figure]:
    """R 25 mm (the 25 mm legs whole), and the ratio to exact stops over all R."""
    worst, best = 0.0, math.nan
    stops = math.nan
    for radius in (0.002, 0.005, 0.0125, 0.02499):
        legs, corners, limits = lab.u_arm(radius)
        stops = duration(fastest(legs, [None, None], limits)[0])
        runs, _ = fastest(legs, corners, limits)
        worst, best = max(worst, duration(runs) / stops), duration(runs)
    return [
        row("motion.u_6r", best, "s", 0.345, "exact stops, same run", stops),
        row("motion.u_6r_never_slower", worst, "x exact stops", 1.0, "exact stops, same run", 1.0),
    ]


def contour() -> list[Figure]:
    """200 points, jerk-limited; distance from the true curve."""
    chain = spline(lab.contour_points())
    path = lab.chain_path(chain)
    off = 0.0
    for s in np.linspace(0.0, chain.length, 4001):
        x, y, _ = chain.at(float(s)).position
        off = max(off, abs(math.hypot(x, y) - lab.contour_radius(math.atan2(y, x))))
    law = jerk_limited(path, law_limits(lab.portal_limits(0.5, 5.0, 200.0)))
    return [
        row("motion.contour", law.duration, "s", 1.90, f"sequential LP ({RECORDED})", 1.872),
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
        row("motion.singularity", law.duration, "s", 0.90, f"acceleration-limited ({RECORDED})", 0.841),
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


# ---- online


def pieces_of_u() -> tuple[list[TimedPiece], list[AxisLimits]]:
    """The U of the portal with R 12.5 mm as pieces."""
    limits = lab.portal_limits()
    legs, corners = lab.u_portal(0.0124999)
    path, bounds = assembled(legs, corners), law_limits(limits)
    return timed_pieces(path, bounds, jerk_limited(path, bounds)), limits


def loaded(pieces: list[TimedPiece], axes: int, period_s: float = lab.MS) -> Stepper:
    stepper = Stepper(axes, period_s, pieces[0].start())
    for piece in pieces:
        stepper.load(piece)
    return stepper


def run_out(stepper: Stepper, changes: dict[int, float], most: int = 5000) -> list[Sample]:
    """Samples until idle; changes: sample number -> override."""
    samples = []
    for number in range(most):
        if number in changes:
            stepper.set_override(changes[number])
        samples.append(stepper.step())
        if samples[-1].state is State.IDLE:
            break
    return samples


def random_pieces(dice: random.Random, limits: list[AxisLimits], fewest: int = 2) -> list[TimedPiece]:
    """A chain of up to four lines of the portal with corners of all sizes between them."""
    bounds = law_limits(limits)
    points = [lab.point(dice.uniform(-0.3, 0.3), dice.uniform(-0.3, 0.3), dice.uniform(-0.3, 0.3)) for _ in range(dice.randint(fewest, 5))]
    lines = [line(a, b) for a, b in itertools.pairwise(points)]
    corners: list[Rounded | None] = []
    for a, b in itertools.pairwise(lines):
        r = dice.uniform(0.05, 0.49) * min(a.length, b.length)
        corners.append(Rounded(r, r, lab.portal_path(corner(a, b, r, r))))
    path = assembled([lab.portal_path(curve) for curve in lines], corners)
    return timed_pieces(path, bounds, jerk_limited(path, bounds))


@dataclass
class Changes:
    """100 -> 30 -> 100 % from start times all over paths: worst shares of the limits, and the times to 30 % of the full speed there."""

    accel: float = 0.0
    jerk: float = 0.0
    times: list[float] = field(default_factory=list)

    def add(self, pieces: list[TimedPiece], limits: list[AxisLimits], starts: int) -> None:
        nominal = run_out(loaded(pieces, len(limits)), {})
        duration_ms = len(nominal)
        for n in range(starts):
            at = 3 + n * (duration_ms - 8) // starts
            samples = run_out(loaded(pieces, len(limits)), {at: 0.3, at + 300: 1.0})
            _, accel, jerk = lab.worst_shares(np.array([pieces[0].start(), *(s.q for s in samples)]), limits)
            self.accel, self.jerk = max(self.accel, accel), max(self.jerk, jerk)
            self.times.append(reached(nominal, samples, at, 0.31))


def override(starts: int = 33, chains: int = 20) -> list[Figure]:
    """The U of the portal, and random chains of lines and corners, five starts each; reached: within 1 % of full speed."""
    dice, found = random.Random(5), Changes()
    pieces, limits = pieces_of_u()
    found.add(pieces, limits, starts)
    for _ in range(chains):
        found.add(random_pieces(dice, limits, 3), limits, 5)
    scaled = _time_scaling(pieces, limits, starts)
    what = f"{len(found.times)} starts, U and {chains} random chains"
    return [
        row("motion.override_a", found.accel, f"x limit, {what}", 1.02, "time scaling on the U, 100 ms ramp, same run", scaled),
        row("motion.override_j", found.jerk, f"x limit, {what}", 1.10, "", math.nan),
        row("motion.override_ms", max(found.times), f"ms, {what}", 120.0, f"second order, worst on the U ({RECORDED})", 99.0),
        row("motion.override_median_ms", statistics.median(found.times), "ms", 120.0, f"second order, median on the U ({RECORDED})", 39.0),
    ]


def _time_scaling(pieces: list[TimedPiece], limits: list[AxisLimits], starts: int) -> float:
    """Worst acceleration share where the clock of the same law is merely slowed down and sped up, 100 % in 100 ms."""
    fine = 2e-5
    dense = np.array([pieces[0].start(), *(s.q for s in run_out(loaded(pieces, len(limits), fine), {}, 100_000))])
    clock, total, worst = fine * np.arange(len(dense)), fine * len(dense), 0.0
    t = np.arange(0.0, 2.0, lab.MS)
    for at in np.linspace(3 * lab.MS, total, starts, endpoint=False):
        speed = np.clip(1.0 - (t - at) / 0.1, 0.3, 1.0) + np.clip((t - at - 0.3) / 0.1, 0.0, 0.7)
        tau = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) * lab.MS])
        q = np.stack([np.interp(tau, clock, column) for column in dense.T], axis=1)
        worst = max(worst, lab.worst_shares(q, limits)[1])
    return worst


def reached(nominal: list[Sample], samples: list[Sample], at: int, share: float) -> float:
    """ms from the order until the way goes at this share of its full speed, or is at its end."""
    ways = np.array([s.s for s in nominal])
    speeds = np.gradient(ways) / lab.MS
    now = np.gradient(np.array([s.s for s in samples])) / lab.MS
    for n in range(at, len(samples)):
        full = float(np.interp(samples[n].s, ways, speeds))
        if now[n] <= share * full or samples[n].state is State.IDLE:
            return float(n - at)
    return float(len(samples) - at)


def curve_identity() -> Figure:
    """How far samples at any override, stop and retrace lie from the curve at full speed."""
    pieces, _ = pieces_of_u()
    dense = np.array([s.q for s in run_out(loaded(pieces, 3, 2e-5), {}, 100_000)])
    worst = 0.0
    dice = random.Random(8)
    for _ in range(6):
        stepper, samples = loaded(pieces, 3), []
        for _ in range(12):
            match dice.randint(0, 3):
                case 0:
                    stepper.set_override(dice.choice((0.05, 0.3, 0.6, 1.0)))
                case 1:
                    stepper.stop()
                case 2 if stepper.state is State.STOPPED:
                    stepper.retrace()
                case _:
                    stepper.resume()
            samples += [stepper.step().q for _ in range(dice.randint(5, 60))]
        worst = max(worst, *(_from_polyline(np.array(q), dense) for q in samples[::3]))
    return row("motion.curve_identity", worst * 1e6, "um", 1.0, "", 0.0)


def _from_polyline(q: Array, line_points: Array) -> float:
    """Distance from the polyline through dense points."""
    nearest = int(np.argmin(np.sum((line_points - q) ** 2, axis=1)))
    best = math.inf
    for a, b in itertools.pairwise(line_points[max(nearest - 1, 0) : nearest + 2]):
        step = b - a
        length = float(step @ step)
        u = min(max(float((q - a) @ step) / length, 0.0), 1.0) if length > 0 else 0.0
        best = min(best, float(np.linalg.norm(q - a - u * step)))
    return best


def step_costs(rounds: int = 12, every: int = 400) -> list[Figure]:
    """1 ms steps of the six-axis arm on LIN and corners, override changed every 400 ms."""
    legs, corners, limits = lab.u_arm(0.0125)
    path = assembled(legs, corners)
    pieces = timed_pieces(path, limits, jerk_limited(path, limits))
    costs: list[int] = []
    dice = random.Random(1)
    gc.collect()
    gc.disable()
    try:
        for _ in range(rounds):
            stepper = loaded(pieces, 6)
            clock = dice.randint(0, every)
            while stepper.state is not State.IDLE:
                clock += 1
                if clock % every == 0:
                    stepper.set_override(dice.choice((0.3, 0.6, 1.0)))
                begin = time.thread_time_ns()
                stepper.step()
                costs.append(time.thread_time_ns() - begin)
    finally:
        gc.enable()
    ordered = sorted(costs)
    return [
        row(
            "motion.path_step_p50",
            ordered[len(ordered) // 2] / 1000,
            "us of processor time",
            60.0,
            f"ruckig, frame, analytic IK ({RECORDED})",
            9.0,
        ),
        row(
            "motion.path_step_p99",
            ordered[int(len(ordered) * 0.99)] / 1000,
            "us of processor time",
            150.0,
            f"ruckig, frame, analytic IK ({RECORDED})",
            15.0,
        ),
    ]


def limits_kept(count: int = 60) -> list[Figure]:
    """Random chains of lines and corners of the portal: the worst set values at 1 ms, after their way through the ring's record."""
    dice, worst = random.Random(11), [0.0, 0.0, 0.0]
    limits = lab.portal_limits()
    for _ in range(count):
        pieces = random_pieces(dice, limits)
        q = np.array([pieces[0].start(), *(s.q for s in run_out(loaded(pieces, 3), {}))])
        worst = [max(a, b) for a, b in zip(worst, lab.worst_shares(q, limits), strict=True)]
    return [
        row("motion.path_limits_v", worst[0], "x limit", 1.0),
        row("motion.path_limits_a", worst[1], "x limit", 1.02, f"toppra, automatic grid ({RECORDED})", 1.63),
        row("motion.path_limits_j", worst[2], "x limit", 1.05, f"LinuxCNC #3773 ({RECORDED})", 8.1),
    ]


ALL: tuple[Callable[[], Figure | list[Figure]], ...] = (
    corner_dev,
    curve_identity,
    u_portal,
    u_6r,
    contour,
    topp_vs_toppra,
    ptp_vs_ruckig,
    override,
    singularity,
    step_costs,
    plan_ms,
    limits_kept,
)


def figures() -> list[Figure]:
    """All rows."""
    rows: list[Figure] = []
    for function in ALL:
        result = function()
        rows += result if isinstance(result, list) else [result]
    return rows


if __name__ == "__main__":
    for figure in figures():
        verdict = "met" if figure["met"] else "MISSED"
        print(f"{figure['figure']:28} {figure['value']:>12} {figure['unit']:16} goal {figure['goal']:<8} {verdict}")
