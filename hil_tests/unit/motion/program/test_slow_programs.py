"""Blocks that take minutes: as many pieces as a ring and a follower hold, and the same way, speed and limits as ever.  AX-606."""

import gc
import os
import pathlib
import random
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from gateway.cell_file.load import load_cell
from gateway.commands.motion import main, team_of_program
from gateway.files.find import find_config, read_text
from gateway.pure.cycle.core import CycleLogic
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.planner import Part, PieceRecord
from gateway.tools.motion.dry_run import sections_of
from gateway.tools.motion.dry_run_team import team_findings
from hil_tests.lab.cells.arms import Array, portal, robot, run, tool_path, tool_speed
from hil_tests.lab.virtual.belt_bench import CELL
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot
from motion.errors import MotionError
from motion.execution import follower
from motion.execution.follower import WAITING
from motion.execution.stepper import State, Stepper
from motion.execution.timed import decode_any
from motion.planner import commit
from motion.planner.arm import Arm
from motion.planner.commit import LONGEST_S, MOST, PLENTY, timed_pieces
from motion.planner.duration_check import too_long
from motion.planner.path_checks import Slowed
from motion.planner.planner import Planner
from motion.planner.quick_law import swift, width_s
from motion.planner.route import Route
from motion.planner.runs import runs
from motion.planner.trace import route_of
from motion.program.errors import BlockError
from motion.program.text.reader import read
from motion.program.text.team import read_team
from motion.timing.limiter import TooFast
from protocols.base.machine import ms

TEAM = """kinematic left portal
axes mm mm mm deg
start 0 0 0 0
kinematic right portal
axes mm mm mm deg
start 0 0 0 0
kinematic left
mach_pos joints 0 0 0 0
move left linear pose 100 0 0 0 0 0 and right ptp joints 100 0 0 0
move left linear pose 400 0 0 0 0 0 path=10 blend=off and right linear pose 400 0 0 0 0 0 path=20
"""
WHOLE = "AXISGATE_WHOLE_CURVE" in os.environ  # `make soak`
LESS_TIME = 1.0 if WHOLE else 0.25  # a quarter has more pieces than stay as they are (commit.PLENTY), too
STEP_S = 20e-3
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


def test_a_line_of_a_minute_and_thirty_slow_ones_are_run_to_their_end_at_their_speed() -> None:
    once = "linear pose 300 0 0 0 0 0 path=5\n"
    many = "".join(f"linear pose {10 * k} 0 0 0 0 0 path=5\n" for k in range(1, 31))
    for text, least in ((once, 60.0), (many, 60.0)):
        arm = Arm(portal(), (0.0, 0.0, 0.0), 20e-3)
        added(arm, HEAD + text)
        rows = run(arm, limit_s=62.0)
        assert rows[-1] == pytest.approx([0.3, 0.0, 0.0], abs=1e-9) and len(rows) * 20e-3 >= least
        assert np.abs(np.diff(rows[:, 0]) / 20e-3).max() == pytest.approx(5e-3, rel=2e-5)


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
    thinned = arc_rows({}, 3_000)
    monkeypatch.setattr(commit, "PLENTY", WAITING)
    monkeypatch.setattr(commit, "MOST", 3 * WAITING)
    monkeypatch.setattr(follower, "WAITING", 3 * WAITING)
    assert np.abs(thinned - arc_rows({}, 3_000)).max() < 1e-9


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


def test_no_piece_lasts_longer_than_the_cycle_looks_at_at_once() -> None:
    """A law of very slow blocks has a wide grid; its nodes put together stay within the time of a piece."""
    machine = robot("tx60-like")
    route = Route(machine, read(ARC).start)
    for block in read(ARC.replace("path=12", "path=60")).blocks:
        route.add(block)
    route.finish()
    run = runs(route.take(), machine)[1]
    law = swift(run.path, run.limits, width_s(run.limits)).law
    for slower in (8.0, 30.0):
        slow = replace(law, step=slower * law.step, speed=law.speed / slower, accel=law.accel / slower**2)
        durations = [piece.duration for piece in timed_pieces(run.path, run.limits, slow)]
        assert sum(durations) == pytest.approx(slow.duration) and 0.2 < max(durations) <= LONGEST_S


SLOW = """robot portal
axes mm mm mm deg
start 0 0 0 0
set blend=off
linear pose 300 0 0 0 0 0
linear pose 0 0 0 0 0 0
linear pose 300 0 0 0 0 0 path=10
ptp joints 0 0 0 0 %s
linear pose 200 0 0 0 0 0 path=10
"""
LESS = 36  # pieces


