"""A Reis program with one mistake of a kind users make has one fault, at its step, with a remedy (AX-1738)."""

import pytest

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.memory import Memory, Source
from hil_tests.unit.languages.robotstar.memory import WORDS, checked, run

POSITION = "POSITION #N, X:1, Y:0, Z:0, A:0, B:0, C:0"


@pytest.mark.parametrize(
    ("body", "step", "text", "hint"),
    [
        ("WARTE_BITT #EINGANG, 1, 0, 5", 2, "WARTE_BITT is neither a command nor a macro of this memory", "did you mean WARTE_BIT?"),
        ("GREIFERZU", 2, "GREIFERZU is neither a command nor a macro of this memory", "did you mean GREIFER_ZU?"),
        ("PTP_BESCHW 50", 2, "PTP_BESCHW is neither a command nor a macro of this memory", "did you mean PTP_BESCHL or PTP_GESCHW?"),
        ("XYZZY", 2, "XYZZY is neither a command nor a macro of this memory", "a macro is a file XYZZY.MAC"),
        ("LOK_VARR IX\nCOPY 1, IX\nADD IX, _SPS[IX]", 2, "LOK_VARR is neither a command nor a macro of this memory", "LOK_VAR?"),
        ("COPY 1, INICHT\nADD 1, INICHT\nWAIT 1\nADD 1, INICHT", 2, "INICHT: Definition not found!", "LOC_VAR; also at steps 3, 5"),
        ("VAR INUMMER\nCOPY 1, INUMER", 3, "INUMER: Definition not found!", "did you mean INUMMER?"),
        ("COPY 1, _SPSS[1]", 2, "_SPSS: Definition not found!", "did you mean _SPS?"),
        ("COPY 1, _SPS[513]", 2, "_SPS: Index too big or too small!", "_SPS[1] .. _SPS[512]"),
        ("BRANCH FERTIK\nBRANCH FERTIK\nLABEL FERTIG", 2, "label FERTIK is not in this program", "did you mean FERTIG?; also at step 3"),
        ("BRANCH M1\nLABEL ML", 2, "label M1 is not in this program", "did you mean ML?"),
        ('CALL "HOLNE"\nCALL HOLNE', 2, "program HOLNE not found", "did you mean HOLEN?; also at step 3"),
        (f"{POSITION}\n{POSITION}\n{POSITION}", 2, "POSITION: TOOL is needed in front of the first position", ""),
        ("WAIT 1\nVAR I1\nVAR I2\nVAR I3", 3, "definitions belong at the beginning, before step 2", "also at steps 4, 5"),
        ("BEWEG_ART #LINAER", 2, "#LINAER: no such system equate", "did you mean #LINEAR?"),
        ("BEWEG_ART LINEAR", 2, "BEWEG_ART: mode must be one of #PTP, #LINEAR, #SPLINE, #ZIRK_MIN_ORI, #ZIRK_BAHN_ORI", "#LINEAR?"),
        ("WARTE_BIT EINGANG, 1, 0, 5", 2, "WARTE_BIT: EINGANG is of type E; I or R is needed", "did you mean #EINGANG?"),
        ("WARTE_BIT #EINGANG, 1, 0, 5, 2.0", 2, "WARTE_BIT: label missing", ""),
        ('PALLET "HOLEN", #ON', 2, "program HOLEN is not a pallet program", ""),
        ("LOC_VAR V1\nTEST #VARIABLE, V1, #=, 1, A\nLABEL A", 3, "Wrong operand types!", ""),
        ('LOC_VAR I1\nTEST #VARIABLE, I1, #=, "A", A\nLABEL A', 3, "Wrong operand types!", ""),
        ("LOC_VAR R1\nTEST_BIT #VARIABLE, #=1, R1, 3, A\nLABEL A", 3, "Wrong operand types!", ""),
        ("WAIT 0.5s", 2, "WAIT: 0.5S is neither a number nor the name of a variable", ""),
        ("WARTE_BIT #EINGANG, Pege1: 1, Byte: 0, Bit_Nr: 5", 2, "Pege1: no such descriptor", "did you mean Pegel?"),
        ("SCHR_BIT 1, 4, 7", 2, "SCHR_BIT: area missing", ""),
        ("UEBERSCHL EIN", 2, "UEBERSCHL: value must be one of #EIN, #AUS", ""),
        ('PALLET "P", 1', 2, "PALLET: order must be one of #INIT, #ON, #OFF", ""),
        ("OSCILLATION 1", 2, "OSCILLATION is named by the manual only; its parameters are not known", "with a backslash"),
        ("WAIT 1O", 2, "WAIT: 1O is neither a number nor the name of a variable", ""),
        ("COPY 1O, _SPS[1]", 2, "COPY: 1O is neither a number nor the name of a variable", ""),
        (f"TOOL T\n{POSITION}, Frame:-1", 3, "POSITION: Frame -1 is not the number of a station: a whole number from 0 on", ""),
        (f"TOOL T\n{POSITION}, Frame:1.5", 3, "POSITION: Frame 1.5 is not the number of a station: a whole number from 0 on", ""),
        (f"TOOL T\n{POSITION}, X:2", 3, "POSITION: X is given twice", ""),
        (f"TOOL T\n{POSITION}, A7:IQ", 3, "POSITION: A7 must be a number, not IQ", ""),
        ("CALC_REL _VNULL", 2, "_VNULL: Writing not allowed!", ""),
        ("COPY 2.5, _VNULL", 2, "_VNULL: Writing not allowed!", ""),
        ("SCHR_BIT #EIN, 1, 4, 7", 2, "SCHR_BIT: area must be one of #AUSGANG, #MERKER", ""),
        ("SCHR_BIT #AUSGANG, 1, 40, 7", 2, "SCHR_BIT: byte 40 is outside 0 .. 39", ""),
        ("WAIT 0,5", 2, "WAIT: there are too many parameters", "numbers have a decimal point"),
        ("KOPIERE Quele: 1, Ziel_Var: _SPS[1]", 2, "Quele: no such descriptor", "did you mean Quelle?"),
        ("TEST #VARIABLE, 1, =, 2, A\nLABEL A", 2, "=: neither a number, a name nor a text in quotation marks", "did you mean #=?"),
        ("LOC_VAR I1\nTEST #VARIABLE, I1, #=>, 2, A\nLABEL A", 3, "#=>: no such system equate", "did you mean #>=?"),
        ('LOC_VAR S1\nCOPY "A", S1', 2, "S1: write the length of a string in round brackets", ""),
        ("LOC_VAR I1\nCOPY 3000000000, I1", 3, "COPY: 3000000000 is outside the range of an integer, -2147483648 .. 2147483647", ""),
        ("WARTE_BIT #EINGANG, 1, 0, 5, Max_Zeit: 3,5, Marke: A\nLABEL A", 2, "WARTE_BIT: there are too many parameters", "a decimal point"),
        ("TEST_BIT #EINGANG, #1, 0, 1, A\nLABEL A", 2, "#1: no such system equate", "did you mean #=1?"),
        (f"LOC_VAR V1\nTOOL V1\n{POSITION}", 3, "TOOL: V1 is of type V; T is needed", ""),
        ("LOC_VAR V1\nCOPY 5, V1.Q", 3, "V1: Wrong operand types!", "elements: Frame X Y Z A B C A1..A24"),
        ("MPR P\nSTOP\nEND\nWAIT 2", 3, "END is allowed only at the end", ""),
        ("MPR P\nSTOP\nENDDE", 3, "the last step is END", ""),
    ],
)
def test_one_mistake_is_one_fault(body: str, step: int, text: str, hint: str) -> None:
    _, faults = checked({"P.MPR": body, "GREIFER_ZU.MAC": "WAIT 1", "HOLEN.SPR": "WAIT 1"})
    (fault,) = faults
    assert (fault.text, fault.position.line) == (f"step {step}: {text}", step)
    assert fault.hint.endswith(hint)


