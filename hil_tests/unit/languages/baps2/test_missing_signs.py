"""One bracket or one name of a declaration that is missing is one fault in its line (AX-1822)."""

import pytest

from gateway.pure.languages.baps2 import repair
from gateway.pure.languages.baps2.expansion import expanded
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.source import SourceFile
from hil_tests.bench.program_bench import words
from hil_tests.unit.languages.baps2.running import faults_of, library_of

PROGRAM = """;;CONTROL = RHO3
;;KINEMATICS : (1 = ROB, 2 = PRESS)
;;ROB.WC_NAMES = X, Y, Z, C
;;PRESS.WC_NAMES = H, K
PROGRAM P
CONST : FIRST = 2,
        WIDE = 3 + (2 * 4),
        LAST = 9
SPC_FCT : 28 = SET_BELT (VALUE INT : NR
                         VALUE REAL : LENGTH)
INPUT : 1 = PART, 2 = GATE
OUTPUT : 3 = LAMP
ARRAY[1..5] INTEGER : PLACES
ROB.POINT : HOME, GRIP
ROB.JC_POINT : @REST
SEMAPHORE : ZONE
FILE : LOG
INTEGER : I, COUNT
BEGIN
I = FIRST + LAST * (WIDE - 1)
PLACES[I] = PLACES[I + 1]
GRIP = HOME + (0, 0, 50, 0)
MOVE ROB LINEAR VIA (1, 2, 3, 4) TO GRIP
@REST = JC(HOME)
SET_BELT(1, 2.5)
EXCLUSIVE ZONE
COUNT = COUNT + 1
EXCLUSIVE_END
WRITE LOG, CHR(65), COUNT
IF (PART = 1 OR GATE = 1) AND COUNT > 3 THEN LAMP = 1
SHOW(COUNT, 3)
PROGRAM_END
SUBROUTINE SHOW (VALUE INT : WHAT, SIZE)
BEGIN
WRITE WHAT, SIZE
SUB_END
"""
NAMES = ["FIRST", "LAST", "SET_BELT", "PART", "GATE", "LAMP", "PLACES", "@REST", "ZONE", "LOG", "COUNT", "SHOW", "WHAT", "SIZE"]
BRACKETS = [place for place, sign in enumerate(PROGRAM) if sign in "()[]"]


def test_the_program_itself_is_sound() -> None:
    assert faults_of(PROGRAM) == []


@pytest.mark.parametrize("place", BRACKETS, ids=[f"{PROGRAM.count(chr(10), 0, place) + 1}-{place}" for place in BRACKETS])
def test_a_missing_bracket_is_one_fault(place: int) -> None:
    line = PROGRAM.count("\n", 0, place) + 1
    found = [each for _, each in faults_of(PROGRAM[:place] + " " + PROGRAM[place + 1 :])]
    assert len(found) <= 1  # the brackets of KINEMATICS may be left out
    assert line == 2 or found == [line]


@pytest.mark.parametrize("name", NAMES)
def test_a_missing_name_of_a_declaration_is_one_fault(name: str) -> None:
    declared = f"SUBROUTINE {name}" if name == "SHOW" else name
    place = PROGRAM.index(declared) + len(declared) - len(name)
    line = PROGRAM.count("\n", 0, place) + 1
    found = faults_of(PROGRAM[:place] + PROGRAM[place + len(name) :])
    assert [each for _, each in found] == [line]


def test_the_fault_says_which_name_is_not_declared() -> None:
    fault = next(iter(library_of({}).check("P.QLL", PROGRAM.replace("3 = LAMP", "3 ="))[1]))
    assert fault.hint == "LAMP of line 30 is not declared"
    assert (fault.position.line, fault.position.column) == (12, 13)


def test_a_second_mistake_is_a_second_fault() -> None:
    text = PROGRAM.replace("JC(HOME)", "JC HOME)").replace("COUNT > 3", "COUNT > TREE")
    assert faults_of(text) == [("syntax", 24), ("name-unknown", 30)]


@pytest.mark.parametrize("wrong", ["(1 = , 2 = PRESS)", "(1 = ROB 2 = )"])
def test_a_faulty_list_of_kinematics_is_one_fault(wrong: str) -> None:
    assert faults_of(PROGRAM.replace("(1 = ROB, 2 = PRESS)", wrong)) == [("kinematics", 2)]


def test_a_statement_of_thousands_of_brackets_is_looked_at_in_part() -> None:
    """The work grew with the square of their number: 6,000 of them held an editor up for seconds."""
    text = "PROGRAM P\nBEGIN\nI = " + "(" * 2_000 + "1\nPROGRAM_END\n"
    tokens, _ = expanded(SourceFile("P.QLL", text), words(), Memory({}), Faults())
    found = Faults()
    found.error("syntax", tokens[5].position, "something is missing")
    assert 0 < len(list(repair._brackets(tokens, found))) <= repair.MOST_OPEN * repair.MOST_GAPS
