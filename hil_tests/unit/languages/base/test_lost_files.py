"""What a program has written and is not on the disk is known once it is over: the interpreter reports it with its end."""

from collections.abc import Callable

import pytest

from gateway.pure.languages.base.lost_files import LostFiles
from hil_tests.lab.virtual.baps2_bench import ProgramCell, one
from hil_tests.lab.virtual.reis_bench import ReisCell, main
from hil_tests.lab.virtual.val3_cell_bench import Val3Cell
from hil_tests.unit.languages.val3.apps import App


def test_a_run_reports_what_was_lost_while_it_was_under_way() -> None:
    lost_files = LostFiles()
    assert lost_files.written(["A"]) == []
    lost_files.begins(1)
    assert lost_files.written(["B"]) == []
    lost_files.begins(2)
    lost_files.over(1)
    assert lost_files.written(["C", "B"]) == [(1, ["B", "C"])]
    lost_files.over(2)
    lost_files.over(1 << 20)  # a program has started it
    assert lost_files.written([]) == [(2, ["C", "B"])]
    assert lost_files.written(["D"]) == []


Cell = ProgramCell | ReisCell | Val3Cell
CELLS: dict[str, Callable[[], Cell]] = {
    "rho3": lambda: ProgramCell(one("WAIT 0.1")),
    "robotstar": lambda: ReisCell(main("WAIT 0.1\nSTOP")),
    "val3": lambda: Val3Cell(App(programs={"start": "delay(0.1)"}).files(), "demo"),
}


def started(language: str) -> tuple[Cell, int]:
    """A program of 0.1 s in a cell."""
    cell = CELLS[language]()
    return cell, cell.start("demo" if language == "val3" else "P")


def state(cell: Cell, run: int) -> dict[str, object]:
    """As a tool asks for it."""
    if isinstance(cell, ProgramCell):
        return cell.hosted.results.answer(run, cell.hosted.rows, alive=bool(cell.hosted.language_id))
    programs = cell.hosted if isinstance(cell, ReisCell) else cell.programs
    return programs.answer({"do": "state", "run": run}, 0)


@pytest.mark.parametrize("language", CELLS)
def test_a_tool_learns_of_it_once_all_is_written(language: str) -> None:
    cell, run = started(language)
    cell.ends(run)
    assert (state(cell, run)["over"], state(cell, run)["kept"]) == (True, False)
    cell.hosted.hear({"say": "kept", "id": cell.hosted.language_id, "run": run, "text": "A\nB"}, 0)
    assert (state(cell, run)["kept"], state(cell, run)["lost"]) == (True, ["A", "B"])


@pytest.mark.parametrize("language", CELLS)
def test_nothing_is_awaited_of_an_interpreter_that_is_gone(language: str) -> None:
    cell, run = started(language)
    cell.bench.run(0.02)
    cell.dies()
    cell.bench.run(0.2)
    cell.born(2)
    cell.bench.run(0.2)
    assert (state(cell, run)["how"], state(cell, run)["kept"]) == ("lost", True)
