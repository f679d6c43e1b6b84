"""Relative targets (MOVE_REL of the rho 3): where they lead, in the text, on paper, on belts and in a cell; what is refused (AX-567)."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from gateway.files.robots import load_robot
from gateway.pure.arbitration.command_block import Code
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion
from gateway.tools.motion.dry_run import DryRun, sections_of
from hil_tests.lab.cells import arms
from hil_tests.lab.virtual.belt_bench import FACTS, HEAD, MACHINE
from hil_tests.lab.virtual.probing import Probing
from hil_tests.lab.virtual.program_bench import joints
from hil_tests.unit.motion.program.close import same_program
from motion.errors import MotionError
from motion.geometry.conventions import RHO3, VAL3
from motion.planner.arm import Arm
from motion.planner.route import Route
from motion.planner.team import called, team_of
from motion.planner.team_route import TeamRoute
from motion.program.blocks import UNKNOWN, Block, Interpolation, Shift
from motion.program.errors import BlockError, TextFaults
from motion.program.text.reader import read
from motion.program.text.team import read_team
from motion.program.text.writer import write
from motion.robot import Installation

ARM = """
angles val3
start 0 30 90 0 60 0
tool g 0 0 100 0 0 0
frame f 500 0 0 0 0 90
point STEP rel pose 0 40 -30 0 0 10
set tool=g
"""
PORTAL = "angles rho3\naxes mm mm mm\nstart 0 0 0\n"


def ends(text: str, robot: str = "tx60-like") -> list[tuple[float, ...]]:
    """Where the axes rest behind each block."""
    program, found = read(text), []
    route = Route(arms.robot(robot), program.start)
    for block in program.blocks:
        route.add(block)
        found.append(route.position)
    return found


def close(one: Sequence[float], other: Sequence[float]) -> bool:
    return max(abs(a - b) for a, b in zip(one, other, strict=True)) < 1e-9


@pytest.mark.parametrize(
    ("relative", "absolute"),
    [
        ("linear STEP", "linear pose 350 -110 170 180 0 10"),
        ("ptp STEP", "ptp pose 350 -110 170 180 0 10"),
        ("linear rel pose 0 0 0 -20 15 -30", "linear pose 350 -150 200 160 15 -30"),
        ("linear rel pose 10 20 0 0 0 0 frame=f", "linear pose 330 -140 200 180 0 0"),  # its x is the base's y
        ("linear rel pose 0 0 0 0 0 0", ""),
        ("ptp rel joints 5 0 0 0 0 0\nptp rel joints -5 0 0 0 0 0", ""),
    ],
)
def test_differences_are_added_to_the_numbers_of_the_place_where_the_block_before_ends(relative: str, absolute: str) -> None:
    first = f"{ARM}ptp pose 350 -150 200 180 0 0\n"
    assert close(ends(first + relative)[-1], ends(first + absolute)[-1])


def test_a_difference_of_an_axis_is_its_own() -> None:
    assert close(ends(f"{ARM}ptp rel joints 10 0 -5 0 0 20")[0], [math.radians(v) for v in (10, 30, 85, 0, 60, 20)])


def test_a_chain_is_rounded_and_timed_as_the_same_chain_of_absolute_blocks_and_one_by_one_as_whole() -> None:
    """Numbers that are added without rounding: a law takes the last bit of a place to the tenth of its times."""
    on, up, back = "radius=20 path=200", "62.5 0 0 0 0", "-62.5 31.25 7.8125"
    ways = [f"linear rel pose 125 0 0 0 0 0 {on}", f"linear rel pose 0 {up} {on}", f"ptp rel joints {back}"]
    there = [f"linear pose 125 0 0 0 0 0 {on}", f"linear pose 125 {up} {on}", "ptp joints 62.5 93.75 7.8125"]
    rows = []
    for lines, whole in ((ways, True), (ways, False), (there, True)):
        arm = Arm(arms.portal(), (0.0, 0.0, 0.0))
        for block in read(PORTAL + "\n".join(lines)).blocks:
            arm.add(block)
            if not whole:
                for _ in range(4):
                    arm.step()
        arm.finish()
        rows.append(arms.run(arm))
    path = arms.tool_path(arms.portal(), rows[0])
    assert np.abs(rows[0][-1] - (0.0625, 0.09375, 0.0078125)).max() < 1e-12
    assert np.linalg.norm(path - (0.125, 0.0, 0.0), axis=1).min() == pytest.approx(0.1875 * math.sqrt(2) * 0.02, abs=1e-4), "rounded"
    assert rows[0].shape == rows[2].shape and np.abs(rows[0] - rows[2]).max() < 1e-12
    assert np.abs(rows[1][-1] - rows[0][-1]).max() < 1e-12


def test_additional_axes_go_by_their_difference() -> None:
    head = "robot tx60-on-track\nangles val3\naxes deg deg deg deg deg deg mm deg\nstart 0 30 90 0 60 0 200 10\n"
    stays, goes = (ends(f"{head}linear rel pose 0 20 0 0 0 0{more}", "tx60-on-track")[0] for more in ("", " extra=50mm,-4deg"))
    assert stays[6:] == pytest.approx((0.2, math.radians(10)))
    assert goes[6:] == pytest.approx((0.25, math.radians(6)))


def told(blocks: str) -> list[tuple[int, str, int]]:
    found = sections_of(read(ARM + blocks), arms.robot("tx60-like"), ())[1]
    return [(fault.block, fault.axis, fault.code) for fault in found]


def test_what_cannot_be_reached_is_reported_with_block_and_axis_and_the_next_one_begins_where_the_last_good_one_ended() -> None:
    lines = "ptp rel joints 0 0 0 0 0 20\nptp rel joints 0 200 0 0 0 0\nlinear rel pose 0 0 5000 0 0 0\n"
    lines += "ptp rel joints 0 0 0 0 0 -20 extra=5mm\n"
    with pytest.raises(TextFaults, match="line 11: extra: needs a pose"):
        read(ARM + lines)
    assert told(lines.replace(" extra=5mm", "")) == [(2, "J2", 520), (3, "J5", 531)]
    assert told("linear rel pose 0 0 5 0 0 0 extra=5mm") == [(1, "", 154)]


@pytest.mark.parametrize(
    ("line", "key", "says"),
    [
        ("circular via STEP to STEP", "via", "a pose is needed"),
        ("circular via pose 0 0 0 0 0 0 to STEP", "rel", "one of ptp and linear, not of circular"),
        ("spline rel pose 1 0 0 0 0 0", "rel", "one of ptp and linear, not of spline"),
        ("linear rel", "rel", "rel joints"),
        ("linear rel 1 2 3", "rel", "rel joints"),
        ("linear rel pose 1 2", "rel pose", "six numbers"),
        ("ptp rel joints 1 2", "rel joints", "2 values; 6 axes"),
        ("ptp rel pose nan 0 0 0 0 0", "rel pose", "nan is outside"),
        ("linear STEP config=righty", "config", "keeps the configuration"),
    ],
)
def test_what_is_no_relative_target_is_reported_by_its_line_and_key(line: str, key: str, says: str) -> None:
    with pytest.raises(TextFaults) as caught:
        read(ARM + line)
    (fault,) = caught.value.faults
    assert (fault.line, fault.key) == (8, key) and says in fault.what


def test_blocks_that_no_text_made_are_refused_in_words() -> None:
    for kind, shift, says in [
        (Interpolation.SPLINE, Shift((0.0,) * 6, RHO3), "ptp and linear"),
        (Interpolation.CIRCULAR, Shift((0.0,) * 6, RHO3), "ptp and linear"),
        (Interpolation.LINEAR, Shift((math.inf, 0.0, 0.0, 0.0, 0.0, 0.0), RHO3), "not a finite number"),
        (Interpolation.LINEAR, Shift((1.0, 2.0), RHO3), "six are needed"),
        (Interpolation.PTP, Shift((0.0, 0.0)), "2 joint values, the robot has 3"),
    ]:
        route = Route(arms.portal(), (0.0, 0.0, 0.0))
        with pytest.raises(BlockError, match=says):
            route.add(Block(kind, UNKNOWN, shift=shift))
        assert route.position == (0.0, 0.0, 0.0)


def test_relative_blocks_are_written_and_read_again() -> None:
    program = read(
        "axes deg deg deg deg deg deg"
        + ARM
        + "linear STEP radius=5 out=7:1@20\nptp rel joints 1 2 3 4 5 6 until=!5\nlinear rel pose 1 0 0 0 0 0 extra=10deg"
    )
    assert program.blocks[0].shift is not None and program.blocks[0].shift.angles is VAL3
    assert same_program(read(write(program)), program)
    with pytest.raises(MotionError, match="in angles of the VAL 3 cannot be written in those of the rho 3"):
        write(program, "rho3")


CARRIED = """linear pose 100 120 50 0 0 0
synchron B1 at=60mm
linear pose 150 150 50 0 0 0 belt=60mm
{0}
synchron_end
"""
PACED = """synchron {kind} at=50mm
linear pose 200 150 50 0 0 0 belt=150mm
{0}
linear pose 240 170 50 0 0 0 belt=350mm
synchron_end
"""


@pytest.mark.parametrize(
    ("text", "relative", "absolute"),
    [
        (CARRIED, "linear rel pose 0 0 40 0 0 0 path=60", "linear pose 150 150 90 0 0 0 belt=60mm path=60"),
        (PACED.replace("{kind}", "B2"), "linear rel pose 20 0 0 0 0 0 belt=100mm", "linear pose 220 150 50 0 0 0 belt=250mm"),
        (PACED.replace("{kind}", "B3"), "linear rel pose 20 0 0 0 0 0 belt=100mm", "linear pose 220 150 50 0 0 0 belt=250mm"),
    ],
)
def test_on_a_belt_the_difference_is_one_along_the_belt(text: str, relative: str, absolute: str) -> None:
    """Types 2 and 3: the belt is a coordinate of the point, MOVE-REL (0,100) changes it alone (L6249)."""
    rows = []
    for line in (relative, absolute):
        sections, faults = sections_of(read(HEAD + text.format(line)), MACHINE, FACTS)
        assert not faults
        rows.append(DryRun(MACHINE, FACTS, (0.1,) * 3, 4).run(sections).q)
    assert len(rows[0]) == len(rows[1]) and np.abs(rows[0] - rows[1]).max() < 1e-9


def test_what_a_belt_forbids_of_a_relative_block_is_reported() -> None:
    text = """synchron B1 at=60mm
