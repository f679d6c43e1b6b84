"""Speeding up and slowing down have limits of their own: judged by the differences of the set values at 1 ms."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hil_tests.lab.cells.arms import Array, portal, robot
from hil_tests.lab.judges.tool_speed import PERIOD_S, driven, sampled
from motion.planner.arm import Arm
from motion.planner.route import Route
from motion.planner.runs import make_run
from motion.planner.straight import straight_law
from motion.planner.trace import route_of, trace
from motion.program.blocks import Block, Interpolation, JointTarget, Pace, Program
from motion.program.factors import Factors
from motion.program.text.reader import read
from motion.timing.sine_square import sine_square
from motion.timing.two_ramps import TwoRamps, two_ramps

HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 0 0 0 0\n"
LINE = "linear pose 300 0 0 0 0 0\n"
CORNERS = "linear pose 200 0 0 0 0 0 radius=20\nlinear pose 200 150 0 0 0 0 radius=20\nlinear pose 0 150 60 0 0 0\n"
SPLINE = "spline pose 150 40 0 0 0 0\nspline pose 250 -40 20 0 0 0\nspline pose 400 0 0 0 0 0\n"
ARC = "circular via pose 100 60 0 0 0 0 to pose 200 0 0 0 0 0\n"
WAYS = {
    "line": LINE,
    "corners": CORNERS,
    "spline": SPLINE,
    "arc": ARC,
    "sine square": f"set shape=sin2\n{LINE}",
    "block slope": f"set slope=block\n{CORNERS}",
    "block slope of sine squares": f"set slope=block shape=sin2\n{CORNERS}",
}
PULLS = [(0.8, 3.2), (3.2, 0.8)]


def program(way: str, paces: str) -> Program:
    return read(f"{HEAD}set {paces}\n{way}")


def set_values(given: Program) -> Array:
    machine = robot(given.robot)
    found = route_of(given, machine)
    assert not found.faults, found.faults
    return trace(found.stretches, machine).q


def way_pulls(q: Array) -> tuple[float, float]:
    """Largest acceleration and deceleration of the tool of a portal, m/s2."""
    speed = np.linalg.norm(np.diff(q[:, :3], axis=0), axis=1) / PERIOD_S
    change = np.diff(speed) / PERIOD_S
    return float(change.max()), float(-change.min())


@pytest.mark.parametrize("pulls", PULLS)
@pytest.mark.parametrize("way", WAYS)
def test_the_way_speeds_up_with_pathaccel_and_slows_down_with_pathdecel(way: str, pulls: tuple[float, float]) -> None:
    up, down = pulls
    given = program(WAYS[way], f"path=600 pathaccel={up * 1e3} pathdecel={down * 1e3}")
    q = set_values(given)
    found = way_pulls(q)
    for got, asked in zip(found, pulls, strict=True):
        assert 0.95 * asked <= got <= 1.03 * asked
    least = min(pulls) * 1e3
    assert len(q) < len(set_values(program(WAYS[way], f"path=600 pathaccel={least} pathdecel={least}"))) - 50, "no smaller one for both"


@pytest.mark.parametrize("key", ("pathaccel", "pathdecel"))
def test_one_of_both_alone_leaves_the_other_to_the_axes(key: str) -> None:
    up, down = way_pulls(set_values(program(LINE, f"path=600 {key}=1500")))
    bound, free = (up, down) if key == "pathaccel" else (down, up)
    assert 1.45 <= bound <= 1.53 and free > 5.0


@pytest.mark.parametrize("pulls", PULLS)
def test_blocks_that_come_one_by_one_keep_both(pulls: tuple[float, float]) -> None:
    given = program(CORNERS, f"path=600 pathaccel={pulls[0] * 1e3} pathdecel={pulls[1] * 1e3}")
    speed, _, pull = driven(given, ahead=2)
    assert 0.5 < speed <= 1.001 and 0.9 <= pull <= 1.03


@pytest.mark.parametrize(("accel", "decel"), [(20, 80), (80, 20)])
@pytest.mark.parametrize("sign", (1, -1))
@pytest.mark.parametrize("kind", ("ptp", "corner"))
def test_axes_speed_up_with_accel_and_slow_down_with_decel_in_either_direction(kind: str, sign: int, accel: int, decel: int) -> None:
    more = "" if kind == "ptp" else f"ptp joints {700 + sign * 500} 200 0 0\n"
    head, rounding = HEAD.replace("start 0", "start 700"), "radius=30" if more else ""
    given = read(f"{head}set accel={accel} decel={decel}\nptp joints {700 + sign * 300} 0 0 0 {rounding}\n{more}")
    machine, x = robot("portal"), sign * set_values(given)[:, 0]
    change = np.diff(x, 2) / PERIOD_S**2 / machine.limits[0].accel
    assert 0.94 * accel <= 100 * change.max() <= 1.02 * accel
    assert 0.94 * decel <= -100 * change.min() <= 1.02 * decel


def test_an_arm_of_six_axes_keeps_both_along_its_way() -> None:
    head = "robot tx60-like\nangles val3\naxes deg deg deg deg deg deg\nstart 0 30 90 0 60 0\nptp pose 350 -150 200 180 0 0\n"
    lines = "linear pose 350 100 200 180 0 0 radius=30\nlinear pose 500 100 250 180 0 20 radius=30\nlinear pose 500 -150 300 180 0 0\n"
    given = read(f"{head}set path=500 pathaccel=700 pathdecel=2500\n{lines}")
    assert 0.9 <= sampled(given)[2] <= 1.02


def test_the_d_factor_of_the_rho_3_acts_on_braking_alone() -> None:
    found: list[tuple[float, float]] = []
    for factors in (Factors(1.0, 1.0, 1.0), Factors(1.0, 1.0, 0.25), Factors(1.0, 0.25, 1.0)):
        machine = portal()
        arm = Arm(machine, (0.0, 0.0, 0.0), PERIOD_S)
        arm.planner.factors = factors
        block: Block = read("robot portal\naxes mm mm mm\nstart 0 0 0\nptp joints 400 0 0\n").blocks[0]
        arm.add(replace(block))
        arm.finish()
        rows = [arm.joints]
        while not (arm.place().waiting == 0 and arm.resting and len(rows) > 10):
            rows.append(arm.step())
            assert len(rows) < 10_000
        change = np.diff(np.array(rows)[:, 0], 2) / PERIOD_S**2 / machine.limits[0].accel
        found.append((float(change.max()), float(-change.min())))
    (up, down), (same_up, slow_down), (slow_up, same_down) = found
    assert same_up == pytest.approx(up, rel=0.03) and slow_down == pytest.approx(0.25, rel=0.05)
    assert same_down == pytest.approx(down, rel=0.03) and slow_up == pytest.approx(0.25, rel=0.05)


@pytest.mark.parametrize("length", (1e-6, 1e-3, 0.05, 0.4, 3.0))
@pytest.mark.parametrize("pulls", [(0.5, 8.0), (8.0, 0.5), (3.0, 2.0), (2.0, 2.0)])
def test_closed_forms_meet_their_ends_and_limits(length: float, pulls: tuple[float, float]) -> None:
    speed, jerk = 1.2, 60.0
    for slope in (two_ramps(length, speed, pulls, jerk), sine_square(length, speed, pulls[0], jerk, pulls[1])):
        t = np.linspace(0.0, slope.duration, 40_001)
        h = float(t[1])
        s, v, a = slope.states(t).T
        assert s[0] == 0.0 and s[-1] == pytest.approx(length, rel=1e-9) and abs(v[-1]) < 1e-9
        assert np.diff(s).min() >= -1e-12 * length and v.max() <= speed * (1 + 1e-9)
        assert a.max() <= pulls[0] * (1 + 1e-9) and -a.min() <= pulls[1] * (1 + 1e-9)
        assert np.abs(np.diff(a)).max() / h <= jerk * (1 + 1e-6)
        assert np.abs(np.gradient(s, h)[1:-1] - v[1:-1]).max() < 1e-3 * v.max() + jerk * h * h
        assert np.abs(np.gradient(v, h)[2:-2] - a[2:-2]).max() < 1e-3 * np.abs(a).max() + 2 * jerk * h


def test_a_straight_run_of_two_strengths_has_its_closed_form() -> None:
    """No search: programs of many PTP blocks with accel and decel that differ are planned as quickly as others."""
    given, machine = read(f"{HEAD}set accel=30 decel=60\nptp joints 300 0 0 0\n"), robot("portal")
    law = straight_law(make_run(route_of(given, machine).stretches, machine))
    assert law is not None and math.isfinite(law.duration)


def test_a_law_of_two_ramps_is_not_worked_out_place_by_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 0.2 ms a place: 5 s of PTP took the planner 1 s in one go, and check a minute for what it then refused."""
    monkeypatch.setattr(TwoRamps, "at", lambda *_: pytest.fail("one place at a time"))
    machine = portal()
    route = Route(machine, (0.0, 0.0, 0.0))
    route.add(Block(Interpolation.PTP, JointTarget((1.0, 0.5, 0.0)), pace=Pace(speed=0.05, accel=0.2, decel=0.1)))
    route.finish()
    law = straight_law(make_run(route.take(), machine))
    assert law is not None and law.s[0] == 0.0 and law.speed[0] == law.speed[-1] == 0.0
    rates = np.gradient(law.speed, law.step)
    assert rates.max() == pytest.approx(law.accel.max(), rel=1e-3) and rates.min() == pytest.approx(law.accel.min(), rel=1e-3)
    assert law.accel.max() == pytest.approx(-2.0 * law.accel.min(), rel=1e-9)


def test_an_overlap_of_two_ramps_is_worked_out_at_all_its_places_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    at, places = TwoRamps.at, []

    def counted(ramps: TwoRamps, t: float) -> tuple[float, float, float]:
        places.append(t)
        return at(ramps, t)

    monkeypatch.setattr(TwoRamps, "at", counted)
    given = read(f"{HEAD}set slope=block accel=30 decel=60\n{CORNERS}")
    assert len(route_of(given, robot("portal")).stretches) == 5
    assert len(places) < 400
