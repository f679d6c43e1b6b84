"""Three points that make no circle: the same refusal in check, in a virtual run and in a cell (L308-338)."""

import pytest

from hil_tests.lab.virtual.reis_bench import ReisCell, at, main
from hil_tests.unit.languages.robotstar.memory import run

STRAIGHT = "circle: start, auxiliary and end point lie on a straight line"


def arc(via: str, end: str, between: str = "") -> str:
    return f"MOVE_MODE #LINEAR\nPATH_SPEED 300\n{at(884, 0, 591)}\nMOVE_MODE #ZIRK_MIN_ORI\n{via}\n{between}{end}\nMOVE_MODE #LINEAR"


@pytest.mark.parametrize(
    ("via", "end", "wrong"),
    [
        (at(884, 30, 591), at(884, 60, 591), STRAIGHT),
        (at(884, 30, 591), at(884, 10, 591), STRAIGHT),
        (at(884, 30, 591), at(884, 0, 591), "circle: start and end point are the same"),
        (at(884, 0, 591), at(884, 60, 591), "circle: start and auxiliary point are the same"),
        (at(884, 30, 591), at(884, 30.005, 591), "circle: auxiliary and end point are the same"),
    ],
)
def test_check_virtual_run_and_cell_refuse_with_the_same_words(via: str, end: str, wrong: str) -> None:
    ran = run(main(arc(via, end)))
    assert ran.faults == [f"step 8: {wrong}"]
    assert [ran.message()[key] for key in ("text", "number", "step", "class")] == [wrong, None, 8, "path"]
    cell = ReisCell(main(arc(via, end)))
    assert cell.run() == ("aborted", 0, wrong, "P step 8") and cell.told == [f"{wrong} (P step 8)"]


@pytest.mark.parametrize("between", ["RELATIVE _VNULL\n", 'LABEL "A"\n'])
def test_what_the_listing_does_not_show_is_found_as_it_runs(between: str) -> None:
    ran = run(main(arc(at(884, 30, 591), at(884, 60, 591), between)))
    assert not ran.faults and ran.texts() == [STRAIGHT]


def test_an_open_circle_is_found_in_the_listing_and_a_real_one_is_not_blamed() -> None:
    ran = run(main(arc(at(884, 30, 591), "C nothing")))
    wrong = "circle without its end point before #LINEAR: an even number of positions is needed"
    assert ran.faults == [f"step 9: {wrong}"] and ran.texts() == [wrong]
    body = arc(at(884, 30, 600), f"{at(884, 60, 591)}\nCALC_REL V\n{at(884, 70, 600)}\n{at(884, 90, 600)}\n{at(884, 120, 591)}")
    assert not run(main(body) | {"V.MPR": "VAR V"}).faults


def test_points_of_a_circle_are_positions_of_the_tool() -> None:
    axes = "POSITION #N, A1:0, A2:0, A3:0, A4:0, A5:0, A6:0"
    for via, end, what in ((axes, at(884, 60, 591), "an auxiliary"), (at(884, 30, 600), axes, "the end")):
        wrong = f"circle: {what} point is a position of the tool, not of the axes"
        assert run(main(arc(via, end))).texts() == [wrong]
        assert ReisCell(main(arc(via, end))).run()[2] == wrong
