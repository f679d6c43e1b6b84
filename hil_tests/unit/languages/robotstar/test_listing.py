"""Import of printed listings, and texts that are no programs."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.listing import PointFault, import_listing, points_of
from gateway.pure.languages.robotstar.memory import Memory, Source
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.script import NS, OrderFault, orders
from gateway.pure.languages.robotstar.system import NAMES
from gateway.pure.languages.robotstar.virtual import VirtualCell
from hil_tests.unit.languages.robotstar.memory import WORDS

TABLE = """| | | |
|-----|-----------|
| S1 | MPR | BEWEGUNG (INTERPOL) |
| S2 | WERKZEUG | T |
| S9 | POSITION | A |
| S10 | MARKÈ | WIEDERHOLE |
| S11 | POSITION | <start  point> |
"""


def test_a_printed_table_becomes_a_program() -> None:
    found = import_listing(TABLE, WORDS, points_of("name,X,Y,Z,A,B,C,A7\nA,1,2,3,0,0,0,\nstart point,4,5,6,0,0,90,7.5\n"))
    lines = [line.split(None, 1)[1] for line in found.files["BEWEGUNG.MPR"].splitlines()]
    assert lines == [
        'MPR "BEWEGUNG"',
        "WERKZEUG T",
        "POSITION #N, X:1, Y:2, Z:3, A:0, B:0, C:0",
        "MARKE WIEDERHOLE",
        "POSITION #N, X:4, Y:5, Z:6, A:0, B:0, C:90, A7:7.5",
        "END",
    ]
    assert [(note.line, note.text) for note in found.notes] == [
        (5, "steps 3 to 8 are not printed"),
        (6, "MARKÈ is read as MARKE"),
        (7, "BEWEGUNG: END is not printed; it is added"),
    ]


@pytest.mark.parametrize("sign", [";", "\t"])
def test_a_german_table_of_points_has_decimal_commas(sign: str) -> None:
    table = "\ufeffname;X;Y;Z;A;B;C\nP1;4,5;-5;6;0;0;90\n".replace(";", sign)
    assert points_of(table) == {"P1": "X:4.5, Y:-5, Z:6, A:0, B:0, C:90"}


def test_all_system_variables_are_known_to_the_reader_of_a_print() -> None:
    assert set(VirtualCell(Memory.read([], WORDS, Faults()), MODES["auto"]).system.names()) == NAMES


def test_points_that_are_missing_are_named() -> None:
    found = import_listing(TABLE, WORDS)
    assert "POSITION A: the values are not printed; give them with --points" in [note.text for note in found.notes]
    assert "POSITION A" in found.files["BEWEGUNG.MPR"]


def test_marks_of_the_cursor_words_in_two_parts_and_positions_of_a_kind() -> None:
    found = import_listing(
        "1 MPR M\n->2 PTP GESCHW 50\n-3 SCHR BIT #AUSGANG, 1, 0, 4\n4 POSITION #P, Q\n5 POSITION #N\n6 END", WORDS, {"Q": "A7:1"}
    )
    lines = [line.split(None, 1)[1] for line in found.files["M.MPR"].splitlines()]
    assert lines[1:5] == ["PTP_GESCHW 50", "SCHR_BIT #AUSGANG, 1, 0, 4", "POSITION #P, A7:1", "POSITION #N"]
    assert [(note.line, note.text) for note in found.notes] == [
        (5, "POSITION without a name: the values are not printed; give them with --points")
    ]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "X,Y\n1,2",
        "name,X,Q\na,1,2",
        "name,X,Y,Z,A,B,C\na,1,2,3,4,5,x",
        "name,X\na,1,2",
        "name,X,Y\na,1,2",
        "name,X,Y,Z,A,B,C\na,1,2,3,4,,6",
    ],
)
def test_a_table_of_points_that_is_none(text: str) -> None:
    with pytest.raises(PointFault):
        points_of(text)


@pytest.mark.parametrize(
    "text", ["", "START", "1", "x START", "1 E40.0=1", "1 E0.8=1", "1 M20=256", "1 EA2=11", "1 DRIVES", "1 JUMP", "1 E0.1=2"]
)
def test_orders_that_are_none(text: str) -> None:
    with pytest.raises(OrderFault):
        orders([text])


NAMED = (*WORDS.words, *(f"#{name}" for name in WORDS.equates), *(f"{name}:" for name in WORDS.descriptors))
OPERANDS = ("I1", "V1.X", "T", "P1", "S1(5)", "I_A[3]", "I_A[I1]", "_SPS[1]", "12", "0FH", "1B", "2.5", "-1", "<x>", "#=", "#=1", "X:1")
_PARTS = st.sampled_from(("1 ", "\\", ",", " ", '"', "[", "]", "(", ":", "\n", *NAMED, *OPERANDS))


@given(st.lists(_PARTS, max_size=60).map("".join) | st.text(max_size=200))
def test_no_text_is_an_exception(text: str) -> None:
    """Whatever a file holds: faults, or a run that ends with a message."""
    faults = Faults()
    frame = "\n".join(["MPR P", "VAR I1", "VAR V1", "VAR P1", "VAR I_A[3]", text, "END"])
    memory = Memory.read([Source("P.MPR", frame), Source("Q.SPR", text)], WORDS, faults)
    cell = VirtualCell(memory, MODES["test2"])
    check(memory, faults, cell.system.names())
    cell.run([], NS, "P")
    assert cell.end("P")["state"] in ("running", "waiting", "stopped", "error")
    import_listing(text, WORDS)


MESSY = """ROBOTstar V            Programmlisting            Seite 1
1   MPR "PAL"
2   C Kartons, Stand O3/99, Grei-
    fer zu
