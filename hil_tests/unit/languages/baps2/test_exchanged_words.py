"""Two neighbours that are exchanged, a block without its end, a name missing after a label: one fault each (AX-1835, AX-1836)."""

import pytest

from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.store import MemoryStore
from hil_tests.unit.languages.baps2.words import WORDS

PALLET = """;;KINEMATICS : ( 1 = PORTAL, 2 = FEEDER )
;;PORTAL.JC_NAMES = A1, A2
;;PORTAL.WC_NAMES = X, Y
;;FEEDER.JC_NAMES = B
;;FEEDER.WC_NAMES = U
PROGRAM PALLET
SPC_FCT : 15 = BELT_PAR (VALUE INTEGER : NO VALUE REAL : STOPPED, RUN VALUE INTEGER : MS)
INPUT : 1 = PART, 2 = READY
OUTPUT : 3 = LAMP
CONST : PITCH = 40
INTEGER : ROW, COUNT
DEF PORTAL.POINT : PICK, PLACE
FEEDER.POINT : FEED
BEGIN
BELT_PAR (1, 0.5, 2.5, 40)
NEXT: ROW = 0
REPEAT 3 TIMES
  WAIT UNTIL PART = 1 MAX_TIME = 2 ERROR JUMP OFF
  MOVE PORTAL LINEAR WITH V = 200 VIA PICK
  MOVE PORTAL TO PLACE
  PLACE.X = PLACE.X + PITCH * ROW
  ROW = ROW + 1
  FEED = (12.5)
REPEAT_END
CASE COUNT
EQUAL 1, 2 : LAMP = 1
EQUAL 3 : BEGIN
    LAMP = 0
    SIGNAL (COUNT, LAMP)
  END
DEFAULT LAMP = 0
CASE_END
IF READY = 1 THEN JUMP NEXT
WRITE PHG, 'rows ', ROW
OFF:
LAMP = 0
PROGRAM_END
SUBROUTINE SIGNAL (VALUE INTEGER : N OUTPUT : WHAT)
BEGIN
  RPT N TIMES
    WHAT = 1
  RPT_END
SUB_END
"""


def faults_of(text: str) -> Faults:
    """The faults of a program."""
    return Library(WORDS, MemoryStore({"P.QLL": text})).check("P.QLL", text)[1]


def changed(sound: str, faulty: str) -> tuple[str, int]:
    """The program with one place changed, and its line."""
    assert PALLET.count(sound) == 1
    at = PALLET.index(sound)
    return PALLET.replace(sound, faulty), PALLET[:at].count("\n") + 1


def test_the_program_itself_is_sound() -> None:
    assert faults_of(PALLET).rows() == []


@pytest.mark.parametrize(
    "sound, faulty, exchanged",
    [
        ("PROGRAM PALLET", "PALLET PROGRAM", "'PALLET' and 'PROGRAM'"),
        ("(VALUE INTEGER : NO", "(VALUE : INTEGER NO", "':' and 'INTEGER'"),
        ("INPUT : 1 = PART", "INPUT : = 1 PART", "'=' and '1'"),
        ("INTEGER : ROW", ": INTEGER ROW", "':' and 'INTEGER'"),
        ("DEF PORTAL.POINT : PICK", "DEF PORTAL.POINT PICK :", "'PICK' and ':'"),
        ("NEXT: ROW = 0", ": NEXT ROW = 0", "':' and 'NEXT'"),
        ("WAIT UNTIL PART", "UNTIL WAIT PART", "'UNTIL' and 'WAIT'"),
        ("MAX_TIME = 2 ERROR", "MAX_TIME = ERROR 2", ""),
        ("ERROR JUMP OFF", "JUMP ERROR OFF", "'JUMP' and 'ERROR'"),
        ("MOVE PORTAL TO PLACE", "MOVE TO PORTAL PLACE", "'TO' and 'PORTAL'"),
        ("V = 200 VIA", "V = VIA 200", "'VIA' and '200'"),
        ("CASE COUNT", "COUNT CASE", "'COUNT' and 'CASE'"),
        ("EQUAL 3 : BEGIN", "EQUAL : 3 BEGIN", "':' and '3'"),
        ("EQUAL 3 : BEGIN", "EQUAL 3 BEGIN :", "'BEGIN' and ':'"),
        ("(COUNT, LAMP)", "(COUNT LAMP ,)", ""),
        ("WRITE PHG,", "PHG WRITE,", "'PHG' and 'WRITE'"),
        ("RPT N TIMES", "N RPT TIMES", "'N' and 'RPT'"),
    ],
)
def test_two_neighbours_exchanged_are_one_fault(sound: str, faulty: str, exchanged: str) -> None:
    text, line = changed(sound, faulty)
    found = list(faults_of(text))
    assert [each.position.line for each in found] == [line]
    if exchanged:
        assert found[0].text == f"{exchanged} are exchanged"
        assert found[0].hint.startswith("write ")


