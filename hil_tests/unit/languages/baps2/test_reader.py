"""Sources as the rho 3 manual prints them are read as they are meant; each fault of a file is reported, none raises."""

from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.languages.baps2.tree import (
    Block,
    CallStatement,
    Case,
    If,
    Jump,
    Label,
    Move,
    Number,
    Parallel,
    Set,
    StartStop,
    Sync,
    WaitUntil,
    Write,
)
from hil_tests.unit.languages.baps2.words import WORDS, ids_of, read_text

QUICK_START = """;;CONTROL = RHO3
;;KINEMATICS : ( 1 = PORTAL , 2 = ZUFUEHRER )
;;PORTAL.JC_NAMES = A1, A2, A3
;;ZUFUEHRER.JC_NAMES = BB
PROGRAMM QUICKST
INPUT : 1 = E1 ;NORMAL DIGITAL INPUT
        611 = HSEIN_1, ;1. HIGH-SPEED INPUT
        635 = HSEIN_5
BEGIN
;;KINEMATICS = PORTAL
;;INT = LINEAR
BEG:
MOVE ZUFUEHRER WARTE_POS
MOVE START_POS
WAIT UNTIL HSEIN_1=1
MOVE TO ZIELPOS_1
MOVE_REL ZUFUEHRER (0) ;so that WAIT command
MOVE UNTIL E1=1 TO ZIELPOS_2
PARALLEL ;
WAIT UNTIL HSEIN_5=1 ;
ALSO ;
MOVE_REL (0,0,0) ;
PARALLEL_END
JUMP BEG
PROGRAMM_END
"""  # rho 3 releases L1637-1688, shortened


def test_quickst_is_read_with_declared_kinematics_deciding_the_grammar() -> None:
    program, faults = read_text(QUICK_START)
    assert program is not None
    assert ids_of(faults) == []
    moves = [each for each in program.main.body if isinstance(each, Move)]
    assert [(move.kinematic, move.relative, move.until is not None) for move in moves] == [
        ("ZUFUEHRER", False, False),
        ("", False, False),
        ("", False, False),
        ("ZUFUEHRER", True, False),
        ("", False, True),
    ]
    assert program.head.kinematics == {"PORTAL": 1, "ZUFUEHRER": 2}
    parallel = next(each for each in program.main.body if isinstance(each, Parallel))
    assert [len(branch) for branch in parallel.branches] == [1, 1]
    assert program.main.body[-1] == Jump(program.main.body[-1].at, "BEG")


def test_line_ends_mean_nothing_and_names_have_no_case() -> None:
    program, faults = read_text("program p integer : Abc begin ABC\n=\n1 aBc = abc + 1 if ABC = 2 then halt program_end")
    assert program is not None
    assert ids_of(faults) == []
    assert [type(each) for each in program.main.body] == [Set, Set, If]


def test_words_are_names_where_they_are_declared() -> None:
    program, faults = read_text("PROGRAM P CONST : START=4, STOP=5 INTEGER : X BEGIN X = START START OTHER STOP OTHER PROGRAM_END")
    assert program is not None
    assert ids_of(faults) == []
    assert [type(each) for each in program.main.body] == [Set, StartStop, StartStop]


def test_semicolons_between_assignments_separate_them_and_others_begin_a_comment() -> None:
    program, faults = read_text("PROGRAM P BEGIN\nAFACTOR=1;DFACTOR=1;V=100\nA = 2 ;A = 3\nPROGRAM_END")
    assert program is not None
    assert ids_of(faults) == []
    assert len(program.main.body) == 4


def test_german_spellings_are_read() -> None:
    program, faults = read_text(
        "PROGRAMM P EINGANG : 1 = E1 GANZ : I ANFANG WDH 3 MAL WENN NICHT E1 DANN I = I + 1 SONST UNTERBRECHE WDH_ENDE "
        "WARTE BIS E1 = 1 MAXZEIT = 2.5 FAHRE LINEAR UEBER P1 NACH P2 PROGRAMM_ENDE"
    )
    assert program is not None
    assert ids_of(faults) == []
    assert isinstance(program.main.body[1], WaitUntil)
    move = program.main.body[2]
    assert isinstance(move, Move)
    assert [leg.through for leg in move.legs] == [True, False]


def test_subroutines_are_behind_the_program_and_outputs_may_stay_open() -> None:
    program, faults = read_text(
        "PROGRAM P BEGIN OUT_WORD ( -1 ) PROGRAM_END\nSUBROUTINE OUT_WORD ( VALUE INT : PARAM )\nBEGIN\nPARAM = PARAM MOD 65536\n"
        "WRITE PHG, CHR ( PARAM MOD 256 ), CHR ( PARAM / 256 ), ..\nSUB_END"
    )
    assert program is not None
    assert ids_of(faults) == []
    assert isinstance(program.main.body[0], CallStatement)
    write = program.subroutines[0].body[1]
    assert isinstance(write, Write)
    assert (write.device, len(write.values), write.open) == ("PHG", 2, True)


def test_case_takes_lists_of_constants() -> None:
    program, faults = read_text(
        "PROGRAM P INTEGER : B, X BEGIN CASE B EQUAL 9,10 : X = 0 EQUAL 13 : BEGIN X = 1 END DEFAULT X = 7 CASE_END PROGRAM_END"
    )
    assert program is not None
    assert ids_of(faults) == []
    case = program.main.body[0]
    assert isinstance(case, Case)
    assert [len(choice.values) for choice in case.choices] == [2, 1]
    assert isinstance(case.choices[1].body, Block)


