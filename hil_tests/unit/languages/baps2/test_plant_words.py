"""What programmers of a plant write: one kinematic under two names, several values behind WITH, another point file for another product, one
WRITE of much (rho 3 releases L1858-1880, 1938, 5795-5912, 8884)."""

import pytest

from hil_tests.lab.virtual.baps2_bench import HEAD, ProgramCell, one
from hil_tests.unit.languages.baps2.running import body, faults_of, run, short, written

SET = """;;KINEMATICS : (1=ROB)
;;ROB.WC_NAMES = X,Y,Z,A,B,C
PROGRAM P
EXTERNAL : Q
ROB.WC_FRAME : F
BEGIN
F = WC_FRAME(100,0,0,0,0,0)
ROB.WC_SYSTEM = F
START Q
MOVE TO (20,0,0,0,0,0)
PROGRAM_END
"""
OTHER = ";;KINEMATICS : (1=ARM)\n;;ARM.WC_NAMES = X,Y,Z,A,B,C\nPROGRAM Q\nBEGIN\nMOVE TO (10,0,0,0,0,0)\nPROGRAM_END\n"


def test_a_kinematic_that_another_program_names_otherwise_is_the_same_one() -> None:
    events = run(SET, Q=OTHER)
    moves = [(each["t"], each["target"]) for each in events if each["event"] == "move"]
    assert moves == [(0.0, [120.0, 0.0, 0.0, 0.0, 0.0, 0.0]), (0.0, [110.0, 0.0, 0.0, 0.0, 0.0, 0.0])], "in the system that P has set"
    assert short(events, "moving", "moved") == [(0.0, "moving", 1), (1.0, "moved", 1), (1.0, "moving", 2), (2.0, "moved", 2)]
    plain = "PROGRAM Q\nBEGIN\nMOVE TO (10,0,0,0,0,0)\nPROGRAM_END\n"
    moved = [each["target"] for each in run(SET, Q=plain) if each["event"] == "move"]
    assert [110.0, 0.0, 0.0, 0.0, 0.0, 0.0] in moved, "a program that names none moves kinematic 1"


def test_in_a_cell_too() -> None:
    frame = "PORTAL.WC_FRAME : F"
    body = "F = WC_FRAME(100, 0, 0, 0, 0, 0)\nPORTAL.WC_SYSTEM = F\n"
    other = HEAD.replace("PORTAL", "LADER") + "PROGRAM Q\nBEGIN\nMOVE PTP TO (20, 60, 40, 12)\nPROGRAM_END\n"
    cell = ProgramCell(one(body, frame) | {"Q.QLL": other})
    assert cell.run("P")[:2] == ("ended", 0)
    assert cell.run("Q")[:2] == ("ended", 0)
    assert cell.at() == (120, 60, 40, 12)


def test_values_behind_with_need_no_comma_and_may_have_one_more() -> None:
    head = ";;KINEMATICS : (1=ROB)\n;;ROB.WC_NAMES = X\nPROGRAM P\nBEGIN\n"
    for way in ("WITH R = 0 V = 50 TO (1)", "WITH V = 50, A = 100, TO (1)", "WITH V_PTP = 0.5 R_PTP = 1 PTP VIA (1)", "WITH V = 50 (1)"):
        events = run(f"{head}MOVE ROB {way}\nPROGRAM_END\n")
        assert [each["target"] for each in events if each["event"] == "move"] == [[1.0]]


COPYING = """PROGRAM P
EXTERNAL : Q
SPC_FCT : 4 = COMMAND (VALUE INTEGER : C TEXT : S, T INTEGER : R)
INTEGER : R
TEXT : A, B
BEGIN
START Q
WAIT 2
A = 'BIG.PKT' B = 'Q.PKT'
COMMAND(2, A, B, R)
START Q
WAIT 2
COMMAND(3, B, B, R)
START Q
WAIT 2
PROGRAM_END
"""


