"""What a faulty step was meant to be, in the hint of its fault and in a listing read from a print (AX-1831)."""

import pytest

from gateway.files.robotstar import words
from gateway.pure.languages.plc.check import check_programs
from gateway.pure.languages.robotstar.listing import import_listing

OPEN = "DB10.DW17 has no marker; give it one with --words: DB10.DW17 = M200"
LISTED = """S1   PLC      'MAIN'
S2   U        EO.0
S3   ST       E,TI
S4   SP       ENDE,0
S5   ZV       ZO,1   ; 1OO
S6   L        OFFH
S7   M        ENDE
S8   SU       UP1,1
S9   5        A1.O
S1O  LD       M2O
S11  END
"""


@pytest.mark.parametrize(
    ("step", "hint"),
    [
        ("U EO.0", "did you mean U E0.0?"),
        ("U E0,0", "did you mean U E0.0?"),
        ("UE0.0", "did you mean U E0.0?"),
        ("XON MlO.7 ; lamp", "did you mean XON M10.7?"),
        ("SE T 7", "a statement of STEP 5; here it is ST E,T7"),
        ("SPB =M001\nM M001", "a statement of STEP 5; here it is SP M001,1"),
        ("SPA PB 5", "a statement of STEP 5; here it is SU PB5"),
        ("L KT 100.1", "a statement of STEP 5; here it is L 1000"),
        ("L MB 20", "a statement of STEP 5; here it is L M20"),
        ("A I0.0", "a statement of STEP 5; here it is U I0.0"),
        ("= Q1.0", "did you mean = A1.0?"),
        ("L IB3", "a statement of STEP 5; here it is L E3"),
        (":U E 0.0", "did you mean U E 0.0?"),
        (f"NOT_TRANSLATED L DW 17 ; line 12: {OPEN}", f"the import did not translate L DW 17; line 12: {OPEN}"),
        ("U E40.0", "E 0 to E 39"),
        ("ZV ACCU,256", "a number from 0 to 255 after the comma"),
    ],
)
def test_the_hint_of_a_faulty_step_is_the_step_that_was_meant(step: str, hint: str) -> None:
    (fault,) = check_programs({"MAIN": f"PLC MAIN\n{step}\nEND\n"})
    assert (fault.position.line, fault.hint) == (2, hint)


def test_be_at_the_end_is_no_missing_end_as_well() -> None:
    faults = check_programs({"MAIN": "PLC MAIN\nU E0.0\n= A0.0\nBE\n"})
    assert [fault.hint for fault in faults] == ["END is the last step of a program"]


def test_misread_steps_of_a_printed_plc_program_are_put_right_and_named() -> None:
    found = import_listing(LISTED, words())
    steps = [" ".join(line.split()[1:]) for line in found.files["MAIN.PLC"].splitlines()[1:]]
    assert steps == ["U E0.0", "ST E,T1", "SP ENDE,0", "ZV Z0,1 ; 1OO", "L 0FFH", "M ENDE", "SU UP1,1", "S A1.0", "LD M20", "END"]
    assert [note.line for note in found.notes] == [2, 3, 5, 6, 9, 10, 10]
