"""A program with one mistake of a kind users make has one fault, at the line and column of the mistake."""

import pytest

from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.base.store import MemoryStore
from hil_tests.unit.languages.baps2.words import WORDS

HEAD = ";;CONTROL = RHO3\n;;KINEMATICS : (1 = ROB)\n;;ROB.JC_NAMES = A1, A2\n;;ROB.WC_NAMES = X, Y\n"
DECLARED = "INTEGER : I  SEMAPHORE : S  INPUT : 1 = E1  DEF ROB.POINT : P1  TEXT : T  ARRAY[1..5] INTEGER : F"
FIRST = 8  # line of the first statement


def check(text: str) -> Faults:
    """The faults of a program."""
    return Library(WORDS, MemoryStore({"P.QLL": text})).check("P.QLL", text)[1]


@pytest.mark.parametrize(
    "statements, id, line, column",
    [
        ("CSAE I\nEQUAL 1 : I = 2\nEQUAL 2 : I = 3\nDEFAULT I = 0\nCASE_END", "name-unknown", 0, 1),
        ("CASE I\nEQAL 1 : I = 2\nEQUAL 2 : I = 3\nCASE_END", "name-unknown", 1, 1),
        ("CASE I\nEQUAL 1 : I = 2\nEQAUL 2 : I = 3\nCASE_END", "name-unknown", 2, 1),
        ("CASE I\nEQUAL 1 : I = 2\nDEFALT I = 0\nCASE_END", "name-unknown", 2, 1),
        ("CASE I\nEQUAL 1 : I = 2\nCASEEND", "name-unknown", 2, 1),
        ("CASE I\nEQUAL 1 : I = 2\nDEFAULT I = 0\nCASE_EN", "name-unknown", 3, 1),
        ("PARALELL\n I = 1\nALSO\n I = 2\nPARALLEL_END", "name-unknown", 0, 1),
        ("PARALLEL\n I = 1\nALSSO\n I = 2\nPARALLEL_END", "name-unknown", 2, 1),
        ("PARALLEL\n I = 1\nALSO\n I = 2\nPARALELL_END", "name-unknown", 4, 1),
        ("EXCLUSVE S\n I = 1\nEXCLUSIVE_END", "name-unknown", 0, 1),
        ("EXCLUSIVE S\n I = 1\nEXCLUSIV_END", "name-unknown", 2, 1),
        ("RPTT 3 TIMES\n I = 1\nRPT_END", "name-unknown", 0, 1),
        ("RPT 3 TIMS\n I = 1\nRPT_END", "syntax", 0, 7),
        ("RPT 3\n I = 1\nRPT_END", "syntax", 0, 6),
        ("RPT 3 TIMES\n I = 1\nRPTEND", "name-unknown", 2, 1),
        ("REPEET 3 TIMES\n I = 1\nREPEAT_END", "name-unknown", 0, 1),
        ("WDHH 3 MAL\n I = 1\nWDH_ENDE", "name-unknown", 0, 1),
        ("IF I = 1 THNE I = 2", "syntax", 0, 10),
        ("IF I = 1 THEN I = 2 ESLE I = 3", "name-unknown", 0, 21),
        ("IF I = 1 THEN BGEIN\n I = 2\nEND", "name-unknown", 0, 15),
        ("IF I = 1 THEN BEGIN\n I = 2\nEDN", "name-unknown", 2, 1),
        ("WAIT UNTL E1 = 1", "syntax", 0, 6),
        ("MVOE ROB TO P1", "name-unknown", 0, 1),
        ("MOVE ROB LINAER TO P1", "syntax", 0, 10),
        ("MOVE ROB LINEAR TO P1\nMOVE ROB UNTL E1 = 1 TO P1", "syntax", 1, 10),
        ("WRITE PHG 'A', I", "syntax", 0, 11),
        ("WRTIE PHG, I", "name-unknown", 0, 1),
        ("JUMP L9", "label-missing", 0, 1),
        ("JUMP GO\nGO WRITE I", "name-unknown", 1, 1),
        ("RPT 3 TIMES\n I = 1\nRPT END", "syntax", 2, 1),
        ("PARALLEL\n I = 1\nALSO\n I = 2\nPARALLEL END", "syntax", 4, 1),
        ("EXCLUSIVE S\n I = 1\nEXCLUSIVE END", "syntax", 2, 1),
        ("CASE I\nEQUAL 1 = I = 2\nEQUAL 2 : I = 3\nCASE_END", "syntax", 1, 9),
        ("CASE I\nEQUAL 1 ; I = 2\nEQUAL 2 : I = 3\nCASE_END", "syntax", 1, 9),
        ("IF I = 1 I = 2\nELSE I = 3", "syntax", 0, 10),
        ("IF I > < 1 THEN I = 2\nELSE I = 3", "syntax", 0, 8),
        ("IF I == 1 THEN I = 2", "syntax", 0, 7),
        ("I := 3", "syntax", 0, 3),
        ("P1.X := 3", "syntax", 0, 6),
        ("WAIT 0,5", "syntax", 0, 6),
        ("WAIT O.5", "syntax", 0, 6),
        ("WAIT UNTIL E1 = 1 MAXTMIE = 5 ERROR JUMP L\nL:", "syntax", 0, 19),
        ("MOVE ROB UNTIL E1 = 1 EROR HALT TO P1", "syntax", 0, 23),
        ("MOVE TOO P1", "syntax", 0, 6),
        ("MOVE \u00dcBER P1 TO P1", "syntax", 0, 6),
        ("MOVE BOR TO (1)", "kinematic-unknown", 0, 6),
        ("GOTO L\nL:", "name-unknown", 0, 1),
        ("READ PHG I", "syntax", 0, 10),
        ("X = 3\nI = X\nF[1] = X", "name-unknown", 0, 1),
        ("F[6] = I", "index-range", 0, 2),
        ("E1 = 1", "not-assignable", 0, 1),
        ("I = I -\nP1.X = 2", "syntax", 0, 8),
        ("I = I +\nF[F[I] + 1] = 2", "syntax", 0, 8),  # what is missing at the end of a line is reported there
        ("I = F[1] + F[2] -\nL:", "syntax", 0, 18),
        ("I = I *\nWAIT 1", "syntax", 0, 8),
        ("IF I =\nTHEN I = 2", "syntax", 0, 7),
        ("IF E1 = 1\nI = 2", "syntax", 0, 10),
        ("WAIT UNTIL E1 =\nI = 3", "syntax", 0, 16),
        ("WAIT\nI = 3", "syntax", 0, 5),
        ("MOVE TO P1,\nI = 3", "syntax", 0, 12),
        ("WRITE PHG,\nI = 3", "syntax", 0, 11),
        ("READ PHG, I,\nT = 'A'", "syntax", 0, 13),
        ("REPEAT\nI = 3\nREPEAT_END", "syntax", 0, 7),
        ("I = 3\n= 4", "syntax", 1, 1),
        ("I =\nINT_ASC(I, T, 1, 3, I)", "syntax", 0, 4),
        ("MOVE WITH V 100, A = 5 VIA P1 TO P1", "syntax", 0, 13),
        ("IF = 1 THEN I = 2\nELSE I = 3", "syntax", 0, 4),
        ("I = I 0 + (I * (I = 1))", "syntax", 0, 7),
        ("WRITE P1., I\nI = 2", "syntax", 0, 9),
        ("WRITE P1.\nREPEAT 2 TIMES\nREPEAT_END", "syntax", 0, 9),
        ("T = HALLO'", "text-without-end", 0, 10),
        ("MOVE ROB ROB LINEAR TO P1", "syntax", 0, 10),
        ("IF I = 1 THEN THEN I = 2 ELSE I = 3", "syntax", 0, 15),
        ("REPEAT 2 2 TIMES\nI = 2\nREPEAT_END", "syntax", 0, 10),
        ("WAIT UNTIL E1 = 1 MAX_TIME 5 ERROR HALT\nREPEAT 2 TIMES\nREPEAT_END", "syntax", 0, 28),
        ("P1 X = 3", "syntax", 0, 3),
        ("P1.X = P1 Y + 1", "syntax", 0, 10),
        ("P1.X = P1. + 1", "syntax", 0, 10),
        (": I = 1\nJUMP GO", "syntax", 0, 1),
        ("ENDE I = 1\nJUMP ENDE", "syntax", 0, 5),
        ("IF I = 1 THEN BEGIN\n JMUP ENDE\nEND\nENDE: HALT", "name-unknown", 1, 2),
        ("IF I = 1 THEN JMUP FEHLER\nHALT\nFEHLER: I = 2", "name-unknown", 0, 15),
        ("IF I = 1 THEN BEGIN\n JUMP ENDE\nEND\nENED: HALT", "label-missing", 1, 2),
        ("FEHLER = 0\nI = FEHLER\nINT_ASC(I, T, 1, 3, FEHLER)", "name-unknown", 0, 1),
        ("IF FEHLER = 0 THEN I = 2\nREPEAT FEHLER TIMES\nREPEAT_END", "name-unknown", 0, 4),
        ("I, T", "syntax", 0, 1),
        ("I CONDITION(PHG)", "syntax", 0, 2),
        ("I = CONDITION PHG", "syntax", 0, 15),
        ("WAIT UNTIL I 3", "syntax", 0, 13),
        ("WAIT UNTIL\nV = 0", "syntax", 0, 11),
        ("WAIT UNTIL\nI = 0\nI = 3", "syntax", 0, 11),
        ("WAIT UNTIL\nL: I = 3\nJUMP L", "syntax", 0, 11),
        ("IF I = 3 THEN\nELSE I = 2", "syntax", 0, 14),
        ("WRITE Guten Tag', I", "text-without-end", 0, 16),
        ("IF CONDITION;PHG) = 0 THEN I = 2", "syntax", 0, 13),
        ("P1 = WC_FRAME(P1, P1, P1)", "argument-count", 0, 6),
    ],
)
def test_one_mistake_is_one_fault_at_its_place(statements: str, id: str, line: int, column: int) -> None:
    found = check(f"{HEAD}PROGRAM P\n{DECLARED}\nBEGIN\n{statements}\nHALT\nPROGRAM_END\n")
    assert [(each.id, each.position.line, each.position.column) for each in found] == [(id, FIRST + line, column)]


