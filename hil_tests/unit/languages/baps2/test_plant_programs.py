"""Programs as a plant writes them, dry: what a manual's reader expects of files and semaphores (rho 3 releases L2423-2475, L6866-6945)."""

import struct

import pytest

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
