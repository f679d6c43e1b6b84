"""A circle has two points; the program ends where the second one is missing (AX-1744)."""

import pytest

from hil_tests.lab.virtual.baps2_bench import ProgramCell, one
from hil_tests.unit.languages.baps2.running import body, run, short

ROBOTS = ";;KINEMATICS : (1 = ROB, 2 = FEED)\n;;ROB.WC_NAMES = X, Y\n;;FEED.WC_NAMES = U\n"
FIRST = "MOVE CIRCULAR VIA (1, 1)\n"


@pytest.mark.parametrize(
    "text, line",
    [
        (FIRST, 8),
        (FIRST + "MOVE LINEAR TO (2, 0)", 9),
        (FIRST + "MOVE FEED CIRCULAR TO (2)", 9),
        (FIRST + "WAIT 0.1\nMOVE CIRCULAR TO (2, 0)", 9),
        (FIRST + "B = E\nMOVE CIRCULAR TO (2, 0)", 9),
        (FIRST + "HALT", 9),
        ("MOVE CIRCULAR TO (2, 0)", 8),
        (FIRST + "MOVE CIRCULAR VIA (2, 0)\nMOVE CIRCULAR TO (3, 1)", 10),
    ],
)
def test_a_circle_without_its_second_point_ends_the_program(text: str, line: int) -> None:
    events = run(ROBOTS + ";;KINEMATICS = ROB\n" + body(text, "INPUT : 1 = E BINARY : B"), "[start]\nROB = [0, 0]\nFEED = [0]")
    assert [(event["code"], event["line"]) for event in events if event["event"] == "error"] == [(223, line)]


def test_outputs_and_texts_may_be_between_the_points() -> None:
    text = FIRST + "O = 1\nWRITE 'A'\nB = A\nMOVE CIRCULAR VIA (2, 0)\nMOVE LINEAR TO (3, 0)"
    events = run(ROBOTS + body(text, "OUTPUT : 1 = O INPUT : 1001 = A BINARY : B"), "[start]\nROB = [0, 0]\nFEED = [0]")
    assert short(events, "error", "end") == [(3.0, "end", "ended")]


def test_a_cell_does_not_wait_for_the_second_point() -> None:
    for text in ("MOVE CIRCULAR VIA (100, 105, 100, 25)", "MOVE CIRCULAR VIA (100, 105, 100, 25)\nMOVE LINEAR TO (80, 80, 60, 20)"):
        assert ProgramCell(one(text)).run("P", 10.0)[:2] == ("aborted", 223)
