"""The text form of several kinematics: what it says, every fault with line, key and kinematic, and the way back; check and plot of it."""

import json
import pathlib

import pytest

from gateway.commands.motion import main, team_of_program
from gateway.files.find import find_config, read_text
from gateway.tools.motion.dry_run_team import team_findings
from hil_tests.unit.motion.program.close import same
from motion.program.blocks import Interpolation, JointTarget, PoseTarget, Rounding
from motion.program.errors import TextFaults
from motion.program.text.team import read_team, several, write_team

TEXT = """
program pair             # two portals
kinematic left portal
axes mm mm mm deg
start 100 100 50 0
point A pose 200 100 50 0 0 0
set path=300
kinematic right portal
axes mm mm mm deg
angles rho3
start 100 100 50 0
frame table 100 0 0 0 0 90
move left linear A radius=20 and right ptp joints 300 100 50 20
linear pose 50 -150 60 0 0 0 frame=table
kinematic left
ptp joints 100 100 50 0 speed=40
move right circular via pose 150 200 50 0 0 0 to pose 100 250 50 0 0 0 and left linear A out=400:1
"""


def test_moves_of_one_and_of_several_and_what_is_said_of_each() -> None:
    program = read_team(TEXT)
    assert several(TEXT)
    assert not several("program x\nrobot portal\n")
    assert [(each.name, each.robot, each.angles) for each in program.kinematics] == [
        ("left", "portal", "val3"),
        ("right", "portal", "rho3"),
    ]
    assert program.start == pytest.approx((0.1, 0.1, 0.05, 0.0) * 2)
    assert [shared.moving for shared in program.blocks] == [(0, 1), (1,), (0,), (0, 1)]
    assert [shared.line for shared in program.blocks] == [13, 14, 16, 17]
    left, right = program.blocks[0].moves
    assert left is not None
    assert right is not None
    assert (left.kind, left.blend.rounding, left.blend.leave, left.pace.path_speed) == (Interpolation.LINEAR, Rounding.CARTESIAN, 0.02, 0.3)
    assert isinstance(left.target, PoseTarget)
    assert isinstance(right.target, JointTarget)
    assert right.target.q == pytest.approx((0.3, 0.1, 0.05, 0.349065850))
    assert right.pace.path_speed is None
    own = program.blocks[1].moves[1]
    assert own is not None
    assert own.frame.name == "table"


def test_a_program_written_is_read_back_the_same() -> None:
    labelled = f"{TEXT}move left linear A until=3 error=X and right ptp mpos error=END\nlabel X\nmove right linear mpos\nlabel END\n"
    for text in (TEXT, labelled, read_text(find_config("arm-and-scara", "programs"))):
        program = read_team(text)
        assert same(read_team(write_team(program)), program)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("move left linear B", "line 18: kinematic left: point 'B' is unknown; A are known"),
        ("move left linear A speed=900", "line 18: speed: kinematic left: 900 % is outside 0.01 .. 500 %"),
        ("move middle linear A", "line 18: kinematic: 'middle' is unknown; left, right"),
        ("move left linear A and left linear A", "line 18: move: left is used twice in one block"),
        ("move linear A", "line 18: move: NAME and one of ptp, linear, circular, spline, then its target; `and` between two kinematics"),
        ("kinematic third portal", "line 18: kinematic: third must be before the first move"),
        ("kinematic other", "line 18: kinematic: 'other' is unknown: write kinematic NAME ROBOT, with its robot file, first"),
        ("robot portal", "line 18: robot: `kinematic NAME ROBOT` names the robot of each kinematic"),
        ("label X\nmove left linear A until=3 error=X", "line 19: error: label X does not follow the block"),
        ("circle A", "line 18: circle: no statement of a program of several kinematics; program, kinematic, angles,"),
        ("label X\nlabel X", "line 19: label: X is defined twice"),
        ("synchron_end", "line 18: synchron_end: kinematic left: ends no synchronous part; `synchron BELT` begins one"),
        (
            "synchron B1\nmove right linear mpos",
            "line 19: move: kinematic left is on a belt or corrected and moves alone, right cannot: write synchron_end",
        ),
        (
            "alter frame -\nmove right linear mpos",
            "line 19: move: kinematic left is on a belt or corrected and moves alone, right cannot: write alter_end",
        ),
        ("synchron B1\nkinematic right\nsync B1 >= 1mm", "line 20: sync: kinematic left is on a belt or corrected and moves alone, right"),
    ],
)
def test_a_fault_is_reported_with_its_line_key_and_kinematic(line: str, words: str) -> None:
    with pytest.raises(TextFaults) as told:
        read_team(TEXT + line + "\n")
    (fault,) = told.value.faults
    assert str(fault).startswith(words)


def test_no_kinematic_or_no_start_is_reported() -> None:
    with pytest.raises(TextFaults, match="kinematic: none: write `kinematic NAME ROBOT` first"):
        read_team("start 1 2\nkinematic a portal\nstart 0 0 0 0\n")
    with pytest.raises(TextFaults, match="start: is missing: where the axes of kinematic b are"):
        read_team("kinematic a portal\nstart 0 0 0 0\nkinematic b portal\n")


def test_check_names_line_block_kinematic_and_axis_of_every_block_that_cannot_be_run(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "pair.txt"
    path.write_text(
        TEXT
        + "move left ptp joints 100 100 9000 0 and right linear pose 100 250 60 0 0 0\n"
        + "move left linear A until=3 and right linear pose 100 250 70 0 0 0 until=4\n"
    )
    assert main(["check", str(path)]) == 1
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("line 18: block 5, axis left.Z: kinematic left: target 9000 mm is outside ")
    assert said[1] == "line 19: block 6: only one kinematic may define what a shared block waits for, or ends with"
    assert said[2] == "6 blocks: 2 cannot be run"
    assert main(["check", str(path), "--robot", "portal"]) == 2
    assert team_findings(read_team(TEXT), team_of_program(read_team(TEXT), None)).faults == ()


def test_plot_draws_the_path_of_each_kinematic(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, page = tmp_path / "pair.txt", tmp_path / "pair.html"
    path.write_text(TEXT.replace(" radius=20", ""))
    assert main(["plot", str(path), "--out", str(page), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert set(told["kinematics"]) == {"left", "right"}
    for each in told["kinematics"].values():
        assert 0.1 < each["loads"]["speed"] <= 1.0001
        assert each["loads"]["acceleration"] <= 1.02
    drawn = page.read_text()
    assert drawn.count("<h2>Path of the tool</h2>") == 2
    assert "left: portal" in drawn
    assert "right.Z" in drawn
