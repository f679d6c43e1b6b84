"""All figures of the motion core, in one list: what a step costs, whole programs through planner and follower, streams of short
segments, and the rows of paths and times (motion_figures), of belts (belt_figures) and of kinematics (kinematics_bench).

Reference of the step costs: one bare ruckig sample (`Trajectory.at_time`, one degree of freedom), the least any stepper on ruckig can
cost.  Shares of limits are taken from set values at 1 ms by finite differences.
"""

import math
import random
import time
from collections.abc import Callable, Mapping, Sequence

import ruckig

from gateway.tools.progress import steps as shown
from hil_tests.bench import belt_figures, kinematics_bench, motion_figures
from hil_tests.bench.step_costs import cost_rows, median_of, percentile, uncollected
from hil_tests.lab.cells import arms
from hil_tests.lab.judges.tool_speed import random_blocks, streamed
from hil_tests.lab.virtual.contour import SPEED, stream
from motion.execution.follower import Follower
from motion.execution.ptp import plan_ptp
from motion.execution.stepper import State, Stepper
from motion.execution.timed import TimedPiece
from motion.geometry.frames import NO_ROTATION, Pose
from motion.geometry.limits import AxisLimits
from motion.planner.arm import Arm
from motion.planner.planner import Planner
from motion.planner.robot import Machine
from motion.program.blocks import Blend, Block, Interpolation, JointTarget, Pace, PoseTarget, Rounding
from motion.timing.foresight import Foresight

P5 = 0.004
Figure = dict[str, str | float | bool]


def step_costs(steps: int, change: float, seed: int = 1) -> tuple[list[int], list[int]]:
    """(ns of steps that only sample, ns of steps right after a change) over random moves; change: probability per step."""
    dice = random.Random(seed)
    limits = [AxisLimits(f"A{n}", -10, 10, 2 + 0.2 * n, 10, 100) for n in range(6)]
    stepper, here = Stepper(6, P5), [0.0] * 6
    plain: list[int] = []
    planned: list[int] = []
    while len(plain) + len(planned) < steps:
        there = [dice.uniform(-9, 9) for _ in limits]
        stepper.load(plan_ptp(here, there, limits))
        here, fresh = there, True
        while stepper.state is not State.IDLE:
            if dice.random() < change:
                stepper.set_override(dice.choice((0.1, 0.3, 0.6, 1.0)))
                fresh = True
            begin = time.perf_counter_ns()
            stepper.step()
            (planned if fresh else plain).append(time.perf_counter_ns() - begin)
            fresh = False
    return plain, planned


def bare_sample_us(count: int = 20_000) -> float:
    """Median of one ruckig sample."""
    wish, answer = ruckig.InputParameter(1), ruckig.Trajectory(1)
    wish.target_position, wish.max_velocity, wish.max_acceleration, wish.max_jerk = [1.0], [1.0], [2.0], [10.0]
    ruckig.Ruckig(1).calculate(wish, answer)
    sample: Callable[[float], object] = answer.at_time
    costs = []
    for _ in range(count):
        begin = time.perf_counter_ns()
        sample(0.3)
        costs.append(time.perf_counter_ns() - begin)
    return percentile(costs, 0.5)


def row(figure: str, value: float, unit: str, goal: float, reference: str, reference_value: float, *, least: bool = False) -> Figure:
    """One line; least: the goal is a lower bound."""
    ratio = value / reference_value if reference_value else float(value == reference_value)
    met = value >= goal if least else value <= goal
    return {
        "figure": figure,
        "value": round(value, 4),
        "unit": unit,
        "reference": reference,
        "reference_value": reference_value,
        "ratio": round(ratio, 3),
        "goal": goal,
        "met": met,
    }


