"""Sixteen robots and 32 axes in one cell with emulated CiA 402 drives: one program moves all of them on one clock, through a slow
stretch, a stop and the death of its planner; what check, block and signals say of so many axes (AX-572).  Judged by the emulator's record.
"""

import pathlib
from dataclasses import dataclass

import numpy as np
import pytest

from gateway.assembly.axes import axis_facts, make_planner
from gateway.assembly.programs import plan_programs
from gateway.cell_file.load import load_cell
from gateway.pure.arbitration.command_block import Code, Command, CommandBlock, Status, mask_of_word, mask_word
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.arbitration.jobs import Job
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.reasons import CommandState, Reason
from gateway.pure.image.records.cell import ALL_PERMITS, FLAGS, AxisFlag, CellState, Motion, get_bit
from hil_tests.lab.cells.many_robots import ROBOTS, ROUNDED, cell_file, judge_lines, judge_one_clock, out, points, program, to_the_ends
from hil_tests.lab.virtual.cell_402_bench import Cell402Bench
from hil_tests.lab.virtual.planned_bench import Driven, Planned

pytestmark = pytest.mark.timeout(600)  # one life of the cell: 26,000 frames a second of motion

P5_MS = 8
AXES = 2 * ROBOTS
EVERY = (1 << AXES) - 1
STANDS = 2e-6  # m: an increment


@dataclass(frozen=True)
class Made:
    """One life of the cell: its program, what stood at rest behind it, the program whose planner died, an emergency stop."""

    driven: Driven
    outputs: bytes
    died: Driven
    unanswered: Job
    enabled: tuple[int, int]  # before and behind the emergency stop


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    planned = Planned(Cell402Bench(P5_MS, cell=load_cell(str(cell_file(tmp_path_factory.mktemp("many"))))))
    planned.driven()
    planned.done(Code.OVERRIDE, 0.5)
    job = planned.order(program())
    on_the_way(planned, 0.4)
    planned.done(Code.STOP)
    planned.until(lambda s: s.motion is Motion.STOPPED)
    stood = [axis.set for axis in planned.state.axes]
    assert len(stood) == AXES and all(0.03 < stood[2 * n] < 0.25 for n in range(ROBOTS))
    planned.bench.run(0.1)
    assert [axis.set for axis in planned.state.axes] == stood
    planned.done(Code.OVERRIDE, 1.0)
    planned.done(Code.RESUME)
    assert planned.bench.settle(job).state is CommandState.DONE, job
    planned.bench.run(0.2)
    driven, outputs = planned.driven(), bytes(planned.bench.core.outputs)
    job = planned.order(to_the_ends())
    on_the_way(planned, 0.0)
    planned.planner.alive = False
    planned.planner.held.clear()  # killed between two writes of the ring
    planned.until(lambda s: planned.bench.core.starved)
    planned.bench.run(0.2)
    died = planned.driven()
    planned.bench.core.planner_lost()
    planned.bench.run(0.05)
    before = planned.bench.dispatcher.enabled_mask()
    planned.bench.permit(24, value=False)
    planned.bench.run(0.3)
    return Made(driven, outputs, died, job, (before, planned.bench.dispatcher.enabled_mask()))


def on_the_way(planned: Planned, share: float) -> None:
    """The last of them on its first line, so far."""
    planned.until(lambda s: s.piece > 0 and s.axes[AXES - 2].set > share * points(ROBOTS - 1)[0][0] * 1e-3)


def test_sixteen_robots_keep_their_lines_through_a_slow_stretch_and_a_stop(made: Made) -> None:
    judge_lines(made.driven)


def test_all_32_axes_are_at_the_same_share_of_their_ways_and_within_their_limits(made: Made) -> None:
    judge_one_clock(made.driven)
    speed, accel = made.driven.shares()
    assert 0.5 < speed <= 1.0 and 0.2 < accel <= 1.02, (speed, accel)


def test_who_moves_alone_at_the_end_leaves_the_others_at_rest(made: Made) -> None:
    rows = made.driven.sets
    home = np.flatnonzero(np.abs(rows[:, : AXES - 2]).max(axis=1) <= STANDS)
    alone = rows[home[home > len(out(rows))][0] :]
    assert float(np.abs(alone[:, : AXES - 2]).max()) <= STANDS
    assert alone[-1, AXES - 2 :] == pytest.approx(np.array(points(ROBOTS - 1)[0]) * 1e-3, abs=STANDS)