@pytest.mark.parametrize(
    "sound, faulty, text",
    [
        ("INPUT : 1 = PART,", "INPUT : 1 = PART, ,", "',' is written twice"),
        ("EQUAL 3 : BEGIN", "EQUAL 3 : : BEGIN", "':' is written twice"),
        ("CONST : PITCH", "CONST : : PITCH", ""),
        ("BELT_PAR (VALUE", "BELT_PAR ((VALUE", "'(' is written twice"),
        ("'rows ', ROW", "'rows ' ROW", ""),
        ("VIA PICK", "VIA PICK PLACE", ""),
        ("NEXT: ROW = 0", "NEXT: = 0", "a statement is expected, not '='"),
        ("OFF:\nLAMP = 0", "OFF:\n = 0", ""),
        ("VALUE REAL :", "REAL :", "VALUE is missing in front of REAL"),
        ("EQUAL 3 : BEGIN", "EQUAL 3 :", "BEGIN is missing after ':'"),
        ("FEEDER.POINT :", "FEDER.POINT :", "kinematic FEDER is not declared"),
        ("DEF PORTAL.POINT", "DEF PROTAL.POINT", "kinematic PROTAL is not declared"),
    ],
)
def test_one_more_mistake_is_one_fault(sound: str, faulty: str, text: str) -> None:
    program, line = changed(sound, faulty)
    found = list(faults_of(program))
    assert len(found) == 1 and found[0].position.line in (line, line + 1)
    assert text in found[0].text


@pytest.mark.parametrize(
    "sound, line, text",
    [
        ("REPEAT_END\n", 17, "REPEAT has no REPEAT_END"),
        ("CASE_END\n", 25, "CASE has no CASE_END"),
        ("  END\n", 27, "BEGIN has no END"),
        ("  RPT_END\n", 40, "REPEAT has no REPEAT_END"),
    ],
)
def test_a_block_without_its_end_is_reported_where_it_begins(sound: str, line: int, text: str) -> None:
    found = list(faults_of(PALLET.replace(sound, "", 1)))
    assert [(each.id, each.position.line, each.text) for each in found] == [("not-closed", line, text)]
    assert found[0].hint


def test_a_name_that_is_no_channel_is_named() -> None:
    found = list(faults_of(PALLET.replace("(COUNT, LAMP)", "(COUNT, LAPM)")))
    assert [(each.id, each.text, each.hint) for each in found] == [("name-unknown", "LAPM is not declared", "did you mean LAMP?")]


def test_a_belt_that_is_misspelt_is_reported_once() -> None:
    text = ";;KINEMATICS : 1 = R\n;;R.WC_NAMES = X, B\nPROGRAM P\nR.BELT : 501 = BLET\nBEGIN\nSYNCHRON R BELT1\nMOVE (1, 2)\nSYNCHRON_END\n"
    found = list(faults_of(text.replace("BLET", "BELT2").replace("BELT1", "BELTX") + "SYNC BELTX >= 4\nPROGRAM_END\n"))
    assert [(each.id, each.position.line) for each in found] == [("belt-unknown", 6)]