def random_program(dice: random.Random, machine: Machine) -> list[Block]:
    """Four to eight moves of a portal: lines and PTP, half of them rounded, at all speeds."""
    blocks = []
    for _ in range(dice.randint(4, 8)):
        place = tuple(dice.uniform(-0.3, 0.3) for _ in range(3))
        size = dice.choice((0.0, 0.005, 0.02, 0.05))
        blend = Blend(Rounding.CARTESIAN, size, size) if size else Blend()
        if dice.random() < 0.3:
            blocks.append(Block(Interpolation.PTP, JointTarget(place), pace=Pace(dice.uniform(0.2, 1.0)), blend=blend))
        else:
            target = PoseTarget(Pose((place[0], place[1], place[2]), NO_ROTATION))
            blocks.append(Block(Interpolation.LINEAR, target, pace=Pace(path_speed=dice.uniform(0.1, 2.0)), blend=blend))
    return blocks


def limits_of_programs(count: int) -> list[Figure]:
    """Set values of random programs, planned whole and run by the follower at 1 ms; `make soak` drives 1,000 of them."""
    dice, machine, worst = random.Random(4), arms.portal(), [0.0, 0.0, 0.0]
    for _ in range(count):
        arm = Arm(machine, (0.0, 0.0, 0.0), 1e-3)
        for block in random_program(dice, machine):
            arm.add(block)
        arm.finish()
        found = arms.shares(machine, arms.run(arm), 1e-3)
        worst = [max(pair) for pair in zip(worst, found, strict=True)]
    anchors = (
        ("v", 1.0, "joints of the plan, at most", 1.0),
        ("a", 1.02, "toppra, automatic grid (recorded)", 1.63),
        ("j", 1.05, "LinuxCNC #3773 (recorded)", 8.1),
    )
    return [
        row(f"motion.limits_{name}", worst[k], f"x limit, {count} programs", goal, text, ref)
        for k, (name, goal, text, ref) in enumerate(anchors)
    ]


def limits_of_tool(count: int = 4) -> list[Figure]:
    """The tool against the path speed and the acceleration of each block, over random lines of all speeds that come one by one."""
    dice, machine = random.Random(6), arms.portal()
    found = [streamed(random_blocks(dice), machine, (0.0, 0.0, 0.0), 3) for _ in range(count)]
    unit, reference = f"x programmed, {count} programs", "way as one quintic a corner, caps of the mean's own place (AX-380, recorded)"
    return [
        row("motion.limits_tcp", max(speed for speed, _, _ in found), unit, 1.001, reference, 2.49),
        row("motion.limits_tcp_a", max(accel for _, _, accel in found), unit, 1.02, reference, 1.65),
    ]


def streams(count: int) -> list[Figure]:
    """Short segments: starving, the processor time of one second of motion, and how far ahead the planner looks."""
    begin = time.process_time()
    found = stream(count, 0.004)
    cost = (time.process_time() - begin) / found.seconds
    return [
        row("motion.stream_starved", float(found.starved), f"periods, {count} segments", 0.0, "none", 0.0),
        row("motion.stream_look_ahead", float(found.waiting), "blocks", 256.0, "Beckhoff", 128.0, least=True),
        row("motion.stream_cpu", cost, "s a second of motion", 0.5, "real time", 1.0),
        row("motion.stream_slowest", found.slowest / SPEED, "of the path speed", 0.5, "stopping at each point", 0.0, least=True),
    ]


def cycle_costs(steps: int = 20_000, repeats: int = 3) -> list[Figure]:
    """A whole period: follower on a line of the six-axis arm with override changes, frame shifted as a belt would, inverse, travel."""
    machine = arms.robot("tx60-like")
    start: tuple[float, ...] = (0.0, 0.5, 1.5, 0.0, 1.0, 0.0)
    here = machine.kinematics.forward(start)
    x, y, z = here.position
    planner = Planner(machine, start)
    for dy in (0.1, -0.1, 0.0):
        planner.add(Block(Interpolation.LINEAR, PoseTarget(Pose((x, y + dy, z), here.rotation)), pace=Pace(path_speed=0.25)))
    pieces = planner.plan(0.0, hurry=True)
    rounds = math.ceil(steps / len(driven(machine, start, pieces, 0, Foresight)))
    with uncollected():
        bare = median_of(repeats, lambda: bare_cycle(machine, start))
    reference = "ruckig along a line, frame, inverse, same run", percentile(bare, 0.5), percentile(bare, 0.99)
    return cost_rows("motion.step", reference, rounds, repeats, lambda seed, foresight: driven(machine, start, pieces, seed, foresight))