def test_a_misspelt_head_is_one_fault() -> None:
    faults = Faults()
    check(Memory.read([Source("P.MPR", "MRP P\nSTOP\nEND")], WORDS, faults), faults, {})
    assert [fault.text for fault in faults] == ["step 1: the first step is the head of the program: MPR and the name"]


def test_a_copied_program_is_one_fault() -> None:
    """Its global variables are there already (L813)."""
    text = "VAR I1\nVAR I2\nVAR I3\nCOPY 1, I1"
    _, faults = checked({"A.MPR": text, "B.MPR": text, "C.MPR": "VAR I4\nVAR I4\nLOC_VAR I5\nLOC_VAR I5"})
    assert [(fault.position.file, fault.text, fault.hint) for fault in faults] == [
        ("B.MPR", "step 2: I1 is defined twice in the memory (in A)", "also at steps 3, 4"),
        ("C.MPR", "step 3: I4 is defined twice in the memory (in C)", ""),
        ("C.MPR", "step 5: I5 is defined twice in this program", ""),
    ]


@pytest.mark.parametrize(
    ("last", "place", "hint"),
    [("CALL U", ("U.SPR", 3), "U calls itself"), ("TEST #VARIABLE, IX, #>, 3, A\nCALL U\nLABEL A", None, ""), ("WAIT 1", None, "")],
)
def test_a_call_that_certainly_nests_too_deep(last: str, place: tuple[str, int] | None, hint: str) -> None:
    files = {"P.MPR": "VAR IX\nCALL U", "U.SPR": f"WARTE_BIT #EINGANG, 1, 0, 5\n{last}"}
    faults = checked(files)[1]
    assert [((fault.position.file, fault.position.line), fault.hint) for fault in faults] == ([(place, hint)] if place else [])


