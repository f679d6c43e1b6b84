"""The instruction executed last, as listings mark it by "-" once the program has stopped (L1484-1486)."""

import pytest

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