@pytest.mark.parametrize(
    "statements",
    [
        "MOVE ROB LINIE, UNTIEF",  # teach points with names of their own
        "MOVE ROB VIA LINAER, WIHT TO P1",
        "CSAE: I = 1\nJUMP CSAE",
        "ALSSO = 1\nI = ALSSO",
        "RPTT",
        "IF E1 = 1 AND\nI = 2 THEN I = 3",  # conditions in two lines
        "WAIT UNTIL E1 = 1 OR\nI = 2",
        "IF I +\nI = 2 THEN I = 3",
        "I = I +\nF[1]",
        "WAIT UNTIL\n  I = 2",
        "WAIT UNTIL\nE1 = 1",
        "WAIT UNTIL\nI = 2 MAX_TIME = 1",
        "I = 3 ; T, I",
    ],
)
def test_names_of_the_user_stay_names(statements: str) -> None:
    found = check(f"{HEAD}PROGRAM P\n{DECLARED} INTEGER : ALSSO\nBEGIN\n{statements}\nPROGRAM_END\nSR RPTT\nBEGIN\nSR_END\n")
    assert found.rows() == []


@pytest.mark.parametrize(
    "declared, statements, id, column",
    [
        ("CONST : A = 3, B 2, C = 4", "I = A + B + C", "syntax", 18),
        ("INTEGER : A; B, C", "I = A + B + C", "syntax", 12),
        ("OUTPUT : 7 ; LAMP, 8 = HORN", "LAMP = HORN", "syntax", 12),
        ("OUTPUT : 7 =", "LAMP = 1", "syntax", 13),
        ("INTEGER : A,", "B = A", "syntax", 13),
        ("INTEGER : FEHLER A", "I = FEHLER + A", "syntax", 18),
        ("INTEGER : FEHLER, , A", "I = FEHLER + A", "syntax", 19),
        ("INTEGER E", "E = 1", "syntax", 9),
        ("INTEGER F", "F[1] = 1", "syntax", 9),  # declared twice, too
        ("INTEGER : I, T", "I = 1", "declared-twice", 11),
        ("INETGER : A, FEHLER, C", "I = A + FEHLER + C", "syntax", 1),
        ("INUT : 2 = E2", "WAIT UNTIL E2 = 1", "syntax", 1),
        ("INPUT RAEL : 201 = E2", "WAIT UNTIL E2 > 1", "syntax", 7),
        ("FILE RAEL : Q", "READ_BEGIN Q", "syntax", 6),
        ("FLIE REAL : Q", "READ_BEGIN Q", "syntax", 1),
        ("ARAY[1..3] ROB.POINT : Q", "MOVE ROB TO Q[1]", "syntax", 1),
        ("ARRAY[1..3] CAHR : FELD", "FELD[1] = 'A'", "syntax", 13),
        ("ARRAY[1..3] : FELD", "FELD[1] = 'A'", "syntax", 13),
        ("FILE : LSITE", "ASSIGN LISTE, T\nI = CONDITION(LISTE)\nREAD_BEGIN LISTE", "file-unknown", 1),
    ],
)
def test_one_mistake_in_a_declaration_is_one_fault(declared: str, statements: str, id: str, column: int) -> None:
    found = check(f"{HEAD}PROGRAM P\n{DECLARED}\n{declared}\nBEGIN\n{statements}\nHALT\nPROGRAM_END\n")
    line = FIRST + 1 if id == "file-unknown" else FIRST - 1  # a misspelt name is found where it is used
    assert [(each.id, each.position.line, each.position.column) for each in found] == [(id, line, column)]


