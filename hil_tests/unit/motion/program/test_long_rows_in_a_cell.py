"""Rows of splines of any length run in a cell: the planner shows life and takes orders while it works one out."""

import gc
import math
import time
from collections.abc import Callable

import pytest

from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.image.reasons import CommandState
from gateway.pure.image.records.planner import BlockRecord, PieceRecord, ProgramOrder, Say, run_record
from gateway.pure.planning.cycle_view import CycleView
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot

SPLINES = 600
HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 300 100 50 0\n"
PATH = find_config("portal", "cells")
MOST = 0.3  # of all the work, in one slice: it was all of it


@pytest.fixture
def cell() -> Planned:
    shipped = read_text(PATH).replace('by = "gateway", mode = 0', 'by = "none", mode = 0')
    return Planned(ServodynRobot(cell=load_cell(str(PATH), shipped)))


def row(count: int = SPLINES, far: int = 10_000) -> list[str]:
    """Twice around a circle of 150 mm that rises; far: this one is out of reach."""
    lines = []
    for k in range(1, count + 1):
        a = 4.0 * math.pi * k / SPLINES
        x = 300 + 150 * math.sin(a) + (9000 if k == far else 0)
        lines.append(f"spline pose {x:.4f} {250 - 150 * math.cos(a):.4f} {50 + 0.02 * k:.4f} 0 0 0")
    return lines


def share_of_the_worst(calls: list[Callable[[], object]], more: Callable[[], bool], go: Callable[[], object]) -> float:
    """Of the processor time of all calls, then of `go` as long as there is more."""
    spent = []
    gc.collect()
    gc.disable()  # what other tests have left is not gone through in one of the slices
    try:
        while calls or more():
            begin = time.process_time()
            (calls.pop(0) if calls else go)()
            spent.append(time.process_time() - begin)
    finally:
        gc.enable()
    return max(spent) / sum(spent)


@pytest.mark.parametrize("behind", ["", "linear pose 320 110 70 0 0 0", "linear pose 320 110 70 0 0 0 until=900"])
def test_a_row_of_a_program_is_worked_out_in_slices(cell: Planned, behind: str) -> None:
    cell.text = "\n".join([HEAD, "set path=200", *row(), behind])
    programs, standing = cell.programs, [0.3, 0.1, 0.05, 0.0]
    programs.turn([run_record(ProgramOrder(1, 1, 1.0, 1.0))], CycleView(1, 0, standing, moving=False))
    worst = share_of_the_worst([], lambda: programs.preparing, lambda: programs.prepare(standing))
    assert not programs.state.fault and programs.state.job == 1
    assert worst < MOST


@pytest.mark.parametrize("last", [Say.FINISH, Say.END])
def test_a_row_that_comes_as_a_stream_is_worked_out_in_slices_and_what_comes_behind_waits(cell: Planned, last: Say) -> None:
    programs, standing = cell.programs, [0.3, 0.1, 0.05, 0.0]
    lines = [BlockRecord(Say.LINE, 1, text) for text in (*HEAD.splitlines(), "set path=200", *row())]
    pieces: list[PieceRecord] = []

    def turn(*records: BlockRecord) -> None:
        pieces.extend(programs.turn(records, CycleView(1, 0, standing, moving=False)))

    turn(BlockRecord(Say.BEGIN, 1))
    for first in range(0, len(lines), 64):
        turn(*lines[first : first + 64])
    behind = [lambda: turn(BlockRecord(last, 1), BlockRecord(Say.LINE, 1, "linear pose 320 110 70 0 0 0"), BlockRecord(Say.END, 1))]
    assert share_of_the_worst(list(behind), lambda: programs.preparing, lambda: programs.prepare(standing)) < MOST
    turn()
    assert not programs.state.fault and programs.state.waiting >= SPLINES
    for _ in range(200):
        while programs.working and not programs.work():
            pass
        turn()
    assert pieces, "it is handed on"


def test_a_row_is_dropped_in_the_middle_of_it(cell: Planned) -> None:
    programs, standing = cell.programs, [0.3, 0.1, 0.05, 0.0]
    cell.text = "\n".join([HEAD, *row(100)])
    programs.turn([run_record(ProgramOrder(1, 1, 1.0, 1.0))], CycleView(1, 0, standing, moving=False))
    for _ in range(130):
        programs.prepare(standing)
    assert programs.preparing
    programs.turn([BlockRecord(Say.DROP, 1)], CycleView(1, 0, standing, moving=False))
    assert not programs.preparing and programs.state.job == 0 and not programs.state.fault
    cell.text = f"{HEAD}linear pose 320 110 70 0 0 0"
    programs.turn([run_record(ProgramOrder(2, 1, 1.0, 1.0))], CycleView(1, 0, standing, moving=False))
    while programs.preparing:
        programs.prepare(standing)
    assert programs.state.job == 2 and not programs.state.fault


def test_a_fault_in_a_long_row_names_its_line_and_nothing_moves(cell: Planned) -> None:
    before = [axis.set for axis in cell.state.axes]
    job = cell.bench.settle(cell.order("\n".join([HEAD, *row(far=555)])))
    assert job.state is CommandState.REFUSED and f"line {len(HEAD.splitlines()) + 1 + 555}" in job.detail, job.detail
    assert [axis.set for axis in cell.state.axes] == before


def test_600_splines_run_in_a_cell(cell: Planned) -> None:
    assert cell.bench.settle(cell.order(f"{HEAD}ptp joints 300 100 50 0")).state is CommandState.DONE
    cell.driven()
    job = cell.order("\n".join([HEAD, "set path=200", *row()]))
    for _ in range(20_000):
        if not job.open:
            break
        cell.bench.cycle()
    assert job.state is CommandState.DONE, (job.state, job.reason, job.detail)
    made = cell.driven()
    assert max(made.shares()) <= 1.03
    assert abs(math.hypot(*(made.sets[-1, :2] - [0.3, 0.25])) - 0.15) < 1e-4
    assert abs(made.sets[-1, 2] - (0.05 + SPLINES * 0.02e-3)) < 1e-4
