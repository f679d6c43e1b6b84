"""A word that a program lacks is one fault, at its place, which names the word; the rest is read as if it were there (AX-1820)."""

import pytest

from gateway.pure.languages.base.faults import SourceFault
from hil_tests.unit.languages.baps2.test_one_mistake import DECLARED, FIRST, HEAD, check


def faults_of(statements: str) -> list[SourceFault]:
    return list(check(f"{HEAD}PROGRAM P\n{DECLARED}\nBEGIN\n{statements}\nPROGRAM_END\n"))


def places(found: list[SourceFault]) -> list[tuple[int, int]]:
    """Line behind the first statement, and column, of each."""
    return [(each.position.line - FIRST, each.position.column) for each in found]


@pytest.mark.parametrize(
    "statements, line, column, word",
    [
        ("I\nEQUAL 1, 2 : I = 2\nEQUAL 3 : I = 3\nDEFAULT I = 0\nCASE_END", 0, 1, "CASE"),
        ("CASE I\n1, 2 : I = 2\nEQUAL 3 : I = 3\nDEFAULT I = 0\nCASE_END", 1, 1, "EQUAL"),
        ("CASE T\nEQUAL 'A' : I = 2\n'B' : I = 3\nDEFAULT I = 0\nCASE_END", 2, 1, "EQUAL"),
        ("CASE I\nEQUAL 1 : I = 2\nDEFAULT I = 0\n F[1] = 4\nCASE_END", 3, 2, "EQUAL, DEFAULT or CASE_END"),
        ("CASE I\nEQUAL 1 : I = 2\nI = 0\nCASE_END", 2, 1, "EQUAL, DEFAULT or CASE_END"),
        ("CASE I\nEQUAL 1 : I = 2\n F[1] = 3\nEQUAL 2 : I = 3\nDEFAULT I = 0\nCASE_END", 2, 2, "EQUAL, DEFAULT or CASE_END"),
        ("EQUAL 1 : I = 2\nEQUAL 2 : I = 3\nDEFAULT I = 0\nCASE_END", 0, 1, "CASE"),
        ("I = 3 AND E1 = 1\nTHEN BEGIN\nI = 1\nEND\nELSE I = 2", 0, 1, "IF"),
        ("NOT E1 THEN I = 2\nELSE I = 3", 0, 1, "IF"),
        ("I > 1 THEN I = 2 ELSE I = 3", 0, 1, "IF"),
        ("IF E1 THEN\nI = 1\nI = 2\nELSE I = 3", 3, 1, "BEGIN and END"),
        ("IF E1 THEN\nI = 1\nI = 2\nEND\nELSE BEGIN\nI = 3\nEND", 3, 1, "BEGIN"),
        ("IF I = 3 E1 = 1 THEN BEGIN\nI = 1\nEND\nELSE I = 2", 0, 10, "operator"),
        ("IF I 3 THEN I = 1", 0, 6, "operator"),
        ("IF E1 THEN L1 ELSE JUMP L1\nL1:", 0, 12, "JUMP"),
        ("L1: I = 1\nIF E1 THEN BEGIN\nL1\nEND", 2, 1, "JUMP"),
        ("3 TIMES\nI = 1\nREPEAT_END", 0, 1, "REPEAT"),
        ("I = 1\nREPEAT_END\nI = 2", 1, 1, "REPEAT"),
        ("I = 1\nALSO\nI = 2\nALSO\nI = 3\nPARALLEL_END\nI = 4", 1, 1, "PARALLEL"),
        ("RPT 2 TIMES\nI = 1\nALSO\nI = 2\nPARALLEL_END\nRPT_END", 2, 1, "PARALLEL"),
        ("L1: PARALLEL\n I = 1\nALSO\n I = 2\nJUMP L1", 0, 5, "PARALLEL_END"),
        ("S\nI = 1\nEXCLUSIVE_END", 0, 1, "EXCLUSIVE"),
        ("EXCLUSIVE\nI = 1\nEXCLUSIVE_END", 0, 10, "a semaphore"),
        ("WAIT E1 = 0 MAX_TIME = 3 ERROR I = 1", 0, 6, "UNTIL"),
        ("UNTIL E1 = 1\nI = 1", 0, 1, "WAIT"),
        ("MOVE ROB V = 100 TO P1", 0, 10, "WITH"),
        ("MOVE ROB LINEAR E1 = 1\nERROR I = 1\nTO P1", 0, 17, "UNTIL"),
        ("L1: MOVE ROB UNTIL E1 = 1\nJUMP L1\nTO P1", 1, 1, "ERROR"),
        ("ROB LINEAR TO P1", 0, 1, "MOVE"),
        ("LINEAR TO P1", 0, 1, "MOVE"),
        ("'HALLO', I", 0, 1, "WRITE"),
        ("PHG, 'HALLO', I", 0, 1, "READ or WRITE"),
        ("I = \nL1: I = 2\nJUMP L1", 0, 4, "a value"),
    ],
)  # fmt: skip
def test_a_missing_word_is_one_fault(statements: str, line: int, column: int, word: str) -> None:
    found = faults_of(statements)
    assert places(found) == [(line, column)]
    assert word in f"{found[0].text} {found[0].hint}"