@pytest.mark.parametrize(
    "parameters, column",
    [
        ("(VALUE : A VALUE INTEGER : NACH)", 8),
        ("(VLAUE ROB.POINT : A VALUE INTEGER : NACH)", 2),
        ("(VALUE ROB.POINT : A VLAUE INTEGER : NACH)", 22),
        ("(VALUE ROB.PIONT : A VALUE INTEGER : NACH)", 12),
        ("(VALUE ROB POINT : A VALUE INTEGER : NACH)", 8),
        ("(VALUE .POINT : A VALUE INTEGER : NACH)", 8),
    ],
)
def test_one_mistake_in_parameters_is_one_fault(parameters: str, column: int) -> None:
    found = check(
        f"{HEAD}PROGRAM P\n{DECLARED}\nBEGIN\nGO(P1, I)\nPROGRAM_END\nSR GO\n{parameters}\nBEGIN\nIF NACH = 1 THEN HALT\nSR_END\n"
    )
    assert [(each.id, each.position.line, each.position.column) for each in found] == [("syntax", FIRST + 3, column)]


def test_a_misspelt_import_is_one_fault() -> None:
    other = "PROGRAM OTHER\nPUBLIC INTEGER : COUNTER\nBEGIN\nHALT\nPROGRAM_END\n"
    text = "PROGRAM P\nEXTERNAL OTHER : COUTNER\nBEGIN\nCOUNTER = COUNTER + 1\nPROGRAM_END\n"
    found = Library(WORDS, MemoryStore({"P.QLL": text, "OTHER.QLL": other})).check("P.QLL", text)[1]
    assert [(each.id, each.position.line, each.hint) for each in found] == [("import-unknown", 2, "did you mean COUNTER?")]


