"""What a step of the motion core costs: six axes, override changes now and then, and the rare step that re-plans.

Reference: one bare ruckig sample (`Trajectory.at_time`, one degree of freedom), the least any stepper on ruckig can cost.
"""

import gc
import random
import time
from collections.abc import Callable

import ruckig

from motion.limits import AxisLimits
from motion.ptp import plan_ptp
from motion.stepper import State, Stepper

P5 = 0.004
Figure = dict[str, str | float | bool]


def percentile(values: list[int], share: float) -> float:
    """Microseconds."""
    return sorted(values)[min(int(len(values) * share), len(values) - 1)] / 1000


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


def run(steps: int = 100_000) -> list[Figure]:
    """The figures, as `axisgate bench` prints them."""
    gc.collect()
    gc.disable()
    try:
        plain, planned = step_costs(steps, 0.05)
        bare = bare_sample_us()
    finally:
        gc.enable()
    both = plain + planned
    rows = (
        ("motion.step_median", percentile(both, 0.5), 15.0),
        ("motion.step_p99", percentile(both, 0.99), 60.0),
        ("motion.replan_p99", percentile(planned, 0.99), 60.0),
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
