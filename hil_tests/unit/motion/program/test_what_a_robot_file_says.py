"""shape and too_fast of a robot file: on paper, in cells, and for several kinematics that move together.  AX-571, AX-575."""

import pathlib
from dataclasses import replace

import pytest

from gateway.assembly.programs import machine_of_cell
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.files.robots import RobotFaults, load_robot
from gateway.tools.motion.dry_run_team import team_findings, team_traces
from motion.planner.robot import Machine, machine_of
from motion.planner.team import Team
from motion.program.blocks import Shape
from motion.program.text.team import read_team
from motion.timing.limiter import TooFast

ROBOT = read_text(find_config("portal", "robots"))
CELL = read_text(find_config("portal", "cells"))
OWN = "kinematic {0} portal\nangles rho3\naxes mm mm mm deg\nstart 0 0 0 0\n"
TOGETHER = f"{OWN.format('a')}{OWN.format('b')}move a linear pose 300 0 0 0 0 0 and b linear pose 200 0 0 0 0 0\n"


def robot(keys: str) -> Machine:
    return machine_of(load_robot("mine.toml", ROBOT.replace("[robot]\n", f"[robot]\n{keys}\n", 1)))


def test_a_program_in_the_dry_run_has_them_from_the_robot_file() -> None:
    assert [robot(f"too_fast = {word}").too_fast for word in ("0", "1", "3", '"error"')] == [
        TooFast.SLOW,
        TooFast.ABORT,
        TooFast.WARN,
        TooFast.ERROR,
    ]
    assert (robot("").too_fast, robot("").shape, robot('shape = "sin2"').shape) == (TooFast.SLOW, Shape.JERK, Shape.SIN2)
    for keys, words in (("too_fast = 4", "too_fast"), ("too_fast = true", "too_fast"), ('shape = "trapezoid"', "shape")):
        with pytest.raises(RobotFaults, match=words):
            robot(keys)


@pytest.mark.parametrize(
    ("cell", "wanted"),
    [
        ("", (TooFast.WARN, Shape.SIN2)),
        ('too_fast = "robot"\nshape = "robot"\n', (TooFast.WARN, Shape.SIN2)),
        ('too_fast = 0\nshape = "jerk"\n', (TooFast.SLOW, Shape.JERK)),
    ],
)
def test_a_cell_that_says_nothing_takes_them_from_its_robot(tmp_path: pathlib.Path, cell: str, wanted: tuple[TooFast, Shape]) -> None:
    (tmp_path / "own.toml").write_text(ROBOT.replace("[robot]\n", '[robot]\ntoo_fast = 3\nshape = "sin2"\n', 1))
    text = CELL.replace('model      = "portal"', 'model      = "own.toml"').replace("[robot]\n", f"[robot]\n{cell}")
    text = text.replace('[[program]]\nnumber = 1\nfile   = "portal-u-cycle"\n', "")
    machine = machine_of_cell(load_cell(str(tmp_path / "cell.toml"), text))
    assert (machine.too_fast, machine.shape) == wanted


def seconds(*shapes: Shape) -> float:
    machines = [replace(robot(""), shape=shape) for shape in shapes]
    machines[1] = replace(machines[1], limits=tuple(replace(axis, name=f"b.{axis.name}") for axis in machines[1].limits))
    team = Team(("a", "b"), (machines[0], machines[1]))
    return float(team_traces(team_findings(read_team(TOGETHER), team), team)[0].t[-1])


def test_kinematics_that_move_together_have_sine_square_ramps_where_all_of_them_do() -> None:
    sine, jerk = seconds(Shape.SIN2, Shape.SIN2), seconds(Shape.JERK, Shape.JERK)
    assert sine > 1.1 * jerk
    assert seconds(Shape.SIN2, Shape.JERK) == pytest.approx(jerk) == seconds(Shape.JERK, Shape.SIN2)
