"""Run-time errors of VAL 3 that say what a Cartesian path does to a joint and to the tool: 544, 531, 554 (L6673-6688)."""

import math
from dataclasses import replace

import pytest

from gateway.assembly.programs import machine_of_cell
from gateway.cell_file.load import load_cell
from gateway.pure.cell.cell import Cell
from gateway.pure.image.reasons import CommandState
from gateway.tools.motion.dry_run import sections_of
from hil_tests.lab.cells import arms
from hil_tests.lab.virtual.belt_bench import PORTAL, TEXT
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot
from hil_tests.unit.motion.program.test_faults_of_blocks import ARM, faults
from hil_tests.unit.motion.program.test_robots_in_a_cell import ARM as ARM_CELL
from motion.program.text.reader import read

TURNS = "min = -170.0, max = 170.0"  # of axis C
WIDE = load_cell(str(PORTAL), TEXT.replace(TURNS, "min = -270.0, max = 270.0"))
HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 300 50 0\n"


def turned(*angles: float) -> str:
    return "".join(f"linear pose 350 -150 200 180 0 {angle:g}\n" for angle in angles)


def test_a_path_that_turns_a_multi_turn_joint_beyond_its_travel_is_544_and_names_it() -> None:
    assert faults(turned(90, 0, -90, -180, -270)) == [], "J6 begins at 203 deg of 270"
    assert faults(turned(90, 180, 60)) == [(3, "J6", 544)], "the block is left out, and the next one is looked at"
    words = str(sections_of(read(ARM + turned(90, 180)), arms.robot("tx60-like"), ())[1][0])
    assert "axis J6: the path drives the axis out of its range -270 .. 270 deg, 26.2 deg along the path: let it begin a turn" in words


def test_a_joint_that_does_not_turn_is_531() -> None:
    lines = (
        "linear pose 100 300 50 0 0 90\nlinear pose -900 300 50 0 0 90\nlinear pose 100 300 50 0 0 200\nlinear pose 100 300 50 0 0 300\n"
    )
    found = sections_of(read(HEAD + lines), arms.robot("portal"), ())[1]
    assert [(fault.block, fault.axis, fault.code) for fault in found] == [(2, "X", 531), (4, "C", 544)], found


def test_a_corner_in_which_the_tool_turns_half_round_or_more_is_554_before_anything_moves() -> None:
    cell = Planned(ServodynRobot(cell=WIDE))
    assert cell.bench.settle(cell.order(HEAD + "ptp joints 100 300 50 -265")).state is CommandState.DONE
    arc = "circular via pose 150 350 50 0 0 {} to pose 200 300 50 0 0 {} arcs=yes radius=70\n"
    onward = "linear pose 200 150 50 0 0 {}\n"
    back, large = (HEAD + arc.format(-105, 55) + onward.format(angle) for angle in (-115, 225))
    before = cell.bench.set()
    job = cell.bench.settle(cell.order(large))
    assert job.state is CommandState.REFUSED and "block 2: Cartesian blend: the tool turns by" in job.detail, job.detail
    assert "VAL 3 554" in job.detail and cell.bench.set() == before
    for text in (back, large.replace(" radius=70", "")):
        assert cell.bench.settle(cell.order(HEAD + "ptp joints 100 300 50 -265")).state is CommandState.DONE
        assert cell.bench.settle(cell.order(text)).state is CommandState.DONE, "turning back, or without a corner, it is run"


def narrowed(axis: str, low: float, high: float, cell: Cell = ARM_CELL) -> Cell:
    """A cell whose axis travels less far than its robot file says."""
    axes = (replace(each, limits=replace(each.limits, min=low, max=high)) if each.name == axis else each for each in cell.axis)
    return replace(cell, axis=tuple(axes))


def test_the_travel_of_the_cell_counts_where_it_is_narrower_than_that_of_the_robot_file() -> None:
    assert faults_of("robot tx60-like" + ARM + turned(90, 0), narrowed("J6", -270.0, 200.0)) == [(2, "J6", 544)]
    straight = (
        HEAD + "linear pose 100 300 50 0 0 90\nlinear pose 100 300 50 0 0 150\nptp pose 100 300 50 0 0 150\nptp joints 100 300 50 150\n"
    )
    assert faults_of(straight, narrowed("C", -100.0, 100.0, WIDE)) == [(2, "C", 531), (3, "C", 531), (4, "C", 520)]


def faults_of(text: str, cell: Cell) -> list[tuple[int, str, int]]:
    found = sections_of(read(text), machine_of_cell(cell), ())[1]
    return [(fault.block, fault.axis, fault.code) for fault in found]


def test_a_pose_is_reached_by_the_turn_that_lies_within_the_travel_of_the_cell() -> None:
    near, there = (tuple(map(math.radians, (0, 30, 90, 0, 60, last))) for last in (170, -165))
    for cell, last in ((ARM_CELL, 195.0), (narrowed("J6", -270.0, 180.0), -165.0), (narrowed("J6", -300.0, 300.0), 195.0)):
        machine = machine_of_cell(cell)
        assert math.degrees(machine.inverse(machine.forward(there), near)[5]) == pytest.approx(last)
    wide = machine_of_cell(narrowed("J6", -600.0, 600.0))
    assert math.degrees(wide.inverse(wide.forward(there), (*near[:5], math.radians(400)))[5]) == pytest.approx(555.0), (
        "further than the file's"
    )
