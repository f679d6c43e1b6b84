"""BLOCK_SEARCH (rho 3 SF 46) in programs of a cell: how far the path is planned ahead.  Judged by the emulator's own record.  AX-587."""

from typing import NamedTuple

import numpy as np
import pytest

from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.cells.arm_and_scara import CELL as PAIR
from hil_tests.lab.cells.arm_and_scara import HEAD as PAIR_HEAD
from hil_tests.lab.cells.arms import Array, robot, shares
from hil_tests.lab.cells.arms import run as executed
from hil_tests.lab.virtual.belt_bench import CELL
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot, off_segment
from hil_tests.unit.motion.program.close import same_program
from motion.planner.arm import Arm
from motion.program.errors import TextFaults
from motion.program.text.reader import read
from motion.program.text.team import read_team, write_team
from motion.program.text.writer import write

HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\n"
STEP, BLOCKS = 15.0, 25  # mm
LINES = [f"linear pose {100 + STEP * n:g} 100 50 0 0 0 path=200 radius=1" for n in range(1, BLOCKS + 1)]


class Row(NamedTuple):
    seconds: float
    rests: float  # of its cycles, in which it is slower than half its speed
    places: Array  # of X, mm
    ahead: float  # blocks, from where the planner dies to where the axes rest
    speed: float  # share of the limits
    accel: float


def run(search: str) -> Row:
    cell = Planned(ServodynRobot(cell=CELL))
    assert cell.bench.settle(cell.order(HEAD + "ptp joints 100 100 50 0")).state is CommandState.DONE
    text = [HEAD.rstrip(), *([f"block_search {search}"] if search else []), *LINES]
    cell.driven()
    assert cell.bench.settle(cell.order("\n".join(text))).state is CommandState.DONE
    made = cell.driven()
    x = made.sets[:, 0] * 1e3
    assert off_segment(made.sets[:, :3], (0.1, 0.1, 0.05), (0.475, 0.1, 0.05)).max() < 2e-5
    moving = np.flatnonzero(np.diff(x) > 1e-6)
    speeds = np.diff(x)[moving[0] : moving[-1]] / made.period
    assert cell.bench.settle(cell.order(HEAD + "ptp joints 100 100 50 0")).state is CommandState.DONE
    cell.order("\n".join(text))
    cell.until(lambda state: state.axes[0].set > 0.2)
    here = cell.bench.set()[0]
    cell.planner.alive = False
    cell.until(lambda state: state.piece == 0 or state.motion is Motion.IDLE)
    cell.bench.run(0.3)
    return Row(len(speeds) * made.period, float(np.mean(speeds < 100)), x, (cell.bench.set()[0] - here) / STEP, *made.shares())


@pytest.fixture(scope="module")
def rows() -> dict[str, Row]:
    return {search: run(search) for search in ("", "1", "3", "11")}


@pytest.mark.requirement("RHO-MOT-44", by="motion.planner.block_search:within_search")
def test_so_many_blocks_behind_the_one_under_way_are_planned_and_no_more(rows: dict[str, Row]) -> None:
    for search in ("1", "3", "11"):
        most = int(search) + 0.5  # and what is left of the block under way
        assert int(search) - 1.5 < rows[search].ahead < most, (search, rows[search].ahead)
    assert rows[""].ahead > 12


@pytest.mark.requirement("RHO-MOT-44", by="motion.planner.planner:Planner._window")
def test_few_blocks_take_their_speed_and_many_do_not_and_path_and_limits_are_kept(rows: dict[str, Row]) -> None:
    assert rows["1"].seconds > 1.5 * rows["11"].seconds > 1.4 * rows[""].seconds
    assert rows["1"].rests > 0.5 and rows[""].rests < 0.2
    for row in rows.values():
        assert row.speed <= 1.0 and row.accel <= 1.02 and row.places[-1] == pytest.approx(100 + STEP * BLOCKS, abs=0.02)


@pytest.fixture(scope="module")
def pair() -> Planned:
    """An arm and a SCARA in a cell with a period of 8 ms, at the beginning of their row."""
    return Planned(Cell402Bench(8, cell=PAIR))


@pytest.mark.parametrize("search", ["1", "3", "11"])
def test_several_kinematics_search_so_many_blocks_and_arrive(pair: Planned, search: str) -> None:
    """Their pieces are short: without the time that a tail takes through the ring, it came too late, and the program was aborted."""
    home = "move arm ptp joints 0 30 90 0 60 0 and scara ptp joints 0 90 -200 0"
    row = [
        f"move arm ptp joints {1.6 * n:g} 30 90 0 60 0 radius=1 and scara ptp joints {1.6 * n:g} 90 -200 0 radius=1" for n in range(1, 11)
    ]
    assert pair.bench.settle(pair.order(PAIR_HEAD + home)).state is CommandState.DONE
    text = PAIR_HEAD + "\n".join([f"block_search {search}", *row])
    assert max(block.ahead for shared in read_team(text).blocks for block in shared.own) == int(search)
    assert write_team(read_team(text)).count(f"block_search {search}") == 1
    job = pair.bench.settle(pair.order(text))
    assert job.state is CommandState.DONE, job.detail
    assert np.array(pair.bench.set())[[0, 6]] == pytest.approx([16.0, 16.0], abs=1e-6)


def test_it_holds_from_the_statement_on_and_is_written_again() -> None:
    text = HEAD + "\n".join([LINES[0], "block_search 5", LINES[1], "block_search -", LINES[2]])
    program = read(text)
    assert [block.ahead for block in program.blocks] == [0, 5, 0] and same_program(read(write(program, "rho3")), program)


@pytest.mark.parametrize(
    "line", ["block_search", "block_search 0", "block_search 12", "block_search 2.5", "block_search 1 5", "block_search \u00b2"]
)
def test_what_is_no_number_of_blocks_is_reported(line: str) -> None:
    with pytest.raises(TextFaults, match=r"line 5: block_search: .* 1 \.\. 11 blocks"):
        read(HEAD + line)


@pytest.mark.parametrize("search", ["5", "11"])
def test_ends_of_the_path_that_move_on_keep_the_jerk(search: str) -> None:
    machine = robot("portal")
    program = read("\n".join([HEAD.rstrip(), f"block_search {search}", *LINES]))
    arm = Arm(machine, program.start, 1e-3)
    for block in program.blocks:
        arm.add(block)
    arm.finish()
    assert max(shares(machine, executed(arm, limit_s=20.0), 1e-3)) <= 1.05


@pytest.mark.parametrize(
    "line", ["linear recorded \u00b2", "record_on \u00b2 5mm", f"block_search {'9' * 5000}", f"linear pose 0 0 0 0 0 0 until={'9' * 5000}"]
)
def test_digits_that_make_no_number_are_reported_with_their_line(line: str) -> None:
    with pytest.raises(TextFaults, match="line 5: "):
        read(HEAD + line)


def test_a_comment_may_hold_any_number() -> None:
    assert len(read(f"{HEAD}{LINES[0]}  # {'9' * 5000}\n").blocks) == 1