@pytest.mark.parametrize(
    "declaration, column",
    [
        ("INTEGER : J : K, M", 13),
        ("INTEGER : J, M  [1..3] INTEGER : K", 17),
        ("ARRAY[1..3 INTEGER : K  INTEGER : J, M", 12),
        ("INTEGER : J, K, M  REAL :", 26),
        ("INTEGER : J, K, M  INPUT : 3 = E3, = E4", 36),
    ],
)
def test_a_declaration_without_its_type_is_one_fault(declaration: str, column: int) -> None:
    found = list(check(f"PROGRAM P\n{declaration}\nTEXT : T\nBEGIN\nT = 'A'\nJ = 1\nM = 2\nPROGRAM_END\n"))
    assert [each.position.column for each in found] == [column]


def test_a_subroutine_without_its_word_is_one_fault() -> None:
    rest = "BEGIN\nN = 1\nSUB_END\n"
    found = check(f"PROGRAM P\nBEGIN\nMELDE (1)\nPROGRAM_END\nMELDE (VALUE INTEGER : N)\n{rest}SUBROUTINE LAST (VALUE INTEGER : N)\n{rest}")
    assert [(each.position.line, each.text) for each in found] == [(5, "SUBROUTINE is missing in front of 'MELDE'")]


def test_a_name_that_is_nothing_is_reported_once() -> None:
    found = check("PROGRAM P\nBEGIN\nWRITE_BEGIN F1\nCLOSE F1\nEXCLUSIVE S\nEXCLUSIVE_END\nEXCLUSIVE S\nEXCLUSIVE_END\nPROGRAM_END\n")
    assert [(each.id, each.position.line) for each in found] == [("file-unknown", 3), ("semaphore", 5)]


@pytest.mark.parametrize(
    "statements",
    [
        "IF E1 THEN MELDE ELSE MELDE",
        "MOVE ROB UNTIL E1 = 1 MAX_TIME = 2 ERROR HALT TO P1",
        "MOVE ROB WITH V = 100, A = 2 UNTIL E1 = 1 ERROR I = 1 TO P1",
        "CASE I EQUAL 1 : BEGIN I = 1 I = 2 END EQUAL -2 : MELDE ELSE I = 3 CASE_END",
        "WAIT I * 0.5\nWAIT 1",
        "INT_ASC (I, T, 1, 2, I)\nIF NOT E1 THEN HALT",
    ],
)
def test_sound_statements_stay_sound(statements: str) -> None:
    assert check(f"{HEAD}PROGRAM P\n{DECLARED}\nBEGIN\n{statements}\nEND\nSR MELDE\nBEGIN\nEND\n").rows() == []


@pytest.mark.parametrize(
    "statements, line, column, text",
    [
        ("L: WHILE I < 3 DO\nI = I + 1\nWHILE_END\nJUMP L", 0, 4, "write a label, IF and JUMP"),
        ("FOR I = 1 TO 3 DO\nWAIT 1\nNEXT I", 0, 1, "REPEAT n TIMES"),
        ("IF E1 THEN\nI = 1\nENDIF\nI = 2", 2, 1, "put several statements between BEGIN and END"),
        ("IF E1 THEN I = 1\nELSEIF I = 2 THEN I = 3\nELSE I = 4", 1, 1, "write ELSE IF"),
        ("CALL I = 1", 0, 1, "called by its name"),
        ("PRINT 'A'", 0, 1, "the word is WRITE"),
        ("IF I != 2 THEN I = 1", 0, 6, "write <>"),
        ("IF E1 && I = 2 THEN I = 1", 0, 7, "write AND"),
        ("I = 1 // set\nI = 2", 0, 7, "a semicolon begins a comment"),
        ("{ set it }\nI = 2", 0, 1, "a semicolon begins a comment"),
    ],
)  # fmt: skip
def test_a_habit_of_another_language_is_one_fault(statements: str, line: int, column: int, text: str) -> None:
    found = faults_of(statements)
    assert places(found) == [(line, column)]
    assert text in found[0].hint


def test_points_of_a_kinematic_that_is_not_declared_are_one_fault() -> None:
    found = check(f"{HEAD}PROGRAM P\nROBB.POINT : P1\nBEGIN\nMOVE TO P1\nPROGRAM_END\n")
    assert [(each.id, each.position.line, each.hint) for each in found] == [("kinematic-unknown", 6, "did you mean ROB?")]


def test_less_than_a_negative_number_is_no_arrow() -> None:
    assert check(f"{HEAD}PROGRAM P\n{DECLARED}\nBEGIN\nIF I <-2 THEN I = 1\nPROGRAM_END\n").rows() == []
