"""The instruction executed last, as listings mark it by "-" once the program has stopped (L1484-1486); breakpoints."""

import pytest

from gateway.files.robotstar import words
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.memory import Memory, Source
from hil_tests.lab.virtual.reis_bench import ReisCell, at, main
from hil_tests.unit.languages.robotstar.memory import run

BODY = """COPY 1, I1
CALL "S"
BRANCH "B"
LABEL "A"
STOP
LABEL "B"
WAIT 5
"""
SUB = {"S.SPR": "COPY 2, I1\nWAIT 5", "V.MPR": "VAR I1"}


@pytest.mark.parametrize(
    ("seconds", "place", "done"),
    [(1.0, ("S", 3), ("S", 2)), (6.0, ("P", 8), ("P", 7)), (11.0, ("P", 1), ("P", 9))],
)
def test_it_is_the_step_before_the_one_in_work_in_the_order_of_execution(seconds: float, place: object, done: object) -> None:
    ran = run({"P.MPR": BODY, **SUB}, at=(f"{seconds} STOP",), until=seconds + 1)
    assert (ran.cell.robot.place(), ran.cell.robot.machine.last_done()) == (place, done), ran.state


def test_stop_itself_is_executed_and_a_step_that_fails_is_not() -> None:
    stopped = run({"P.MPR": "COPY 1, I1\nSTOP\nWAIT 1", **SUB}).cell.robot
    assert (stopped.place(), stopped.machine.last_done()) == (("P", 4), ("P", 3))
    failed = run({"P.MPR": "COPY 1, I1\nDIV 0, I1", **SUB}).cell.robot
    assert (failed.place(), failed.machine.last_done()) == (("P", 3), ("P", 2))
    loop = run({"P.MPR": 'LABEL "A"\nBRANCH "A"'}, at=("1 STOP",), until=2).cell.robot
    assert loop.machine.last_done() == ("P", 3)
    fresh = run({"P.SPR": "COPY 1, I1", **SUB}).cell.robot
    fresh.machine.to_step(2)
    assert fresh.machine.last_done() == ("", 0), "a step that was chosen (L1208)"


def test_in_a_cell_it_is_the_step_before_the_position_under_way() -> None:
    body = f"MOVE_MODE #LINEAR\nPATH_SPEED 200\n{at(884, 0, 591)}\nWRITE_BIT #MERKER,1,20,0\n{at(884, 250, 591)}\nWAIT 1\nSTOP"
    cell = ReisCell(main(body))
    started = cell.start()
    cell.until(lambda: cell.places[-1][1] > 100)
    row = cell.language.rows()[0]
    assert (row.line, row.done) == (7, 6)
    cell.stop()
    assert cell.ends(started)[0] == "stopped"
    row = cell.language.rows()[0]
    assert (row.state, row.line, row.done) == ("stopped", 7, 6)


def test_a_breakpoint_stops_in_front_of_its_step_in_every_round() -> None:
    body = f'COPY 0, I1\nTOOL T\n{at(884, 0, 591)}\nLABEL "A"\nADD 1, I1\nWAIT_BIT #MERKER,0,50,0,0.0,"A"\nBRANCH "A"'
    cell = ReisCell(main(body) | {"V.MPR": 'MPR "V"\nVAR I1\nEND\n', "S/Q.MPR": 'MPR "Q"\nEND\n'})
    answer = cell.hosted.answer
    assert "error" in answer({"do": "breakpoints", "name": "X", "lines": [1]}, 0)
    assert "error" in answer({"do": "breakpoints", "name": "P", "lines": "7"}, 0)
    assert answer({"do": "breakpoints", "name": "P", "lines": [7, 99]}, 0) == {"ticket": 0}
    assert answer({"do": "outcome", "ticket": 0}, 0) == {"over": True}
    assert answer({"do": "list"}, 0)["breaks"] == {"P": [7, 99]}
    for count in (0, 1, 2):
        assert cell.run() == ("breakpoint", 0, "", "P step 7")
        row = cell.language.rows()[0]
        assert (row.state, row.line, cell.value("I1")) == ("held", 7, str(count))
    assert cell.where() == pytest.approx((884, 0, 591), abs=0.05), "the position before is reached"
    files = [Source(*each) for each in cell.files.items()]
    cell.language.replaced(Memory.read(files, words(), Faults()))
    assert cell.run()[0] == "breakpoint" and cell.language.rows()[0].line == 7, "also once the memory was read anew"
    assert answer({"do": "breakpoints", "name": "P", "lines": []}, 0) == {"ticket": 0}
    run_ = cell.start()
    cell.bench.run(0.5)
    assert run_ not in cell.hosted.results and int(str(cell.value("I1"))) > 2
    assert answer({"do": "value", "name": "I1"}, 0) == {"ok": True}
    cell.bench.run(0.1)
    seen = answer({"do": "list"}, 0)["value"]
    assert isinstance(seen, dict) and seen["name"] == "I1" and seen["value"] > 2 and seen["text"] == ""


def test_a_breakpoint_at_a_step_that_waits_for_a_position_is_passed_once() -> None:
    body = (
        f'TOOL T\nMOVE_MODE #LINEAR\nPATH_SPEED 300\n{at(884, 0, 500)}\nTEST_BIT #MERKER,#=1,50,0,"E"\n{at(884, 60, 500)}\nLABEL "E"\nSTOP'
    )
    cell = ReisCell(main(body))
    assert cell.hosted.answer({"do": "breakpoints", "name": "P", "lines": [6, 7]}, 0) == {"ticket": 0}
    stops = []
    for how in ("breakpoint", "breakpoint", "ended"):
        assert cell.run()[0] == how
        stops.append((cell.language.rows()[0].line, round(cell.where()[1])))
    assert stops == [(6, 0), (7, 0), (11, 60)], cell.told