def test_a_planner_that_dies_under_way_leaves_all_of_them_at_rest_on_their_way(made: Made) -> None:
    rows = made.died.sets
    assert float(np.ptp(rows[-10:], axis=0).max()) == 0.0, "at rest"
    way = np.array([points(n)[1] for n in range(ROBOTS)]).reshape(-1) * 1e-3 - rows[0]
    gone = (rows[-1] - rows[0]) @ way / (way @ way)
    assert 0.01 < gone <= 1.0 + 1e-6
    beside = rows - rows[0] - np.outer((rows - rows[0]) @ way / (way @ way), way)
    assert float(np.abs(beside).max()) < ROUNDED, "on the straight line of all of them"
    speed, accel = made.died.shares()
    assert speed <= 1.0 and accel <= 1.02, "braked as planned"
    assert made.unanswered.state is CommandState.ABORTED and made.unanswered.reason is Reason.PLANNER_LOST


def test_an_emergency_stop_switches_all_32_drives_off(made: Made) -> None:
    assert made.enabled == (EVERY, 0)


def test_only_twelve_axes_have_in_position_and_referenced_among_the_rc_outputs(made: Made) -> None:
    bits = [get_bit(made.outputs, n) for n in range(192, 240)]
    assert bits == [True] * 12 + [False] * 12 + [True] * 12 + [False] * 12


def test_the_check_counts_them_and_refuses_one_more(tmp_path: pathlib.Path) -> None:
    cell = load_cell(str(cell_file(tmp_path)))
    assert plan_programs(cell)[1].mask == EVERY and len(cell.robot) == 16
    (said,) = (notice.text for notice in cell.notes if notice.where == "modbus plc" and "command block" in notice.text)
    assert "up to axis 12 (Y6) only; bits 0..14 of its masks are axes 1..15, bit 15 is Y8 and all after it" in said
    with pytest.raises(CellFaults, match="axis = 33 axes: allowed at most 32"):
        load_cell(str(cell_file(tmp_path, more_axes=1)))
    with pytest.raises(
        CellFaults, match=r"robot = 17: allowed 1\.\.16: robots of one cell\n.*robot = 34: allowed 1\.\.32: axes of all robots of one cell"
    ):
        load_cell(str(cell_file(tmp_path, robots=17)))


# ---- what the own command block says of them


@pytest.mark.parametrize(
    ("axes", "mask", "every", "word"),
    [
        (12, 0xFFF, True, 0xFFF),
        (16, 0xFFFF, True, 0xFFFF),
        (16, 0x7FFF, True, 0x7FFF),
        (32, EVERY, True, 0xFFFF),
        (32, EVERY & ~(1 << 31), True, 0x7FFF),
        (32, 0x7FFF, True, 0x7FFF),
        (32, 1 << 31, False, 0x8000),
        (32, 1, False, 1),
        (32, 0, False, 0),
    ],
)
def test_a_mask_word_has_fifteen_axes_and_one_bit_for_all_behind_them(axes: int, mask: int, every: bool, word: int) -> None:
    assert mask_word(mask, axes, every=every) == word


def test_a_mask_word_commands_all_axes_behind_the_15th_with_its_last_bit() -> None:
    assert [mask_of_word(word, 32) for word in (0x7FFF, 0x8000, 0xFFFF)] == [0x7FFF, EVERY & ~0x7FFF, EVERY]
    assert mask_of_word(0x8001, 16) == 0x8001
    assert mask_of_word(0x8001, 12) == 0x8001, "no axis of this cell: refused"


def fresh(block: CommandBlock, code: Code, mask: int) -> Command:
    block.write(1, [mask, 1000, 1000])
    command = block.write(0, [(0 if block.acknowledged else 0x8000) | code])
    assert isinstance(command, Command)
    return command


def test_the_command_block_enables_all_32_and_is_refused_a_target_it_has_no_place_for(tmp_path: pathlib.Path) -> None:
    cell = load_cell(str(cell_file(tmp_path)))
    dispatcher, block = CommandDispatcher(axis_facts(cell), make_planner(cell), 1), CommandBlock((), AXES)
    state = CellState(cycle=1, generation=1, permits=ALL_PERMITS, override=1.0)
    dispatcher.observe(state, 0)
    block.write(0, [0])
    dispatcher.command(1, fresh(block, Code.REQUEST_CONTROL, 0), 0)
    job = dispatcher.command(1, fresh(block, Code.ENABLE, 0xFFFF), 0)
    assert job.open and job.mask == EVERY and dispatcher.take_orders()[-1].mask == EVERY
    for axis in state.axes:
        axis.flags = FLAGS[AxisFlag.ENABLED | AxisFlag.REFERENCED]
    job = dispatcher.command(1, fresh(block, Code.PTP_ABSOLUTE, 1 << 12), 0)
    assert (job.state, job.reason) == (CommandState.REFUSED, Reason.MASK) and "12 targets are given, none for X7" in job.detail
    words = block.status_words(Status(enabled=mask_word(dispatcher.enabled_mask(), AXES)))
    assert len(words) == 58 and words[2] == 0xFFFF