def test_a_point_file_that_a_program_copies_or_deletes_counts_at_the_next_start() -> None:
    other = ";;KINEMATICS : (1=ROB)\n;;ROB.WC_NAMES = X\nPROGRAM Q\nDEF POINT : SPOT\nBEGIN\nMOVE TO SPOT\nPROGRAM_END\n"
    events = run(COPYING, **{"Q": other, "Q.PKT": "SPOT = (5)\n", "BIG.PKT": "SPOT = (9)\n"})
    assert [each["target"] for each in events if each["event"] == "move"] == [[5.0], [9.0]]
    assert short(events, "error") == [(4.0, "error", 200)]


def test_a_write_by_3964r_of_more_than_a_block_is_condition_8() -> None:
    text = ";;SER_IO_STOP {0}\nPROGRAM P\nBEGIN\nWRITE V24_1, 'AB', 'CD'\nWRITE PHG, CONDITION(V24_1)\nPROGRAM_END\n"
    feed = "[devices.V24_1]\nprotocol = 8\n"
    assert written(run(text.format("-"), feed)) == ["-8"], "two TEXTs of 80 characters"
    assert short(run(text.format("+"), feed), "error") == [(0.0, "error", 212)]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("V = 0\nMOVE LINEAR TO @(1)", "V = 0"),
        ("WAIT 0\nMOVE WITH V_PTP = 0 TO @(1)", "V_PTP = 0"),
        ("AFACTOR = 0\nMOVE LINEAR TO @(1)", "AFACTOR = 0"),
        ("K.AFACTOR = 0\nMOVE TO @(1)", "AFACTOR = 0"),
        ("R_PTP = 101\nMOVE VIA @(1) TO @(2)", "R_PTP 101 is outside 0.01 .. 100 (0: off)"),
    ],
)
def test_a_dry_run_refuses_speeds_that_a_cell_refuses(text: str, words: str) -> None:
    events = run(";;KINEMATICS : (1 = K)\n;;K.JC_NAMES = X\n" + body(text))
    assert [(e["line"], e["code"], e["text"]) for e in events if e["event"] == "error"] == [(7, 218, f"value out of range: {words}")]


@pytest.mark.parametrize(
    "text",
    [
        "PROGRAM P\nOUTPUT : 1 = UP, 2 = DOWN\nBEGIN\nUP = 1\nDOWN = NOT UP\nIF DOWN = 1 THEN UP = 0\nPROGRAM_END\n",
        "PROGRAM P\nBEGIN\nUP\nWAIT 1\nIF VERSION > 2 THEN BEGIN\nWAIT 1\nEND\nUP\nPROGRAM_END\nSR UP\nBEGIN\nWAIT 1\nSR_END\n",
        "PROGRAM P\nINTEGER : I\nBEGIN\nUP (1, I)\nPROGRAM_END\nSR UP (VALUE INTEGER : N INTEGER : M)\nBEGIN\nM = N\nSR_END\n",
        "PROGRAM P\nDEF POINT : UP\nBEGIN\nL: MOVE VIA UP TO UP\nUP.X = 3\nJUMP L\nPROGRAM_END\nUP NEXT\nBEGIN\nWAIT 1\nUP_ENDE\n",
    ],
)
def test_up_is_a_name_in_an_english_program(text: str) -> None:
    """AX-1747."""
    assert faults_of(f";;KINEMATICS : (1 = ROB)\n;;ROB.WC_NAMES = X, Y\n{text}") == []


def test_wert_is_the_name_of_a_parameter() -> None:
    text = (
        "PROGRAM P\nSPC_FCT : 1 = IOL (VALUE INTEGER : NO, KIN, CO VALUE REAL : AT, WERT VALUE INTEGER : T)\n"
        "BEGIN\nGO(3, 4)\nPROGRAM_END\nSR GO (VALUE INTEGER : FEHLER, WERT)\nBEGIN\nWRITE FEHLER, WERT\nSR_END\n"
    )
    assert written(run(text)) == ["34"]