def test_a_step_that_was_interrupted_at_its_breakpoint_does_not_pass_the_next_one() -> None:
    cell = ReisCell(main("WAIT 2\nWAIT 0.1\nSTOP"))
    assert cell.hosted.answer({"do": "breakpoints", "name": "P", "lines": [3, 4]}, 0) == {"ticket": 0}
    assert cell.run()[3] == "P step 3"
    run_ = cell.start()
    cell.bench.run(0.5)
    cell.stop()
    assert cell.ends(run_)[0] == "stopped"
    assert cell.run() == ("breakpoint", 0, "", "P step 4")


STEPPED = {
    "P.MPR": f'MPR "P"\nTOOL T\nMOVE_MODE #LINEAR\nPATH_SPEED 300\n{at(884, 0, 591)}\nCALL "S"\nM\nCOPY 9, I1\nSTOP\nEND\n',
    "S.SPR": f'SPR "S"\nCOPY 2, I1\n{at(884, 60, 591)}\nEND\n',
    "M.MAC": 'MAC "M"\nCOPY 3, I1\nCOPY 4, I1\nEND\n',
    "V.MPR": 'MPR "V"\nVAR I1\nEND\n',
}


def stepped(cell: ReisCell, how: str) -> tuple[str, int]:
    """One step as the page and tools order it; where the program is behind it."""
    answer = cell.hosted.answer({"do": "step", "name": "", "how": how}, 0)
    assert isinstance(answer.get("run"), int), answer
    assert cell.ends(int(str(answer["run"])))[:3] == ("ended", 0, ""), cell.told
    row = cell.language.rows()[0]
    return row.program, row.line


def test_breakpoint_and_cursor_are_at_the_step_whatever_is_between_the_lines_of_the_file() -> None:
    """The page has one line a step; with an empty line in the file cursor and breakpoint were at different steps."""
    cell = ReisCell({"P.MPR": 'MPR "P"\n\n\nWAIT 0.1\n\nWAIT 0.2\nSTOP\nEND\n'})
    cell.hosted.answer({"do": "breakpoints", "name": "P", "lines": [3]}, 0)
    assert cell.run()[0] == "breakpoint"
    row = cell.language.rows()[0]
    assert (row.state, row.program, row.line) == ("held", "P", 3)


def test_a_program_of_a_directory_is_shown_and_stopped_by_the_name_in_its_row_also_in_what_it_calls() -> None:
    files = {"JOBS/P.MPR": 'MPR "P"\nCALL S\nWAIT 5\nSTOP\nEND\n', "JOBS/S.SPR": 'SPR "S"\nWAIT 0.5\nEND\n'}
    cell = ReisCell(files)
    run = cell.hosted.answer({"do": "start", "name": "JOBS/P"}, 0)["run"]
    cell.bench.run(0.2)
    row = cell.language.rows()[0]
    assert (row.program, row.line) == ("JOBS/S", 2)
    cell.bench.run(0.5)
    assert cell.language.rows()[0].program == "JOBS/P", "whoever sees the row of the sub-program presses Stop a moment later"
    assert cell.hosted.answer({"do": "stop", "name": "JOBS/X"}, 0) == {"error": "JOBS/X: no such process"}
    assert cell.hosted.answer({"do": "stop", "name": row.program}, 0) == {"ok": True}
    assert cell.ends(int(str(run)))[0] == "stopped"


@pytest.mark.parametrize("mode", [1, 2, 4, 6])
def test_a_single_step_of_the_page_in_any_test_mode(mode: int) -> None:
    cell = ReisCell(STEPPED)
    refused = cell.hosted.answer({"do": "step", "name": "P", "how": "into"}, 0)
    assert refused == {"error": "P: single steps are made in Test 1 to 6, not in AUTO"}
    cell.bench.permit(23, value=False)
    cell.control.put("reis.mode", float(mode))
    cell.bench.run(0.1)
    assert "how = 'run'" in str(cell.hosted.answer({"do": "step", "name": "P", "how": "run"}, 0))
    assert "run" in cell.hosted.answer({"do": "step", "name": "P", "how": "into"}, 0)
    cell.bench.run(0.1)
    assert [stepped(cell, "into") for _ in range(4)] == [("P", 3), ("P", 4), ("P", 5), ("P", 6)]
    assert cell.where() == pytest.approx((884, 0, 591), abs=0.05)
    out = cell.hosted.answer({"do": "step", "name": "", "how": "out"}, 0)
    cell.bench.run(0.1)
    assert "P was not called by a program" in cell.hosted.results[int(str(out["run"]))][2]
    assert stepped(cell, "into") == ("S", 1)
    assert stepped(cell, "into") == ("S", 2)
    assert stepped(cell, "out") == ("P", 7)
    assert cell.where() == pytest.approx((884, 60, 591), abs=0.05)
    assert stepped(cell, "into") == ("M", 1)
    assert stepped(cell, "out") == ("P", 8) and cell.value("I1") == "4"
    cell.hosted.select("P", 6)
    assert stepped(cell, "over") == ("P", 7) and cell.value("I1") == "2"
    assert stepped(cell, "over") == ("P", 8) and cell.value("I1") == "4"
    assert cell.run()[0] == "ended" and cell.language.rows()[0].line == (10 if mode in (2, 4) else 9), "START is the mode's again"
