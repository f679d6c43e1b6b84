"""Figures of the stepper on whole paths (motion.md E): changes of speed, stops, ways back, limits kept, what a step costs."""

import itertools
import math
import random
import statistics
import time
from dataclasses import dataclass, field

import numpy as np
import ruckig
from numpy.typing import NDArray

from hil_tests.bench.figure_row import RECORDED, Figure, row
from hil_tests.bench.step_costs import cost_rows
from hil_tests.lab.cells import motion_paths as lab
from motion.execution.stepper import Sample, State, Stepper
from motion.execution.timed import TimedPiece
from motion.geometry.limits import AxisLimits
from motion.paths.corner import corner
from motion.paths.line import line
from motion.planner.commit import timed_pieces
from motion.timing.choice import Rounded, assembled
from motion.timing.foresight import Foresight
from motion.timing.jerk import jerk_limited
from motion.timing.limits import law_limits

Array = NDArray[np.float64]


def pieces_of_u() -> tuple[list[TimedPiece], list[AxisLimits]]:
    """The U of the portal with R 12.5 mm as pieces."""
    limits = lab.portal_limits()
    legs, corners = lab.u_portal(0.0124999)
    path, bounds = assembled(legs, corners), law_limits(limits)
    return timed_pieces(path, bounds, jerk_limited(path, bounds)), limits


def loaded(pieces: list[TimedPiece], axes: int, period_s: float = lab.MS, foresight: type[Foresight] = Foresight) -> Stepper:
    stepper = Stepper(axes, period_s, pieces[0].start(), foresight)
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
    on_u = statistics.median(found.times)
    for _ in range(chains):
        found.add(random_pieces(dice, limits, 3), limits, 5)
    scaled = _time_scaling(pieces, limits, starts)
    what = f"{len(found.times)} starts, U and {chains} random chains"
    return [
        row("motion.override_a", found.accel, f"x limit, {what}", 1.02, "time scaling on the U, 100 ms ramp, same run", scaled[0]),
        row("motion.override_j", found.jerk, f"x limit, {what}", 1.10, "time scaling on the U, 100 ms ramp, same run", scaled[1]),
        row("motion.override_ms", max(found.times), f"ms, {what}", 120.0, f"second order, worst on the U ({RECORDED})", 99.0),
        row("motion.override_median_ms", on_u, f"ms, {starts} starts on the U", 50.0, f"second order, median on the U ({RECORDED})", 39.0),
    ]


def _time_scaling(pieces: list[TimedPiece], limits: list[AxisLimits], starts: int) -> tuple[float, float]:
    """Worst shares of acceleration and jerk where the clock of the same law is merely slowed down and sped up, 100 % in 100 ms."""
    fine = 2e-5
    dense = np.array([pieces[0].start(), *(s.q for s in run_out(loaded(pieces, len(limits), fine), {}, 100_000))])
    clock, total, accel, jerk = fine * np.arange(len(dense)), fine * len(dense), 0.0, 0.0
    t = np.arange(0.0, 2.0, lab.MS)
    for at in np.linspace(3 * lab.MS, total, starts, endpoint=False):
        speed = np.clip(1.0 - (t - at) / 0.1, 0.3, 1.0) + np.clip((t - at - 0.3) / 0.1, 0.0, 0.7)
        tau = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) * lab.MS])
        q = np.stack([np.interp(tau, clock, column) for column in dense.T], axis=1)
        _, more_accel, more_jerk = lab.worst_shares(q, limits)
        accel, jerk = max(accel, more_accel), max(jerk, more_jerk)
    return accel, jerk


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