3   W ERKZEUG T_GREIFER
4   PTP_GESCHW 8O
5   POSITION #N, X:1OOO.O Y:-25O.5; Z:1.234,5, A:l80, B:O, C:0
6   BEWEG-ART #LlNEAR
7   WARTE_BIT #EINGANG, Pegel 1, Byte: 0, Bit_Nr: 3, Max_Zeit: 5.O,
    Marke: "1O"
Seite 2
8   WAIT 0,5
9   ADD 1 I_N
10  PALLET "P1". #0N
11  COPY OFFH, I_N
12  TEST_BIT #EINGANG, #=l, 1, 2B, "1O"
13  U-PROG "SUB"
14  OR 101B, I_N
15  ST0P
l6  ENDE
"""


def test_letters_signs_and_broken_lines_of_a_print_are_put_right_and_named() -> None:
    found = import_listing(MESSY, WORDS)
    assert [line.split(None, 1)[1] for line in found.files["PAL.MPR"].splitlines()] == [
        'MPR "PAL"',
        "C Kartons, Stand O3/99, Greifer zu",
        "WERKZEUG T_GREIFER",
        "PTP_GESCHW 80",
        "POSITION #N, X:1000.0, Y:-250.5, Z:1234.5, A:180, B:0, C:0",
        "BEWEG_ART #LINEAR",
        'WARTE_BIT #EINGANG, Pegel: 1, Byte: 0, Bit_Nr: 3, Max_Zeit: 5.0, Marke: "1O"',
        "WAIT 0.5",
        "ADD 1, I_N",
        'PALLET "P1", #ON',
        "COPY 0FFH, I_N",
        'TEST_BIT #EINGANG, #=1, 1, 28, "1O"',
        'U_PROG "SUB"',
        "OR 101B, I_N",
        "STOP",
        "ENDE",
    ]
    notes = [(note.line, note.text) for note in found.notes]
    assert {line for line, _ in notes} == {1, 4, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 19, 20}
    assert (
        (6, "8O is read as 80") in notes and (10, 'Marke: "1O" belongs to the line before') in notes and (20, "l6 is read as 16") in notes
    )
    assert (17, "U-PROG is read as U_PROG") in notes and (19, "ST0P is read as STOP") in notes


def test_two_columns_of_a_page_are_read_one_after_the_other() -> None:
    page = '1 SPR "G"       |  5 LABEL "ZU"\n2 WAIT 1        |  6 WAIT 3\n3 C left        |  7 END\n4 C to the end  |\n'
    other = "1 MPR M           4 WAIT 4\n2 WAIT 2          5 END\n3 WAIT 3\n"
    found = import_listing(f"{page}\n{other}", WORDS)
    steps = {name: [line.split(None, 1)[1] for line in text.splitlines()] for name, text in found.files.items()}
    assert steps["G.SPR"] == ['SPR "G"', "WAIT 1", "C left", "C to the end", 'LABEL "ZU"', "WAIT 3", "END"]
    assert steps["M.MPR"] == ['MPR "M"', "WAIT 2", "WAIT 3", "WAIT 4", "END"]
    assert [(note.line, note.text) for note in found.notes] == [(line, "two columns are read one after the other") for line in (1, 6)]
    two = import_listing("1 MPR A          1 SPR B\n2 CALL B         2 WAIT 2\n3 END            3 END\n", WORDS)
    assert [(name, len(text.splitlines())) for name, text in two.files.items()] == [("A.MPR", 3), ("B.SPR", 3)] and len(two.notes) == 1


CLEAN = (
    "COPY I1, R_B", "TOOL T1", "ADD _SPS[6], I_A[I1]", "OR 0FFH, I_N", "AND 1010B, I_N", "TEST_BIT #VARIABLE, #=0, I1, 2, A1", "WAIT R1",
    'COPY "8O, l1", S_N', "COPY V1.X, P1.X", "RELATIVE _VNULL", "LABEL B8", "BRANCH B8", "C 8O l1 ; x. #0N", "POSITION #P, A1:1, A7:-2.5",
    "TEST #VARIABLE, I1, #<=, 5, ENDE", "COPY VECTOR.X, PT.X", "COPY I_A[I12], R1", 'TRAFO_6D A, B, "C", D, I1', 'C "open, #<x ; Pege1',
    "TEST #VARIABLE, I1, #<, 5, Marke: B", "PTP_SPEED [%] : 80", "VAR P1, X:1, Y:2, Z:3, A:0, B:0, C:0, A7:-1.5",
    "COPY_OFFSETS 2, V1, 3, V2, 2", "VAR_POS P1", "CALL 1O", "PROGRAM S_B",
)  # fmt: skip


@pytest.mark.parametrize("step", CLEAN)
def test_a_step_without_a_slip_stays_as_it_is(step: str) -> None:
    found = import_listing(f"1 MPR M\n2 {step}\n3 END\n", WORDS)
    assert (found.files["M.MPR"].splitlines()[1].split(None, 1)[1], found.notes) == (step, [])


PAGES = """MPR HAUPT

