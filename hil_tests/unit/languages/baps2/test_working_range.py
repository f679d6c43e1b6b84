"""LIMIT_MIN and LIMIT_MAX: a block that leads out of them is an error of the program, dry and in a cell (rho 3 releases L8976-8983)."""

import pytest

from hil_tests.lab.virtual.baps2_bench import HEAD, ProgramCell, one
from hil_tests.unit.languages.baps2.running import run

SET = "LIMIT_MIN = (0, 0, 0, -90)\nLIMIT_MAX = (300, 300, 100, 90)\n"
INSIDE = "MOVE LINEAR TO (100, 60, 40, 12)\n"
OUT = [
    ("MOVE LINEAR TO (301, 60, 40, 12)", "component 1 = 301, LIMIT_MAX is 300"),
    ("MOVE PTP TO @(100, 60, 40, 91)", "component 4 = 91, LIMIT_MAX is 90"),
]


@pytest.mark.parametrize(("block", "words"), OUT)
def test_a_point_outside_ends_the_program_where_it_is_prepared_in_a_cell(block: str, words: str) -> None:
    cell = ProgramCell(one(f"{SET}{INSIDE}WAIT 0.1\n{block}"))
    ended = cell.run("P")
    assert ended[1:3] == (225, f"outside the working range: {words}") and ended[3] == "P.QLL line 12"
    assert cell.at() == (100.0, 60.0, 40.0, 12.0)


@pytest.mark.parametrize(("block", "words"), OUT)
def test_and_in_a_dry_run(block: str, words: str) -> None:
    feed = "[start]\nPORTAL = [0, 0, 0, 0]\n"
    events = run(f"{HEAD}PROGRAM P\nBEGIN\n{SET}{INSIDE}{block}\nPROGRAM_END\n", feed)
    assert [(each["code"], each["text"]) for each in events if each["event"] == "error"] == [(225, f"outside the working range: {words}")]


def test_a_relative_block_that_leads_out_is_refused_by_the_planner() -> None:
    cell = ProgramCell(one(f"{SET}{INSIDE}WAIT 0.1\nMOVE_REL LINEAR (0, 0, 70, 0)"))
    ended = cell.run("P")
    assert ended[0] == "aborted" and ended[3] == "P.QLL line 12"
    assert cell.at() == (100.0, 60.0, 40.0, 12.0)


def test_the_range_counts_in_the_workpiece_system_and_ends_with_the_program() -> None:
    files = one(f"WC_SYSTEM = WC_FRAME(50, 0, 0, 0, 0, 0)\n{SET}MOVE LINEAR TO (300, 60, 40, 12)\nWC_SYSTEM = WC_UR")
    cell = ProgramCell(files | one("MOVE LINEAR TO (360, 60, 40, 12)", name="Q"))
    assert cell.run("P")[:2] == ("ended", 0) and cell.at()[0] == 350.0
    assert cell.run("Q")[:2] == ("ended", 0)


def test_ends_that_cross_are_refused() -> None:
    ended = ProgramCell(one(f"{SET}LIMIT_MIN = (0, 301, 0, 0)")).run("P")
    assert ended[1] == 218 and "component 2 of LIMIT_MIN is 301, of LIMIT_MAX 300" in ended[2]