linear rel pose 1 0 0 0 0 0 belt=60mm
linear rel joints 1 0 0 0
synchron_end
synchron B2 at=50mm
ptp rel pose 1 0 0 0 0 0 belt=100mm
linear rel pose 1 0 0 0 0 0
linear rel pose 1 0 0 0 0 0 belt=0mm
linear rel joints 1 0 0 0 belt=5mm
"""
    faults = sections_of(read(HEAD + text), MACHINE, FACTS)[1]
    assert [(fault.block, fault.code) for fault in faults] == [(1, 0), (2, 0), (3, 23), (4, 0), (5, 89), (6, 0)]
    assert "belt= has no place" in str(faults[0]) and "belt= is needed" in str(faults[3]) and "a pose is needed" in str(faults[5])


@pytest.fixture(scope="module")
def bench() -> Probing:
    return Probing()


def test_in_a_cell_the_block_behind_until_begins_where_the_axes_were_stopped(bench: Probing) -> None:
    job = bench.order(f"ptp joints {joints(90)} until=ch610", f"ptp rel joints {joints(-3)}")
    bench.edge_at(20.0)
    furthest = [0.0] * len(bench.places())
    while job.state is not CommandState.DONE:
        bench.cell.cycle()
        furthest = [max(pair) for pair in zip(furthest, bench.places(), strict=True)]
    assert min(furthest) > 20.0 and max(furthest) < 80.0
    assert bench.places() == pytest.approx([place - 3.0 for place in furthest], abs=1e-6)


def test_stop_and_resume_change_nothing_of_where_a_relative_block_leads(bench: Probing) -> None:
    assert bench.finished(bench.order(f"ptp joints {joints(10)}")).state is CommandState.DONE
    job = bench.order(f"ptp rel joints {joints(75)}")
    while not bench.places()[0] > 15.0:
        bench.cell.cycle()
    bench.cell.settle(bench.cell.give(Code.STOP))
    bench.cell.run(0.2)
    assert bench.cell.core.state.motion is Motion.STOPPED and max(bench.places()) < 80.0
    bench.cell.settle(bench.cell.give(Code.RESUME))
    assert bench.finished(job).state is CommandState.DONE and bench.at(85.0, 1e-6)


def test_a_cell_refuses_it_before_anything_moves(bench: Probing) -> None:
    before = bench.places()
    job = bench.order(f"ptp joints {joints(5)}", f"ptp rel joints {joints(9e4)}")
    assert bench.finished(job).state is CommandState.REFUSED and bench.places() == before
    assert "line 3: block 2, axis" in bench.programs.state.fault and "outside" in bench.programs.state.fault


def test_robots_that_move_together_go_by_their_own_differences() -> None:
    head = (
        "program two\nkinematic left sr60-like\naxes deg deg mm deg\nstart 0 90 -100 0\nkinematic right tx60-like\nstart 0 30 90 0 60 0\n"
    )
    text = head + (
        "move left ptp rel joints 20 0 10 0 blend=joint leave=5 reach=5 and right linear rel pose 0 30 0 0 0 0 radius=5\n"
        "move left ptp rel joints 0 -10 0 5 and right linear rel pose 0 0 30 0 0 0\nmove right ptp rel joints 1 0 0 0 0 0\n"
    )
    program = read_team(text)
    route = TeamRoute(team_of(Installation(tuple(called(each.name, load_robot(each.robot)) for each in program.kinematics))), program.start)
    for shared in program.blocks:
        route.add(shared)
    route.finish()
    lone = ends("start 0 30 90 0 60 0\nlinear rel pose 0 30 0 0 0 0\nlinear rel pose 0 0 30 0 0 0\nptp rel joints 1 0 0 0 0 0")[-1]
    assert close(route.position[:4], (math.radians(20), math.radians(80), -0.09, math.radians(5)))
    assert close(route.position[4:], lone)