def test_check_and_plot_report_it_of_every_block_before_anything_moves_and_in_the_words_of_the_planner(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    program, page = tmp_path / "it.txt", tmp_path / "it.html"
    program.write_text(SLOW % "")
    assert main(["check", str(program)]) == 0
    monkeypatch.setattr(commit, "MOST", LESS)
    planner = Planner(robot("portal"), (0.0,) * 4)
    added(planner, SLOW % "")
    with pytest.raises(BlockError, match=r"block 3: a motion of 30 s without a stop is too long, 1\d s are possible here") as told:
        list(iter(lambda: planner.plan(planner.end, hurry=True), []))
    capsys.readouterr()
    for what in ("check", "plot"):
        assert main([what, str(program), "--out", str(page)]) == 1 and not page.exists()
        lines = capsys.readouterr().out.splitlines()
        assert lines[0] == f"line 7: {told.value}" and lines[1].startswith("line 9: block 5: a motion of 20 s without a stop is too long")


def test_check_reports_it_of_several_kinematics(monkeypatch: pytest.MonkeyPatch) -> None:
    program = read_team(TEAM)
    machines = team_of_program(program, None)
    assert team_findings(program, machines).faults == ()
    monkeypatch.setattr(commit, "MOST", LESS)
    (fault,) = team_findings(program, machines).faults
    assert str(fault).startswith("block 2: a motion of 30 s without a stop is too long")


def test_a_cell_names_line_and_block_of_the_program_behind_a_part_that_ended_with_its_input(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(commit, "MOST", PLENTY)
    cell = Planned(ServodynRobot(cell=CELL))
    text = (SLOW % "until=464").replace("start 0 0 0 0\n", "").replace("path=10\nptp", "path=600\nptp").replace("path=10", "path=2")
    job = cell.bench.settle(cell.order(text), 40.0)
    assert job.state is CommandState.ABORTED and "line 8: block 5: a motion of 100 s without a stop is too long" in job.detail
    assert cell.bench.set() == pytest.approx([0, 0, 0, 0], abs=1e-6)


def test_what_an_axis_slows_down_is_also_reported_in_front_of_mach_pos() -> None:
    slowed: dict[int, Slowed] = {}
    text = "axes mm mm mm deg\nstart 50 50 50 0\nlinear pose 450 50 50 0 0 0 path=9000\nmach_pos joints 0 0 0 0\nptp joints 1 0 0 0\n"
    sections_of(read(text), replace(robot("portal"), too_fast=TooFast.WARN), (), slowed=slowed)
    assert list(slowed) == [1]


def test_what_would_take_endless_is_reported_and_no_law_is_tried() -> None:
    """rates and times of the text's own ranges: a law of a day has more points than a machine has memory."""
    arc = ARC.replace("path=12", "path=0.001")
    for text in (
        arc,
        arc.replace("path=0.001", "pathaccel=0.001"),
        arc.replace("path=0.001", "time=1000000"),
        arc.replace("path=0.001", "path=0.001 shape=sin2"),
        ARC.replace("circular via pose 450 0 200 180 0 0 to", "linear").replace("path=12", "path=0.001"),
        ARC.replace("circular via pose 450 0 200 180 0 0 to", "spline pose 400 0 200 180 0 0\nspline").replace("path=12", "path=0.001"),
    ):
        faults = sections_of(read(text), robot("tx60-like"), ())[1]
        assert len(faults) == 1 and "s without a stop is too long" in str(faults[0]), text


LINES = 200 if WHOLE else 140  # with their corners more than one law spans (planner.WINDOW)


def rounded_lines(count: int) -> str:
    """Lines of 20 .. 170 mm in a box, as fast as the axes go, with radii of 10 mm."""
    chance, (x, y, z) = random.Random(3), (0.0, 0.0, 0.0)
    lines = ["robot tx60-like", "angles val3", "start 0 30 90 0 60 0", "set radius=10"]
    while len(lines) < count + 4:
        dx, dy, dz = (chance.uniform(-100, 100) for _ in range(3))
        if abs(x + dx) < 80 and abs(y + dy) < 80 and abs(z + dz) < 50:
            x, y, z = x + dx, y + dy, z + dz
            lines.append(f"linear rel pose {dx:.3f} {dy:.3f} {dz:.3f} 0 0 0")
    return "\n".join(lines)


@pytest.mark.timeout(900)
def test_many_rounded_lines_known_at_once_are_handed_on_in_parts_as_those_known_one_by_one() -> None:
    program, machine = read(rounded_lines(LINES)), robot("tx60-like")
    assert sections_of(program, machine, ())[1] == []
    planner = Planner(machine, program.start)
    for block in program.blocks:
        planner.add(block)
    planner.finish()
    pieces, tau = [], 0.0
    while made := planner.plan(tau, hurry=True):
        pieces += made
        tau = max(planner.end - 0.5 * planner.ahead_s, tau)
    pieces += planner.plan(planner.end, hurry=True)
    assert not planner.open and planner.place(planner.end) == (LINES, 1.0)
    assert sum(piece.duration for piece in pieces) > 0.075 * LINES


@pytest.fixture
def uncollected() -> Iterator[None]:
    """The collector would walk over all that other tests have left, a third of a second inside of one slice."""
    gc.disable()
    yield
    gc.enable()


@pytest.mark.usefixtures("uncollected")
def test_three_minutes_of_curve_pass_check_and_planner_and_their_law_is_made_in_slices() -> None:
    """One slice took half of the work, seconds in which the planner showed no life."""
    machine, text = robot("portal"), f"robot portal\nangles rho3\naxes mm mm mm deg\nstart 300 100 50 0\nset path={2.77 / LESS_TIME}\n"
    program = read(f"{text}circular via pose 450 250 60 0 0 0 to pose 300 400 70 0 0 0\n")
    found = route_of(program, machine)
    assert not found.faults and not too_long(found.stretches, machine)
    planner, spent = Planner(machine, program.start), []
    planner.add(program.blocks[0])
    planner.finish()
    assert planner.begin(0.0, hurry=True)
    done = False
    while not done:
        begin = time.process_time()
        done = planner.work()
        spent.append(time.process_time() - begin)
    assert planner.take() and 170.0 < planner.end / LESS_TIME < 200.0
    assert max(spent) < 0.15 * sum(spent)


CURVE = ARC.replace("path=12", f"path={2.05 / LESS_TIME}")  # three minutes of an arm


@pytest.mark.usefixtures("uncollected")
def test_three_minutes_of_curve_of_an_arm_are_planned_in_short_slices() -> None:
    planner, spent = Planner(robot("tx60-like"), read(CURVE).start), []
    added(planner, CURVE)
    for _ in range(2):
        assert planner.begin(planner.end, hurry=True)
        done = False
        while not done:
            begin = time.process_time()
            done = planner.work()
            spent.append(time.process_time() - begin)
        planner.take()
    assert planner.end > 180.0 * LESS_TIME
    assert max(spent) < 0.1 * sum(spent) and len(spent) > 65, "a look at all samples of a phase was one slice"


@pytest.mark.timeout(1200)
def test_what_check_says_of_three_minutes_of_curve_of_an_arm_is_what_a_cell_does(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Begun by a cell with its drives; what it was handed is run to the end by a stepper alone (with the drives, too: `make soak`)."""
    program = tmp_path / "it.txt"
    program.write_text(CURVE)
    assert main(["check", str(program)]) == 0
    path = find_config("arm6", "cells")
    cell = Planned(Cell402Bench(cell=load_cell(str(path), read_text(path))))
    stepper = Stepper(6, STEP_S, [axis.set for axis in cell.state.axes[:6]])
    handed: list[PieceRecord] = []
    feed = cell.planner.feed

    def taken(core: CycleLogic, record: PieceRecord) -> None:
        handed.append(record)
        feed(core, record)

    monkeypatch.setattr(cell.planner, "feed", taken)
    job, began = cell.order(CURVE), cell.bench.now
    while job.open and (WHOLE or cell.bench.now - began < ms(10_000)):
        cell.bench.cycle()
    assert job.state is (CommandState.DONE if WHOLE else CommandState.RUNNING), job.detail
    assert cell.state.piece > 1 and cell.programs.state.ended, "on its way, and the planner has handed on all of it"
    assert not WHOLE or 180.0 < (cell.bench.now - began) / 1e9 < 215.0
    for record in handed:
        if record.part is Part.PIECE:
            stepper.load(decode_any(record.piece))
    rows = [stepper.step().q]
    while stepper.state is not State.IDLE:
        rows.append(stepper.step().q)
    assert len(handed) > PLENTY / 4 and 180.0 < len(rows) * STEP_S / LESS_TIME < 215.0
    tip = cell.machine.forward(rows[-1]).position
    assert tip == pytest.approx((0.35, 0.15, 0.2), abs=1e-5)