def driven(
    machine: Machine, start: tuple[float, ...], pieces: Sequence[TimedPiece], seed: int, foresight: type[Foresight] = Foresight
) -> list[int]:
    """ns of each period of the three lines; the same seed changes the override in the same periods."""
    dice, follower, near, wanted, ended = random.Random(seed), Follower(6, 1e-3, foresight), start, 1.0, False
    for piece in pieces:
        follower.load(piece)
    costs: list[int] = []
    while not ended:
        if dice.random() < 0.02:
            wanted = dice.choice((0.3, 0.6, 1.0))
        begin = time.thread_time_ns()
        progress = follower.step(wanted)
        pose = machine.kinematics.forward(progress.places[:6])
        a, b, c = pose.position
        near = machine.kinematics.inverse(Pose((a + 1e-3, b, c), pose.rotation), near)
        inside = all(axis.lower <= value <= axis.upper for axis, value in zip(machine.limits, near, strict=True))
        costs.append(time.thread_time_ns() - begin)
        assert inside
        ended = progress.at_end
    return costs


def bare_cycle(machine: Machine, start: tuple[float, ...], count: int = 4000) -> list[int]:
    """The least such a period can cost: a ruckig sample, a point of a line, a frame, the inverse; no orders, no checks."""
    wish, answer = ruckig.InputParameter(1), ruckig.Trajectory(1)
    wish.target_position, wish.max_velocity, wish.max_acceleration, wish.max_jerk = [0.1], [0.25], [2.0], [50.0]
    ruckig.Ruckig(1).calculate(wish, answer)
    here, near = machine.kinematics.forward(start), start
    shift = Pose((1e-3, 0.0, 0.0), NO_ROTATION)
    costs = []
    for n in range(count):
        begin = time.thread_time_ns()
        (s,), _, _ = answer.at_time(answer.duration * (n % 1000) / 1000)
        x, y, z = here.position
        near = machine.kinematics.inverse(shift @ Pose((x, y + s, z), here.rotation), near)
        costs.append(time.thread_time_ns() - begin)
    return costs


def run(steps: int = 100_000, programs: int = 60, segments: int = 15_000) -> list[Figure]:
    """All figures, as `axisgate bench motion` prints them; `make soak` drives 1,000 programs and streams 150,000 segments."""
    parts: tuple[Callable[[], Sequence[Mapping[str, str | float | bool]]], ...] = (
        lambda: step_figures(steps),
        cycle_costs,
        lambda: limits_of_programs(programs),
        limits_of_tool,
        lambda: streams(segments),
        motion_figures.figures,
        belt_figures.figures,
        kinematics_bench.run,
    )
    return [dict(figure) for part in shown("motion", parts) for figure in part()]


def step_figures(steps: int) -> list[Figure]:
    """The stepper alone, on PTP pieces."""
    with uncollected():
        plain, planned = step_costs(steps, 0.05)
        bare = bare_sample_us()
    both = plain + planned
    rows = (
        ("motion.ptp_step_median", percentile(both, 0.5), 15.0),
        ("motion.ptp_step_p99", percentile(both, 0.99), 60.0),
        ("motion.ptp_replan_p99", percentile(planned, 0.99), 60.0),
    )
    return [
        {
            "figure": name,
            "value": round(value, 2),
            "unit": "us",
            "reference": "one bare ruckig sample, median",
            "reference_value": round(bare, 2),
            "ratio": round(value / bare, 2),
            "goal": goal,
            "met": value <= goal,
        }
        for name, value, goal in rows
    ]


if __name__ == "__main__":
    for figure in run():
        print(figure)
