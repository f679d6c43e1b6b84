"""A six-axis arm and a SCARA in one cell with emulated CiA 402 drives: the shipped program of both, stopped, resumed and slowed down, then
one of the SCARA alone.  Judged by the emulator's own record and the points of the programs (AX-340, AX-564)."""

import functools

import numpy as np
import pytest

from gateway.assembly.programs import plan_programs
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion
from gateway.web.skeleton import Skeleton
from hil_tests.lab.cells.arm_and_scara import (
    CELL,
    OWN,
    POINTS,
    ROBOTS,
    ROUND,
    SHIPPED,
    carried,
    cell_text,
    judge_lines,
    tips,
)
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.cells.carried_cell import ARM
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Driven, Planned

ALONE = "robot sr60-like\naxes deg deg mm deg\nptp joints 40 90 -200 0\n"
STANDS = 4e-6  # rad, m: an increment


def gone(places: Array, start: tuple[float, ...], end: tuple[float, ...]) -> Array:
    """(n,) share of the way of a line."""
    way = np.subtract(end, start)
    return np.asarray(np.linalg.norm(places - start, axis=1) / np.linalg.norm(way))


def ended(planned: Planned, job: Job) -> Driven:
    planned.bench.settle(job)
    assert job.state is CommandState.DONE, job
    planned.bench.run(0.3)
    return planned.driven()


@functools.cache
def driven() -> tuple[Driven, Driven]:
    """The program of both, and that of the SCARA behind it."""
    planned = Planned(Cell402Bench(8, cell=CELL))
    planned.driven()
    job = planned.order(SHIPPED)

    def sets() -> Array:
        return np.array([[axis.set for axis in planned.state.axes[: len(CELL.axis)]]])

    planned.until(lambda s: s.piece > 0 and tips(sets(), 0)[0, 2] > 0.21 and -0.12 < tips(sets(), 0)[0, 1] < -0.05)
    planned.done(Code.STOP)
    planned.until(lambda s: s.motion is Motion.STOPPED)
    stood = sets()
    planned.bench.run(0.3)
    assert np.array_equal(sets(), stood) and -0.12 < tips(stood, 0)[0, 1] < -0.04, "on the line"
    planned.done(Code.OVERRIDE, 0.6)
    resumed = planned.bench.give(Code.RESUME)
    planned.until(lambda s: tips(sets(), 0)[0, 1] > 0.05)
    planned.done(Code.OVERRIDE, 1.0)
    both = ended(planned, job)
    assert resumed.state is CommandState.DONE
    return both, ended(planned, planned.order(ALONE))


def test_each_tool_keeps_its_own_lines_through_a_stop_and_a_slow_stretch() -> None:
    judge_lines(driven()[0])


def test_both_begin_and_end_together_and_are_at_the_same_share_of_their_ways() -> None:
    rows = driven()[0].sets
    part = carried(rows)
    for begin, end in ((0, part.start), (part.start, part.stop - 1)):
        if begin == 0:  # PTP: all axes in step
            way = rows[end] - rows[begin]
            far = np.abs(way) > 0.02
            assert far[OWN[0]].any() and far[OWN[1]].any()
            shares = (rows[begin:end] - rows[begin])[:, far] / way[far]
        else:
            tools = [tips(rows[begin:end], n) for n in (0, 1)]
            lines = [gone(tools[n], *POINTS[n][:2]) for n in (0, 1)]
            behind = [1 + gone(tools[n], *POINTS[n][1:]) for n in (0, 1)]
            shares = np.where(tools[0][:, 1:2] < 0.0, np.array(lines).T, np.array(behind).T)
            shares = shares[np.abs(shares[:, 0] - 1.0) > ROUND[0] / 0.15]
        assert float(np.ptp(shares, axis=1).max()) < 5e-4
        assert float(shares.min()) < 1e-3 and float(shares.max()) > shares.max().round() - 1e-3


def test_who_goes_home_alone_leaves_the_other_at_rest() -> None:
    made, alone = driven()
    rows = made.sets[carried(made.sets).stop :]
    moves = [np.flatnonzero(np.abs(np.diff(rows[:, own], axis=0)).max(axis=1) > STANDS) for own in OWN]
    assert len(moves[0]) > 20 and len(moves[1]) > 20 and moves[0].max() < moves[1].min()
    assert float(np.ptp(alone.sets[:, OWN[0]], axis=0).max()) <= STANDS and float(np.ptp(alone.sets[:, 6])) > 0.5, "the SCARA's own program"
    assert float(np.abs(alone.sets[-1] - made.sets[0])[OWN[0]].max()) <= STANDS


def test_no_axis_is_beyond_its_limits() -> None:
    for made in driven():
        speed, accel = made.shares()
        assert 0.1 < speed <= 1.0 and 0.2 < accel <= 1.02, (speed, accel)


def test_programs_move_the_axes_of_the_robots_they_name_and_the_page_says_whom_it_draws() -> None:
    assert {number: plan.mask for number, plan in plan_programs(CELL).items()} == {1: 0b1111111111, 2: 0b1111000000}
    assert Skeleton(CELL).why.startswith("arm (tx60-like) is drawn, without scara (sr60-like)")
    one = load_cell(str(ARM))
    assert [robot.name for robot in one.robot] == ["ARM"] and plan_programs(one)[1].mask == 0b111111 and not Skeleton(one).why


MANY = ROBOTS + '[[robot]]\nkinematics = "arm6"\nmodel = "tx60-like"\nname = "other"\n\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (cell_text(robots=MANY), "robot tx60-like has 6 axes, 0 are left after those of the robots before it"),
        (cell_text().replace('= "scara"\n\n[[program]]', '= "arm"\n\n[[program]]'), "another robot has this name"),
        (cell_text().replace('= "arm"', '= ""'), "programs name each of several robots"),
        (cell_text().replace('= "arm"', '= "left"'), "kinematic arm: no .*robot.* has this name; this cell has left .tx60-like., scara"),
        (ARM.read_text().replace('"arm-u-cycle"', '"arm-and-scara"'), "kinematic arm: no .*robot.* has this name; this cell has ARM"),
        (cell_text().replace('kinematics = "scara"\n\n#', 'kinematics = "arm"\n\n#'), "is written for robot sr60-like, this cell's is"),
    ],
)
def test_check_refuses_in_words_what_such_a_cell_cannot_run(text: str, words: str) -> None:
    with pytest.raises(CellFaults, match=words):
        load_cell(str(ARM), text)