1 MPR HAUPT
2 WAIT 1.0
MPR HAUPT
3 WAIT 2.0
4 ENDE
MPR HAUPT
1 MPR HAUPT
2 WAIT 3.0
"""


def test_a_head_printed_as_a_title_or_on_each_page_begins_no_program() -> None:
    """Behind ENDE it does; the second program gets a name of its own."""
    found = import_listing(PAGES, WORDS)
    steps = {name: [line.split(None, 1)[1] for line in text.splitlines()] for name, text in found.files.items()}
    assert steps == {
        "HAUPT.MPR": ['MPR "HAUPT"', "WAIT 1.0", "WAIT 2.0", "ENDE"],
        "HAUPT_2.MPR": ['MPR "HAUPT_2"', "WAIT 3.0", "END"],
    }
    again = [note.line for note in found.notes if "printed again" in note.text]
    assert again == [3, 5, 9]


def test_titles_of_the_pages_of_a_numbered_listing_are_no_steps() -> None:
    title = "REIS ROBOTstar V      Programmlisting    12.03.97  Seite"
    text = f'{title} 1\nProgramm: S:/TEILE/A.MPR\n\n1 MPR "A"\n2 WAIT 1\n3 WAIT 2\n4 WAIT 3\n{title} 2\n5 WAIT 4\n6 STOP\n7 ENDE\n'
    found = import_listing(text, WORDS)
    assert {name: len(steps.splitlines()) for name, steps in found.files.items()} == {"A.MPR": 7}
    assert [(note.line, note.text) for note in found.notes] == [
        (1, "REIS .. is not a step and is left out"),
        (2, "'Programm: S:/TEILE/A.MPR' is not a step and is left out"),
        (8, "REIS .. is not a step and is left out"),
    ]


def test_a_step_whose_number_is_lost_is_between_its_neighbours() -> None:
    found = import_listing('1 MPR "A"\n2 WAIT 1\nGREIFER_ZU\n4 WAIT 3\n  WAIT 4\n6 STOP\n7 ENDE\n', WORDS)
    assert [line.split(None, 1)[1] for line in found.files["A.MPR"].splitlines()][2:5] == ["GREIFER_ZU", "WAIT 3", "WAIT 4"]
    assert [note.text for note in found.notes] == [
        "GREIFER_ZU is read as 3 GREIFER_ZU",
        "GREIFER_ZU is not a command; it is kept as the call of a macro",
        "WAIT 4 is read as 5 WAIT 4",
    ]
    found = import_listing('1 MPR "A"\n2 WAIT 1\n8 WAIT 2\n4 WAIT 3\n4 WAIT 4\n6 ENDE\n', WORDS)
    assert [note.text for note in found.notes] == ["8 WAIT 2 is read as 3 WAIT 2", "4 WAIT 4 is read as 5 WAIT 4"]


def test_steps_of_a_printed_plc_program_stay_as_they_are() -> None:
    """SP is a jump there and no head; brackets, comparisons and assignments begin with a sign."""
    steps = ["; start", "U(", "O E0.0", "O E0.1", ")", "= A1.0", "SP ZIEL,1", "L 12ACH", "TD M20", "=?", "M ZIEL", "SU LAMPE", "END"]
    rows = [f"{number:4} {step}" for number, step in enumerate(["PLC 'MAIN'", *steps], 1)]
    found = import_listing(
        "\n".join([*rows, "   1 PLC 'LAMPE'", "   2 = A1.1", "   3 END", "   1 MPR A", "   2 WAIT 1", "   3 END"]), WORDS
    )
    assert found.notes == []
    assert list(found.files) == ["MAIN.PLC", "LAMPE.PLC", "A.MPR"]
    assert [line[5:] for line in found.files["MAIN.PLC"].splitlines()] == ['PLC "MAIN"', *steps]


def test_the_first_letter_of_a_variable_read_as_a_digit_is_put_right_where_no_label_or_program_is_named() -> None:
    read = "VAR 1ZAEHL\nVAR Name: 5_PROG(20)\nKOPIERE l00, 1ZAEHL\nTESTE #VARIABLE, Op_1: lZAEHL, #<, Op_2: 9, Marke: 1ABC\nMARKE 1ABC\n"
    meant = "VAR IZAEHL\nVAR Name: S_PROG(20)\nKOPIERE 100, IZAEHL\nTESTE #VARIABLE, Op_1: IZAEHL, #<, Op_2: 9, Marke: 1ABC\nMARKE 1ABC\n"
    same = "AND 1ABCH, IZAEHL\nKOPIERE 1AFFH, _SPS[IZAEHL]\nCALL 5_PROG\nENDE"
    steps = [f"MPR P\n{text}{same}".splitlines() for text in (read, meant)]
    listing = "\n".join(f"{number} {step}" for number, step in enumerate(steps[0], 1))
    found = import_listing(listing, WORDS).files["P.MPR"]
    assert [line[5:] for line in found.splitlines()[1:]] == steps[1][1:]


def test_decimal_commas_of_a_position_without_commas_between_its_values() -> None:
    found = import_listing("1 MPR A\n2 TOOL T\n3 POSITION #N, X: 500,0 Y: -0,5 Z: 1.234,5 A: 0 B: 0 C: 180\n4 END\n", WORDS)
    assert found.files["A.MPR"].splitlines()[2][5:] == "POSITION #N, X: 500.0, Y: -0.5, Z: 1234.5, A: 0, B: 0, C: 180"


@pytest.mark.parametrize(
    ("printed", "meant"),
    [
        ("WARTE_BIT *EINGANG, Pegel.1, Byte;0, Bit Nr:3", "WARTE_BIT #EINGANG, Pegel:1, Byte:0, Bit_Nr:3"),
        ("WARTE_BIT # EINGANG,Pege1:1,8yte:0,Bit_Nr:3", "WARTE_BIT #EINGANG,Pegel:1,Byte:0,Bit_Nr:3"),
        ("WARTE_BIT EINGANG,1,0,3", "WARTE_BIT #EINGANG,1,0,3"),
        ("TESTE #VARIABLE,0p_l:I_N,#)=,Op_2:5,Marke:''M1''", 'TESTE #VARIABLE,Op_1:I_N,#>=,Op_2:5,Marke:"M1"'),
        ('TESTE #VARIABLE,I_N,#> =,5,"M1', 'TESTE #VARIABLE,I_N,#>=,5,"M1"'),
        ('TESTE #VARIABLE,I_N,<,5,Marke:M1"', 'TESTE #VARIABLE,I_N,#<,5,Marke:"M1"'),
        ('SPRUNG Marke "M1"', 'SPRUNG Marke:"M1"'),
        ('CALL Name."HOLEN"', 'CALL Name:"HOLEN"'),
        ('PALLET Prog name:,,PAT",#0N', 'PALLET Prog_name:"PAT",#ON'),
        ("KOPIERE - 5,-SPSl54]", "KOPIERE -5,_SPS[54]"),
        ("KOPIERE Quelle: - 5,Ziel Var:_SPS(54)", "KOPIERE Quelle: -5,Ziel_Var:_SPS[54]"),
        ("LOK_VAR name:V ZP_EP3", "LOK_VAR name:V_ZP_EP3"),
        ("ADD 1.I_A[3", "ADD 1,I_A[3]"),
        ("POSITION #N X=1.0 Y=2.0 Z=3.0 A=0 B=0 C=0", "POSITION #N, X:1.0, Y:2.0, Z:3.0, A:0, B:0, C:0"),
        ("POSITION #N, X;1.0, Y:- 2.0, 2:3.0, A:0, 8:0, C:0", "POSITION #N, X:1.0, Y:-2.0, Z:3.0, A:0, B:0, C:0"),
        ("PTP_GESCHW (%): 8O", "PTP_GESCHW 80"),
        ("BAHN_GESCHW [mm/s]:2OO,0", "BAHN_GESCHW 200.0"),
        ("WARTE 0,5 s", "WARTE 0.5"),
        ("BEWEG_ART H#LINEAR", "BEWEG_ART #LINEAR"),
        ("WARTE_BIT HEINGANG,1,0,3", "WARTE_BIT #EINGANG,1,0,3"),
        ("UEBERSCHL #OEF", "UEBERSCHL #OFF"),
        ("KOPIERE 5, _SP5[54]", "KOPIERE 5, _SPS[54]"),
        ("RELATIVE Vector: _VNU1L", "RELATIVE Vector: _VNULL"),
        ("WARTE_BIT #EINGANG, 1, 0, 5, 3,5, M1", "WARTE_BIT #EINGANG, 1, 0, 5, 3.5, M1"),
        ("KOPIERE Quelle: 2,5, Ziel_Var: R1", "KOPIERE Quelle: 2.5, Ziel_Var: R1"),
    ],
)
def test_signs_of_a_print_are_put_right_and_named(printed: str, meant: str) -> None:
    found = import_listing(f"1 MPR M\n2 {printed}\n3 END\n", WORDS)
    word, _, rest = printed.partition(" ")
    assert found.files["M.MPR"].splitlines()[1][5:] == meant
    assert [note.text for note in found.notes] == [f"{rest} is read as {meant.removeprefix(word).strip()}"]


def test_the_name_of_a_point_is_broken_into_two_lines() -> None:
    text = "1 MPR M\n2 TOOL T\n3 POSITION <over the\n             gripper>\n4 END\n"
    found = import_listing(text, WORDS, {"OVER THE GRIPPER": "X:1, Y:2, Z:3, A:0, B:0, C:0"})
    assert found.files["M.MPR"].splitlines()[2][5:] == "POSITION #N, X:1, Y:2, Z:3, A:0, B:0, C:0"


def test_commands_in_two_words() -> None:
    for printed, meant in (("WARTE BIT #EINGANG,1,0,3", "WARTE_BIT #EINGANG,1,0,3"), ("U.PROG HOLEN", "U_PROG HOLEN")):
        assert import_listing(f"1 MPR M\n2 {printed}\n3 END\n", WORDS).files["M.MPR"].splitlines()[1][5:] == meant
