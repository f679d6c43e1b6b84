"""Programs as a plant writes them, dry: what a manual's reader expects of files and semaphores (rho 3 releases L2423-2475, L6866-6945)."""

import struct

import pytest

from hil_tests.lab.virtual.baps2_bench import ProgramCell, one
from hil_tests.unit.languages.baps2.running import all_of, body, faults_of, run


def test_whole_numbers_are_real_in_a_file_of_real() -> None:
    events = all_of(
        body("WRITE_BEGIN F\nWRITE F, 1.5, N\nWRITE F, -4\nWRITE F, A\nCLOSE F", "FILE REAL : F INTEGER : N ARRAY[1..2] INTEGER : A")
    )
    files = events[-1]["files"]
    assert isinstance(files, dict) and bytes.fromhex(files["F.BNR"]) == struct.pack("<5f", 1.5, 0.0, -4.0, 0.0, 0.0)


def test_a_real_of_a_file_does_not_become_a_whole_number() -> None:
    assert faults_of(body("READ_BEGIN F\nREAD F, N", "FILE REAL : F INTEGER : N")) == [("file-type", 5)]


LOOP = """REPEAT 3 TIMES
EXCLUSIVE GUARD
WAIT 0.1
WRITE PHG, '{}'
EXCLUSIVE_END
REPEAT_END
"""


def order(events: list[dict[str, object]]) -> str:
    return "".join(bytes.fromhex(str(each["hex"])).decode() for each in events if each["event"] == "write")


def test_a_semaphore_goes_to_the_one_that_waits_before_its_holder_enters_again() -> None:
    events = run(body(f"PARALLEL\n{LOOP.format('A')}ALSO\n{LOOP.format('B')}PARALLEL_END", "SEMAPHORE : GUARD"))
    assert order(events) == "ABABAB"


@pytest.mark.parametrize("gone", ["STOP OTHER", "HALT"])
def test_a_semaphore_of_a_program_that_is_over_goes_on_to_the_one_that_waits(gone: str) -> None:
    other = "PROGRAM OTHER\nEXTERNAL P : GUARD\nBEGIN\nEXCLUSIVE GUARD\nWRITE PHG, 'O'\nWAIT 2\nEXCLUSIVE_END\nPROGRAM_END\n"
    third = "PROGRAM THIRD\nEXTERNAL P : GUARD\nBEGIN\nEXCLUSIVE GUARD\nWRITE PHG, 'T'\nEXCLUSIVE_END\nPROGRAM_END\n"
    if gone == "HALT":
        other = other.replace("WAIT 2", "WAIT 0.5\nHALT")
    text = body(
        f"START OTHER\nSTART THIRD\nWAIT 1\n{gone if gone != 'HALT' else ''}\nEXCLUSIVE GUARD\nWRITE PHG, 'P'\nEXCLUSIVE_END",
        "EXTERNAL : OTHER, THIRD\nPUBLIC SEMAPHORE : GUARD",
    )
    assert order(run(text, OTHER=other, THIRD=third)) == "OTP"


ARC = "V = 200\nMOVE LINEAR TO (100, 100, 40, 0)\n"


@pytest.mark.parametrize("points", ["(150, 150, 40, 0), (200, 100, 40, 0)", "TO (150, 150, 40, 0), (200, 100, 40, 0)"])
def test_two_points_of_a_list_are_the_way_and_the_end_of_a_circle(points: str) -> None:
    cell = ProgramCell(one(f"{ARC}MOVE CIRCULAR {points}"))
    assert cell.run("P")[:2] == ("ended", 0) and cell.at() == (200.0, 100.0, 40.0, 0.0)
    assert max(place[1] for place in cell.places) == pytest.approx(150.0, abs=0.2), "half a circle of 50 mm"


def test_an_input_ends_a_circle() -> None:
    cell = ProgramCell(
        one(
            f"{ARC}MOVE CIRCULAR UNTIL SEEN = 1 VIA (150, 150, 40, 0) TO (200, 100, 40, 0)\nFOUND = 1",
            "INPUT : 1 = SEEN OUTPUT : 3 = FOUND",
        )
    )
    cell.give(1, False)
    run_number = cell.start("P")
    cell.until(lambda: cell.at()[1] > 130)
    cell.give(1)
    assert cell.ends(run_number)[:2] == ("ended", 0)
    x, y, *_ = cell.at()
    assert (x - 150) ** 2 + (y - 100) ** 2 == pytest.approx(2500.0, rel=1e-3) and 105 < x < 195, "stopped on the circle"


def test_a_program_is_stopped_by_the_name_of_its_file() -> None:
    """File names have up to 8 characters (L649-672), names of programs more."""
    events = run(body("START Q\nWAIT 1\nSTOP Q", "EXTERNAL : Q"), Q="PROGRAM CONVEYOR_2\nBEGIN\nWAIT 9\nPROGRAM_END\n")
    assert [(event["t"], event["process"], event["how"]) for event in events if event["event"] == "end"] == [
        (1.0, "CONVEYOR_2", "stopped"),
        (1.0, "P", "ended"),
    ]