def test_a_belt_is_set_or_waited_for() -> None:
    program, faults = read_text(
        ";;KINEMATICS:(1=R)\nPROGRAM P INPUT: 1=E1 R.BELT: 501=BN1 BEGIN "
        "SYNC BN1,E1=1 SYNC BN1 >= 200 SYNCHRON R BN1 SYNCHRON_END BN1 PROGRAM_END"
    )
    assert program is not None
    assert ids_of(faults) == []
    assert [each.belt for each in program.main.body if isinstance(each, Sync)] == ["BN1", "BN1"]


def test_a_name_in_front_of_a_colon_is_a_label() -> None:
    program, _ = read_text("PROGRAM P BEGIN LOOP: HALT PROGRAM_END")
    assert program is not None
    assert isinstance(program.main.body[0], Label)


def test_all_faults_of_a_file_are_reported_with_their_lines() -> None:
    _, faults = read_text("PROGRAM P\nINTEGER A\nBEGIN\nA = = 1\nIF A 1 THEN HALT\nWAIT UNTIL\nA = 0THEN\nPROGRAM_END\nREST")
    assert ids_of(faults) == [
        ("syntax", 2),
        ("syntax", 4),
        ("syntax", 5),
        ("number-runs-into-word", 7),
        ("syntax", 7),
        ("behind-the-end", 9),
    ]


def test_what_is_not_closed_names_the_line_it_began_in() -> None:
    _, faults = read_text("PROGRAM P\nBEGIN\nREPEAT 3 TIMES\nHALT\nPROGRAM_END")
    fault = next(iter(faults))
    assert (fault.id, fault.position.line) == ("not-closed", 3)
    assert "line 5" in fault.hint


def test_included_files_are_read_in_their_place_and_loops_of_them_end() -> None:
    program, faults = read_text(
        ";;INCLUDE HEAD\nPROGRAM P BEGIN X = 1 PROGRAM_END", HEAD=";;KINEMATICS : ( 1 = ROB )\n;;INCLUDE HEAD\n;;INCLUDE GONE"
    )
    assert program is not None
    assert program.head.kinematics == {"ROB": 1}
    assert [(fault.id, fault.position.file, fault.position.line) for fault in faults] == [
        ("include-loop", "HEAD.QLL", 2),
        ("include-missing", "HEAD.QLL", 3),
    ]


def test_a_list_of_points_is_passed_as_its_first_word_says() -> None:
    program, faults = read_text("PROGRAM P BEGIN MOVE LINEAR VIA P1, P2, P3 TO P4, P5 PROGRAM_END")
    assert not len(faults) and program is not None
    (move,) = program.main.body
    assert isinstance(move, Move)
    assert [leg.through for leg in move.legs] == [True, True, True, False, False]


def test_a_name_that_is_missing_does_not_swallow_the_end_of_the_program() -> None:
    for word, what in (("STOP", "a program"), ("START", "a program"), ("JUMP", "a label")):
        text = f"PROGRAM P\nBEGIN\n{word}\nPROGRAM_END\nSUBROUTINE S\nBEGIN\nSUB_END"
        program, faults = read_text(text)
        assert [(fault.text, fault.position.line) for fault in faults] == [(f"{what} is expected, not 'PROGRAM_END'", 3)]
        assert program is not None and [each.name for each in program.subroutines] == ["S"]


def test_an_element_without_its_end_at_the_end_of_the_file_is_read() -> None:
    assert ids_of(read_text("PROGRAM P\nBEGIN\nI =\nF[1")[1])
    assert ids_of(read_text("PROGRAM P\nARRAY[1")[1])


def test_a_number_may_have_an_exponent_without_a_point() -> None:
    program, faults = read_text("PROGRAM P BEGIN X = 1E3 X = 2.5e-1 X = .5E+1 PROGRAM_END")
    assert not len(faults) and program is not None
    found = [each.value for each in program.main.body if isinstance(each, Set)]
    assert [each.value for each in found if isinstance(each, Number)] == [1000.0, 0.25, 5.0]
    _, faults = read_text("PROGRAM P BEGIN X = 1EX PROGRAM_END")
    assert ids_of(faults) == [("name-begins-with-digit", 1)]


def test_brackets_without_end_are_a_fault_and_no_crash() -> None:
    _, faults = read_text("PROGRAM P BEGIN X = " + "(" * 5_000 + " PROGRAM_END")
    assert "nesting-too-deep" in {id for id, _ in ids_of(faults)}


@given(
    st.lists(
        st.sampled_from(
            [*(each.text for row in WORDS.spellings.values() for each in row), *"X 1 ( ) , = : . [ ] @ + - ;;A 'T' ..".split(), "\n"]
        ),
        max_size=60,
    )
)
def test_any_row_of_words_gives_faults_and_never_an_exception(row: list[str]) -> None:
    read_text(" ".join(row))
    read_text("PROGRAM P BEGIN " + " ".join(row) + " PROGRAM_END")


@given(st.text(max_size=200))
def test_any_text_gives_faults_and_never_an_exception(text: str) -> None:
    _, faults = read_text(text)
    assert len(faults) > 0


def test_each_line_that_is_no_declaration_is_one_fault() -> None:
    _, faults = read_text("PROGRAM P\nPRIORITY = 5\nEXTERNAL : Q (VALUE INTEGER : N)\nBEGIN\nIF 1 = 1 THEN BEGIN WAIT 1 END\nPROGRAM_END")
    assert [(fault.id, fault.position.line) for fault in faults] == [("no-begin", 2), ("no-begin", 3)]
