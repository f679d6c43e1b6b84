"""Blocks that take minutes: as many pieces as a ring and a follower hold, and the same way, speed and limits as ever.  AX-606."""

import numpy as np
import pytest

from gateway.pure.reasons import CommandState
from hil_tests.lab.answers import answers
from hil_tests.lab.arms import Array, portal, robot, run, tool_path, tool_speed
from hil_tests.lab.belt_bench import CELL
from hil_tests.lab.planned_bench import Planned, ServodynRobot
from motion import follower
from motion.errors import MotionError
from motion.follower import WAITING
from motion.planner import commit
from motion.planner.arm import Arm
from motion.planner.commit import LONGEST_S, MOST
from motion.planner.planner import Planner
from motion.program.text import read

HEAD = "robot portal\naxes mm mm mm\nstart 0 0 0\n"
ARC = """robot tx60-like
angles val3
start 0 30 90 0 60 0
ptp pose 350 -150 200 180 0 0
circular via pose 450 0 200 180 0 0 to pose 350 150 200 180 0 0 path=12
"""


def added(arm: Arm | Planner, text: str) -> None:
    for block in read(text).blocks:
        arm.add(block)
    arm.finish()


@answers
def test_a_line_of_a_minute_and_thirty_slow_ones_are_run_to_their_end_at_their_speed() -> None:
    once = "linear pose 300 0 0 0 0 0 path=5\n"
    many = "".join(f"linear pose {10 * k} 0 0 0 0 0 path=5\n" for k in range(1, 31))
    for text, least in ((once, 60.0), (many, 60.0)):
        arm = Arm(portal(), (0.0, 0.0, 0.0), 20e-3)
        added(arm, HEAD + text)
        rows = run(arm, limit_s=62.0)
        assert rows[-1] == pytest.approx([0.3, 0.0, 0.0], abs=1e-9) and len(rows) * 20e-3 >= least
        assert np.abs(np.diff(rows[:, 0]) / 20e-3).max() == pytest.approx(5e-3, rel=2e-5)


@answers
def test_a_cell_runs_a_line_of_half_a_minute() -> None:
    cell = Planned(ServodynRobot(cell=CELL))
    assert cell.bench.settle(cell.order("robot portal\naxes mm mm mm deg\nptp joints 100 100 50 0\n")).state is CommandState.DONE
    began = cell.bench.now
    job = cell.bench.settle(cell.order("robot portal\naxes mm mm mm deg\nlinear joints 350 100 50 0 path=10\n"), 40.0)
    assert job.state is CommandState.DONE, job.detail
    assert cell.bench.set() == pytest.approx([350, 100, 50, 0], abs=1e-6) and (cell.bench.now - began) / 1e9 < 27.0


def arc_rows(orders: dict[int, float], count: int) -> Array:
    """(count + 1, axes) of the arm along the slow arc; orders: override from which step on."""
    machine = robot("tx60-like")
    arm = Arm(machine, read(ARC).start)
    added(arm, ARC)
    rows = [arm.joints]
    for k in range(count):
        arm.override = orders.get(k, arm.override)
        rows.append(arm.step())
    return np.array(rows)


def test_a_slow_arc_takes_an_eighth_of_the_room_and_no_set_value_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    planner = Planner(robot("tx60-like"), read(ARC).start)
    added(planner, ARC)
    pieces = [piece for _ in range(2) for piece in planner.plan(planner.end, hurry=True)]
    durations = [piece.duration for piece in pieces]
    assert len(pieces) < WAITING / 8 and sum(durations) > 30.0 and 0.2 < max(durations) <= LONGEST_S
    thinned = arc_rows({}, 6_000)
    monkeypatch.setattr(commit, "PLENTY", WAITING)
    monkeypatch.setattr(commit, "MOST", 3 * WAITING)
    monkeypatch.setattr(follower, "WAITING", 3 * WAITING)
    assert np.abs(thinned - arc_rows({}, 6_000)).max() < 1e-9


@answers
def test_a_slow_arc_is_slowed_down_stopped_and_gone_on_with_inside_the_limits_and_on_its_circle() -> None:
    inner = arc_rows({8_000: 0.3, 9_000: 1.0, 11_000: 0.0, 12_000: 1.0}, 14_000)[3_000:-10]
    machine = robot("tx60-like")
    for order, name, most in ((1, "speed", 1.0), (2, "accel", 1.02), (3, "jerk", 1.05)):
        limits = np.array([getattr(axis, name) for axis in machine.limits])
        assert float(np.max(np.abs(np.diff(inner, order, axis=0)) / 1e-3**order / limits)) <= most, name
    places = tool_path(machine, inner)
    speed = tool_speed(places, 1e-3)
    assert np.ptp(speed[:3_000]) < 1e-6 * speed[0] and speed[8_500:8_900].max() < 1e-9, "steady, and at rest"
    assert speed[0] == pytest.approx(12e-3, rel=2e-4), "as programmed: what the grid of 2 ms shows at its end slows that alone"
    centre, radius = _circle()
    assert np.abs(np.hypot(*(places[:, :2] - centre).T) - radius).max() < 1e-6


def _circle() -> tuple[Array, float]:
    """Through (350, -150), (450, 0), (350, 150) mm."""
    x = (450.0**2 - 350.0**2 - 150.0**2) / (2 * (450.0 - 350.0))
    return np.array([x, 0.0]) * 1e-3, (450.0 - x) * 1e-3


def test_what_takes_longer_than_the_ring_holds_is_refused_in_words() -> None:
    machine = portal()
    planner = Planner(machine, (0.0, 0.0, 0.0))
    added(planner, HEAD + "linear pose 300 0 0 0 0 0 path=0.5\n")
    with pytest.raises(MotionError, match=r"a motion of 600 s without a stop is too long, [34]\d\d s are possible here: run it faster"):
        planner.plan(0.0, hurry=True)
    assert MOST < WAITING