def test_a_misspelt_program_of_two_imports_is_one_fault() -> None:
    other = "PROGRAM OTHER\nPUBLIC INTEGER : A\nPUBLIC REAL : B\nBEGIN\nHALT\nPROGRAM_END\n"
    for first, second, line in (("OTEHR", "OTHER", 2), ("OTHER", "OTEHR", 3)):
        text = f"PROGRAM P\nEXTERNAL {first} : A\nEXTERNAL {second} : B\nBEGIN\nB = A + 1\nPROGRAM_END\n"
        found = Library(WORDS, MemoryStore({"P.QLL": text, "OTHER.QLL": other})).check("P.QLL", text)[1]
        assert [(each.id, each.position.line) for each in found] == [("import-missing", line)]


def test_a_misspelt_subroutine_is_one_fault() -> None:
    found = check("PROGRAM P\nBEGIN\nGO(1)\nPROGRAM_END\nSUBRUOTINE GO (VALUE INTEGER : N)\nBEGIN\nWRITE N\nSUB_END\n")
    assert [(each.id, each.position.line) for each in found] == [("behind-the-end", 5)]


def test_the_fault_names_the_word_that_is_like_it() -> None:
    found = check("PROGRAMM P\nANFANG\nWDHH 3 MAL\nWARTE 1\nWDH_ENDE\nPROGRAMM_ENDE\n")
    assert [fault.hint for fault in found] == ["did you mean WDH?"]