def test_the_thirteenth_level_of_calls_is_one_fault() -> None:
    calls = {f"U{level}.SPR": f"CALL U{level + 1}" for level in range(1, 13)}
    (fault,) = checked({"P.MPR": "CALL U1", **calls, "U13.SPR": "WAIT 1"})[1]
    assert (fault.position.file, fault.text) == ("U12.SPR", "step 2: nesting depth too big: more than 12 calls")
    assert not checked({"P.MPR": "CALL U2", **calls, "U1.SPR": "WAIT 1", "U13.SPR": "WAIT 1"})[1]


def test_names_of_labels_and_programs_may_look_like_numbers() -> None:
    """Names are freely selectable (L666): FACH and DACH are no hexadecimal numbers, 01 is not 1."""
    text = "BRANCH FACH\nSTOP\nLABEL FACH\nBRANCH 01\nSTOP\nMARKE 01\nTEST_BIT #EINGANG, #=0, 0, 0, EBH\nSTOP\nLABEL EBH"
    bit = "WRITE_BIT #AUSGANG, 1, 0, "
    ran = run({"P.MPR": f"{text}\nCALL 0815\nCALL DACH\n{bit}0", "0815.SPR": f"{bit}1", "DACH.SPR": f"{bit}2"})
    assert not ran.faults and ran.when("A0")[-1][1] == 7


def test_a_foreign_file_is_not_searched_for_like_words_without_end() -> None:
    """Each label would be compared with each: 3,000 of each took 12 s."""
    names = [f"{a}{b}{c}XYZ" for a in "ABCDEF" for b in "ABCDEF" for c in "ABCDEF"]
    _, faults = checked({"P.MPR": "\n".join(f"BRANCH {name}\nLABEL {name}W" for name in names)})
    assert [bool(fault.hint) for fault in faults] == [True] * 100 + [False] * (len(names) - 100)