def stop_time(starts: int = 33) -> Figure:
    """Stops on a line of 300 mm, from the order to rest, against the shortest there is from the same speed and acceleration (ruckig)."""
    limits = lab.portal_limits()
    path, bounds = lab.portal_path(line(lab.point(0.0, 0.0, 0.0), lab.point(0.3, 0.0, 0.0))), law_limits(limits)
    pieces = timed_pieces(path, bounds, jerk_limited(path, bounds))
    x = np.array([0.0, *(sample.q[0] for sample in run_out(loaded(pieces, 3), {}))])
    speed = np.gradient(x) / lab.MS
    accel, ratios, late = np.gradient(speed) / lab.MS, [], 0.0
    for at in (int(each) for each in np.linspace(0.02 * len(x), 0.98 * len(x), starts)):
        rows = np.array([sample.q[0] for sample in run_out(loaded(pieces, 3), {at: 0.0}, 2 * len(x))])
        taken = (next(n for n in range(at, len(rows)) if abs(rows[n] - rows[-1]) < 1e-9) - at) * lab.MS
        least = _shortest(limits[0], float(speed[at]), float(accel[at]))
        ratios.append(taken / least)
        late = max(late, taken - least)
    what = f"x shortest, median of {starts} stops, {late * 1e3:.0f} ms more at worst"
    return row("motion.stop_time", statistics.median(ratios), what, 1.05, "ruckig, same run", 1.0)


def _shortest(axis: AxisLimits, speed: float, accel: float) -> float:
    """Seconds of the shortest stop from this state."""
    asked, made = ruckig.InputParameter(1), ruckig.Trajectory(1)
    asked.control_interface = ruckig.ControlInterface.Velocity
    asked.current_velocity, asked.current_acceleration, asked.target_velocity = [speed], [accel], [0.0]
    asked.max_velocity, asked.max_acceleration, asked.max_jerk = [2.0 * axis.speed], [1.02 * axis.accel], [axis.jerk]
    ruckig.Ruckig(1).calculate(asked, made)
    return float(made.duration)


def curve_identity() -> Figure:
    """How far samples at any override, stop and retrace lie from the curve at full speed."""
    pieces, _ = pieces_of_u()
    dense = np.array([s.q for s in run_out(loaded(pieces, 3, 2e-5), {}, 100_000)])
    worst = 0.0
    plain = max(_from_polyline(np.array(s.q), dense) for s in run_out(loaded(pieces, 3), {}))
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
    return row("motion.curve_identity", worst * 1e6, "um", 1.0, "at full speed, judged alike, same run", plain * 1e6)


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


def step_costs(rounds: int = 12, repeats: int = 3) -> list[Figure]:
    """1 ms steps of the six-axis arm on LIN and corners, override changed every 400 ms.

    Each round is run `repeats` times and the median of each period counts.
    """
    legs, corners, limits = lab.u_arm(0.0125)
    path = assembled(legs, corners)
    pieces = timed_pieces(path, limits, jerk_limited(path, limits))
    anchor = f"ruckig, frame, analytic IK ({RECORDED})", 9.0, 15.0
    return cost_rows("motion.path_step", anchor, rounds, repeats, lambda n, foresight: _periods(pieces, n, foresight))


def _periods(pieces: list[TimedPiece], seed: int, foresight: type[Foresight], every: int = 400) -> list[int]:
    """ns of each period; the same seed changes the override in the same ones."""
    dice, stepper = random.Random(seed), loaded(pieces, 6, foresight=foresight)
    clock, costs = dice.randint(0, every), []
    while stepper.state is not State.IDLE:
        clock += 1
        if clock % every == 0:
            stepper.set_override(dice.choice((0.3, 0.6, 1.0)))
        begin = time.thread_time_ns()
        stepper.step()
        costs.append(time.thread_time_ns() - begin)
    return costs


def limits_kept(count: int = 60) -> list[Figure]:
    """Random chains of lines and corners of the portal: the worst set values at 1 ms, after their way through the ring's record."""
    dice, worst = random.Random(11), [0.0, 0.0, 0.0]
    limits = lab.portal_limits()
    for _ in range(count):
        pieces = random_pieces(dice, limits)
        q = np.array([pieces[0].start(), *(s.q for s in run_out(loaded(pieces, 3), {}))])
        worst = [max(a, b) for a, b in zip(worst, lab.worst_shares(q, limits), strict=True)]
    return [
        row("motion.path_limits_v", worst[0], "x limit", 1.0, "the limit", 1.0),
        row("motion.path_limits_a", worst[1], "x limit", 1.02, f"toppra, automatic grid ({RECORDED})", 1.63),
        row("motion.path_limits_j", worst[2], "x limit", 1.05, f"LinuxCNC #3773 ({RECORDED})", 8.1),
    ]
