"""MSD.DAT, TEXT.DAT, EXPROG.DAT and PHGCODE.DAT: the manuals' examples, and what each line may not be."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.controllers.rho3.functions.dat_lines import Table
from gateway.pure.controllers.rho3.functions.dat_parsers import parse_exprog, parse_msd, parse_phgcode, parse_texts
from gateway.pure.controllers.rho3.functions.messages import keys, say

MSD = "01  =  'first text'\r\n\r\n02='texttexttext' ; Comment\r\n20 = 'text';line for\r\n   ; information\r\n32='text'\r\n99='last'\x1a"
TEXT = "00 = PHG, 'first text'\n01=PHG,'text text'\n02 = 'texttexttext'\n3E =  PHG  ,  'text' ;comment\nFF='last; text'\n"
EXPROG = "; Example of an EXPROG.DAT\n00 = PROG1  ; Comment separated by semicolon\n02=PROGXY\n\n0b = prog_ab;x\nFF = PROGFF ;\n"
PHGCODE = "0 = 0 ;Code=0 with negative edge\n  ;return to basic level\n1=3.2.2.1\n2 = 2\nA = 7.3.2 ; Process conditions\nF=11.1\t\n"


def faults(table: Table[str]) -> list[tuple[int, str]]:
    assert isinstance(table, Table), "a parser gives a table"
    return [(fault.line, fault.why.key) for fault in table.faults]


def entries(table: Table[str]) -> dict[int, str]:
    assert isinstance(table, Table), "a parser gives a table"
    return dict(table.entries)


@pytest.mark.requirement(
    "RHO-PLC-04",
    by=("gateway.pure.controllers.rho3.functions.dat_parsers:parse_msd", "gateway.pure.controllers.rho3.functions.dat_parsers:_msd_line"),
)
def test_msd_example_of_the_manual_with_comments_blank_lines_and_blanks() -> None:
    table = parse_msd(MSD)
    assert entries(table) == {1: "first text", 2: "texttexttext", 20: "text", 32: "text", 99: "last"}
    assert faults(table) == []


@pytest.mark.requirement(
    "RHO-PLC-04",
    by=("gateway.pure.controllers.rho3.functions.dat_lines:quoted", "gateway.pure.controllers.rho3.functions.dat_lines:head_of"),
)
@pytest.mark.parametrize(
    "line, why",
    [
        ("1 = 'one digit'", "two_decimal"),
        ("00 = 'no status'", "two_decimal"),
        ("0A = 'hex'", "two_decimal"),
        ("\u0661\u0662 = 'other digits'", "two_decimal"),
        ("100 = 'three'", "two_decimal"),
        ("03 = 'bell\x07'", "control"),
        ("03 = 'a\tb'", "control"),
        ("03 = 'del\x7f'", "control"),
        ("03 = open'", "quotes"),
        ("03 = 'open", "quotes"),
        ("03 'none'", "no_equals"),
        ("03 = 'a' b", "behind"),
        ("03 = '" + 81 * "x" + "'", "long"),
        ("08 = 'again'", "twice"),
    ],
)
def test_msd_bad_line_is_named_and_the_others_are_used(line: str, why: str) -> None:
    table = parse_msd(f"08 = 'this is a long text'\n{line}\n; end\n09 = 'x'\n")
    assert faults(table) == [(2, why)]
    assert entries(table) == {8: "this is a long text", 9: "x"}


@pytest.mark.requirement(
    "RHO-PLC-06",
    by=(
        "gateway.pure.controllers.rho3.functions.dat_parsers:parse_texts",
        "gateway.pure.controllers.rho3.functions.dat_parsers:_text_line",
    ),
)
def test_texts_with_and_without_channel_and_a_semicolon_inside_a_text() -> None:
    table = parse_texts(TEXT)
    assert entries(table) == {0: "first text", 1: "text text", 2: "texttexttext", 0x3E: "text", 255: "last; text"}
    assert faults(table) == []


@pytest.mark.requirement("RHO-PLC-06", by="gateway.pure.controllers.rho3.functions.dat_parsers:_text_line")
@pytest.mark.parametrize(
    "line, why",
    [
        ("3e = 'lower case'", "two_hex_upper"),
        ("E = 'one digit'", "two_hex_upper"),
        ("O1=PHG '...'", "two_hex_upper"),  # the manual's own example (D-33)
        ("03 = PHG '...'", "comma"),
        ("03 = SER_1,'...'", "channel"),
        ("03 = ,'...'", "channel"),
        ("03 = phg,'...'", "channel"),
        ("03 = PHG,", "quotes"),
        ("03 = 'a\x1b'", "control"),
        ("03 = '" + 81 * "x" + "'", "long"),
    ],
)
def test_texts_bad_line_is_named_and_the_others_are_used(line: str, why: str) -> None:
    table = parse_texts(f"3E = 'upper'\n\n{line}\n04 = '{80 * 'y'}'")
    assert faults(table) == [(3, why)]
    assert entries(table) == {0x3E: "upper", 4: 80 * "y"}


@pytest.mark.requirement(
    "RHO-PLC-18",
    by=(
        "gateway.pure.controllers.rho3.functions.dat_parsers:parse_exprog",
        "gateway.pure.controllers.rho3.functions.dat_parsers:_exprog_line",
    ),
)
def test_exprog_hex_code_name_and_comment() -> None:
    table = parse_exprog(EXPROG)
    assert entries(table) == {0: "PROG1", 2: "PROGXY", 0x0B: "PROG_AB", 255: "PROGFF"}
    assert faults(table) == []


@pytest.mark.requirement(
    "RHO-PLC-18",
    by=(
        "gateway.pure.controllers.rho3.functions.dat_parsers:_exprog_line",
        "gateway.pure.controllers.rho3.functions.dat_lines:only_comment",
    ),
)
@pytest.mark.parametrize(
    "line, why",
    [
        ("2 = PROG", "two_hex"),
        ("GG = PROG", "two_hex"),
        ("03 = ", "name"),
        ("03 = ;PROG", "name"),
        ("03 = PROG.IRD", "name"),
        ("03 = LONGERTHAN8", "name"),
        ("03 = PROG comment", "behind"),
        ("03 PROG", "no_equals"),
    ],
)
def test_exprog_bad_line_is_named_and_the_others_are_used(line: str, why: str) -> None:
    table = parse_exprog(f"{line}\r\n04 = PROGAB")
    assert faults(table) == [(1, why)]
    assert entries(table) == {4: "PROGAB"}


def test_phgcode_example_of_the_manual() -> None:
    table = parse_phgcode(PHGCODE)
    assert entries(table) == {0: "0", 1: "3.2.2.1", 2: "2", 10: "7.3.2", 15: "11.1"}
    assert faults(table) == []


@pytest.mark.parametrize(
    "line, why",
    [
        ("10 = 7.1", "one_hex"),
        ("G = 7.1", "one_hex"),
        ("3 = 7. 3 .2", "mode"),
        ("3 = 7.", "mode"),
        ("3 = .7", "mode"),
        ("3 = ", "mode"),
        ("3 = 7.1x", "mode"),
        ("3 = 7.1 x", "behind"),
    ],
)
def test_phgcode_bad_line(line: str, why: str) -> None:
    table = parse_phgcode(f"{line}\n4 = 7.1\n5=7.1")
    assert faults(table) == [(1, why)]
    assert entries(table) == {4: "7.1", 5: "7.1"}, "one mode may stand under two codes"


def test_faults_name_file_and_line_in_both_languages() -> None:
    fault = parse_texts("3e='x'", "TEXTE.DAT").faults[0]
    assert str(fault) == "TEXTE.DAT:1: '3e': two hex digits 00 to FF expected, letters in upper case"
    assert fault.text("de") == "TEXTE.DAT:1: '3e': zwei Hexziffern 00 bis FF verlangt, Buchstaben gross"


def test_every_text_is_there_in_both_languages_and_panel_texts_fit_a_line() -> None:
    for key in keys():
        for language in ("de", "en"):
            said = say(key, language, "a", "b")
            assert said and said.isascii()
            assert not key.startswith("phg_") or len(said) <= 20, key


@given(st.text(max_size=200), st.sampled_from([parse_msd, parse_texts, parse_exprog, parse_phgcode]))
def test_any_text_gives_a_table(text: str, parser: object) -> None:
    assert callable(parser)
    table = parser(text)
    assert all(0 < fault.line <= text.count("\n") + 1 for fault in table.faults)
    assert all(fault.text("de") for fault in table.faults)
