"""What a program has written and is not on the disk is known once it is over: the interpreter reports it with its end."""

from gateway.pure.languages.base.lost_files import LostFiles
from gateway.services.rho3_programs import _outcome
from hil_tests.lab.virtual.baps2_bench import ProgramCell, one


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


def test_a_tool_learns_of_it_once_all_is_written() -> None:
    cell = ProgramCell(one("WAIT 0.1"))
    run = cell.start("P")
    cell.ends(run)
    assert (_outcome(cell.hosted, run)["over"], _outcome(cell.hosted, run)["kept"]) == (True, False)
    cell.hosted.hear({"say": "kept", "id": 1, "run": run, "text": "A\nB"}, 0)
    assert (_outcome(cell.hosted, run)["kept"], _outcome(cell.hosted, run)["lost"]) == (True, ["A", "B"])


def test_nothing_is_awaited_of_an_interpreter_that_is_gone() -> None:
    cell = ProgramCell(one("WAIT 9"))
    run = cell.start("P")
    cell.bench.run(0.2)
    cell.dies()
    cell.bench.run(0.2)
    cell.born(2)
    cell.bench.run(0.2)
    assert (_outcome(cell.hosted, run)["how"], _outcome(cell.hosted, run)["kept"]) == ("lost", True)
