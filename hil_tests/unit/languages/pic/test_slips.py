"""One slip of a typist in a PIC program is one error, however many it causes (AX-1854)."""

import pytest

from gateway.files.texts import spoken
from gateway.pure.languages.base.faults import Faults, SourceFault
from gateway.pure.languages.pic.cell_pic import read_pic
from hil_tests.unit.languages.pic.pics import SIGNALS, Files

SYMBOLS = "LAMP = I88.0\nPRESS = I88.1\nGATE = I88.2\nFREE = O3.0\nHORN = O3.1\nRUNS = M10.0\nWAITS = M10.1\n"
BAPS = """IF PRESS AND NOT GATE THEN
  FREE = 1
IF NOT PRESS THEN JUMP OFF
RUNS = GATE AND LAMP
JUMP DONE
OFF:
FREE = 0 HORN = 0
DONE:
"""
LIST = """A -PRESS
AN -GATE
= -FREE
JC -OFF
O -RUNS
S -HORN
-OFF
EP
"""


def faults_of(text: str) -> list[SourceFault]:
    faults = Faults()
    read_pic(Files({"P.QLS": text, "P.SYM": SYMBOLS}), "P", SIGNALS, faults)
    return list(faults)


def test_the_programs_are_sound() -> None:
    assert faults_of(BAPS) == faults_of(LIST) == []


@pytest.mark.parametrize(
    "program, right, wrong, line, text",
    [
        (BAPS, "NOT GATE THEN", "NOT THEN GATE", 1, "THEN and GATE are exchanged"),
        (BAPS, "NOT GATE THEN", "NXT GATE THEN", 1, "NXT is neither a signal nor a symbol"),
        (BAPS, "THEN JUMP OFF", "THEN OFF JUMP", 3, "OFF and JUMP are exchanged"),
        (BAPS, "JUMP DONE\n", "JUMP\n", 5, "the name of a label is expected"),
        (BAPS, "\nOFF:", "\nOFF", 6, "':' is missing after OFF"),
        (BAPS, "\nOFF:", "\n: OFF", 6, ": and OFF are exchanged"),
        (BAPS, "\nOFF:", "\nOFF OFF:", 6, "OFF is written twice"),
        (BAPS, "\nOFF:", "\n:", 6, "the name of a label is expected"),
        (BAPS, "FREE = 0 HORN", "= 0 HORN", 7, "a signal or an address is expected here"),
        (BAPS, "\nDONE:", "\nDONE", 8, "':' is missing after DONE"),
        (LIST, "A -PRESS", "A A -PRESS", 1, "A is written twice"),
        (LIST, "A -PRESS", "A -", 1, "a signal or an address is expected here"),
        (LIST, "JC -OFF", "JC JC -OFF", 4, "JC is written twice"),
        (LIST, "O -RUNS", "O -", 5, "a signal or an address is expected here"),
        (LIST, "\n-OFF", "\n- -OFF", 7, "- is written twice"),
        (LIST, "\n-OFF", "\nOFF -", 7, "OFF and - are exchanged"),
    ],
)
def test_one_slip_is_one_error(program: str, right: str, wrong: str, line: int, text: str) -> None:
    assert right in program
    found = faults_of(program.replace(right, wrong, 1))
    assert [(fault.position.line, fault.text) for fault in found] == [(line, text)]


def test_other_errors_stay_beside_the_slip() -> None:
    found = faults_of(BAPS.replace("\nOFF:", "\nOFF").replace("GATE AND LAMP", "GATE AND LAMPE"))
    assert [(fault.position.line, fault.text) for fault in found] == [
        (4, "LAMPE is neither a signal nor a symbol"),
        (6, "':' is missing after OFF"),
    ]


def test_two_errors_that_one_slip_does_not_explain_stay_as_they_are() -> None:
    found = faults_of("FREE = NOWHERE\nHORN = NOWAY\n")
    assert [fault.position.line for fault in found] == [1, 2]


def test_slips_have_german_words() -> None:
    german = spoken("pic-check").german
    assert german("GATE and THEN are exchanged") == "GATE und THEN sind vertauscht"
    assert german("write THEN GATE") == "THEN GATE schreiben"
    assert german("':' is missing after OFF") == "hinter OFF fehlt ':'"
    assert german("a signal or an address is expected here") == "hier wird ein Signal oder eine Adresse erwartet"
