"""Faults of sources that can be read but not run: each with its kind and line; what the manual prints has none."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_tests.unit.languages.baps2.running import body, faults_of, library_of
from hil_tests.unit.languages.baps2.words import WORDS

HEAD = ";;KINEMATICS : (1=K, 2=L)\n;;K.WC_NAMES = X,Y\n;;K.JC_NAMES = A1,A2\n;;L.WC_NAMES = Z\n"


@pytest.mark.parametrize(
    "statements, declared, expected",
    [
        ("X = 1", "", [("name-unknown", 4)]),
        ("I = 1.5", "INTEGER : I", [("type", 4)]),
        ("I = 'A'", "INTEGER : I", [("type", 4)]),
        ("B = 2", "BINARY : B", [("type", 4)]),
        ("B = 1 R = 1", "BINARY : B REAL : R", []),
        ("C = 2", "CONST : C = 1", [("not-assignable", 4)]),
        ("E = 1", "INPUT : 1 = E", [("not-assignable", 4)]),
        ("IF I THEN HALT", "INTEGER : I", [("type", 4)]),
        ("JUMP GONE", "", [("label-missing", 4)]),
        ("L: L: HALT", "", [("label-twice", 4)]),
        ("JUMP M REPEAT 2 TIMES M: HALT REPEAT_END", "", [("jump-into", 4)]),
        ("GONE", "", [("name-unknown", 4)]),
        ("A[11] = 1", "ARRAY[1..10] INTEGER : A", [("index-range", 4)]),
        ("A['X'] = 1", "ARRAY[1..10] INTEGER : A", [("type", 4)]),
        ("EXCLUSIVE S EXCLUSIVE_END", "", [("semaphore", 4)]),
        ("CASE I EQUAL 1 : HALT EQUAL 1 : HALT CASE_END", "INTEGER : I", [("case-twice", 4)]),
        ("CASE I EQUAL J : HALT CASE_END", "INTEGER : I, J", [("no-constant", 4)]),
        ("WRITE FOO, 1", "", [("name-unknown", 4)]),
        ("I = 1", "INTEGER : I, I", [("declared-twice", 2)]),
        ("I = 1", "INPUT : 130 = E, 999 = F INTEGER : I", [("channel", 2)]),
        ("SF(1)", "SPC_FCT : 99 = SF(VALUE INTEGER : A)", [("special-function-unknown", 2)]),
        ("SF(1)", "SPC_FCT : 28 = SF(VALUE INTEGER : A)", [("special-function-parameters", 2)]),
        ("SF(1)", "SPC_FCT : 28 = SF(VALUE INTEGER : A VALUE REAL : B)", [("argument-count", 4)]),
        ("WRITE F, 'A'", "BNR_FILE : F", [("file-type", 4)]),
        ("WRITE F, 1.5", "FILE INTEGER : F", [("file-type", 4)]),
        ("I = 99999999999", "INTEGER : I", [("number-range", 4)]),
        ("I = 1 / 0", "INTEGER : I", [("constant", 4)]),
        ("I = ROUND(1.0E20)", "INTEGER : I", [("constant", 4)]),
        ("CASE I EQUAL ROUND(1.6) : HALT EQUAL TRUNC(2.9) : HALT CASE_END", "INTEGER : I", [("case-twice", 4)]),
        ("CASE I CASE_END", "INTEGER : I", [("syntax", 4)]),
        ("JUMP\nWAIT 1", "", [("syntax", 4)]),
        ("BREAK = 1", "INTEGER : BREAK", [("name-taken", 2)]),
        ("WRITE 'A\nWRITE 'B'", "", [("text-without-end", 4)]),
        (";;FILE_ERROR -", "", [("instruction-place", 4)]),
        ("I = 1 R = I + 1 R = 'A'", "INTEGR : I REAL : R", [("syntax", 2), ("type", 4)]),
        ("A[2] = J IF A[1] = K THEN HALT", "ARAY[1..2] INTEGER : A INTEGER : J, 5, K", [("syntax", 2), ("syntax", 2)]),
        ("IF E AND F THEN HALT G = 1", "INPT : 1 = E, 2 = F OUTPUT 3 = G", [("syntax", 2), ("syntax", 2)]),
        ("EXCLUSIVE S WRITE F, 1 CLOSE F START T SYNC B = 1 EXCLUSIVE_END", "SEMAFOR : S, T FIL : F, B", [("syntax", 2), ("syntax", 2)]),
        ("SF(1, 2) TOLD(I)", "SPC_FCT : 21 = SF(VALUE INTEGR : A, B) INTEGER : I PUBLIC ITEGER : TOLD", [("syntax", 2), ("syntax", 2)]),
        (
            "S(1) I = 'A' PROGRAM_END SR S(VALUE INTEGR : X)\nBEGIN I = X\nSUB_END",
            "INTEGER : I",
            [("type", 4), ("syntax", 4), ("behind-the-end", 7)],
        ),
        ("EXCLUSIVE S I = 'A' EXCLUSIVE_END", "INTEGER : S, I", [("semaphore", 4), ("type", 4)]),
        ("RED PHG, I RED I, J I = 'A'", "INTEGER : I, J", [("name-unknown", 4), ("name-unknown", 4), ("type", 4)]),
        ("MOE UNTIL E = 1\nERROR JUMP L\nTO P1\nL: HALT", "INPUT : 1 = E", [("name-unknown", 4)]),
        ("GONE OTHER I = 1", "INTEGER : I EXTERNAL : OTHER", [("program-missing", 2), ("name-unknown", 4)]),
        ("SF(1, 2)", "SPC_FCT : 21 : SF(VALUE INTEGER : A, B)", [("syntax", 2)]),
        ("WRITE PHG, CLS IF VERSION < 2.31 THEN HALT", "", []),
    ],
)
def test_faults_name_kind_and_line(statements: str, declared: str, expected: list[tuple[str, int]]) -> None:
    assert faults_of(body(statements, declared)) == expected


@pytest.mark.parametrize(
    "statements, expected",
    [
        ("MOVE TO HERE HERE.X = 1 @THERE.A1 = 2 MOVE @THERE", []),
        ("MOVE L TO (1,2)", [("point-size", 8)]),
        ("MOVE TO (1)", [("point-size", 8)]),
        ("MOVE L TO (1) MOVE_REL L (0)", []),
        ("P1.Q = 1", [("component-unknown", 8)]),
        ("P1 = @POS", [("type", 8)]),
        ("P1 = WC(@POS) @J = JC(P1)", []),
        ("MOVE L TO P1", [("kinematic-other", 8)]),
        ("MOVE UNTIL P1.X > 1 TO P1", [("until-condition", 8)]),
        ("MOVE WITH Q = 1 TO P1", [("factor-unknown", 8)]),
        ("V = 1 K.VFACTOR = 0.5 MOVE WITH R_PTP = 140% VIA P1", []),
    ],
)
def test_points_belong_to_their_kinematic(statements: str, expected: list[tuple[str, int]]) -> None:
    assert faults_of(HEAD + body(statements, "K.POINT : P1 K.JC_POINT : @J")) == expected


@pytest.mark.requirement("RHO-BAP-03", by="gateway.pure.languages.baps2.naming:Naming._constant")
def test_constants_are_worked_out_and_cannot_be_set() -> None:
    declared = "CONST : RED = 1, YELLOW = 2 * RED, GREEN = 2 * YELLOW ARRAY[RED..GREEN] CHAR : A"
    assert faults_of(body("A[4] = 'X' A[5] = 'X' GREEN = 1", declared)) == [("index-range", 4), ("not-assignable", 4)]


@pytest.mark.requirement("RHO-BAP-01", by="gateway.pure.languages.base.faults:Faults.full")
def test_error_n_ends_after_n_errors_and_warnings_can_be_off() -> None:
    text = "PROGRAM P\nINTEGER : A_VERY_LONG_NAME\nBEGIN\nA = 1\nB = 1\nC = 1\nF = 1\nPROGRAM_END"
    assert [id for id, _ in faults_of(text)].count("name-unknown") == 3
    assert [id for id, _ in faults_of(";;ERROR = 2\n" + text)].count("name-unknown") == 2
    assert "long-name" not in [id for id, _ in faults_of(";;WARNING -\n" + text)]


def test_a_name_of_more_than_12_characters_is_a_warning_wherever_it_is_given() -> None:
    text = "PROGRAM PROGRAM_OF_13\nPOINT : TWELVE_LONG1\nBEGIN\nLABEL_OF_LINE: ROUTINE_OF_14\nPROGRAM_END\nSR ROUTINE_OF_14\nBEGIN SR_END"
    assert faults_of(text) == [("long-name", 1), ("long-name", 4), ("long-name", 6)]


def test_imports_are_typed_by_the_exporter() -> None:
    exporter = "PROGRAM A\nPUBLIC INTEGER : N\nINTEGER : M\nBEGIN PROGRAM_END"
    assert faults_of(body("N = 'X'", "EXTERNAL A : N"), A=exporter) == [("type", 4)]
    assert faults_of(body("N = 1", "EXTERNAL A : M, N"), A=exporter) == [("import-unknown", 2)]
    assert faults_of(body("N = 1", "EXTERNAL GONE : N")) == [("import-missing", 2)]
    assert ("import-mixed", 3) in faults_of(body("N = 1", "PUBLIC INTEGER : O\nEXTERNAL A : N"), A=exporter)
    assert ("import-mixed", 3) in faults_of(body("N = 1", "EXTERNAL A : N\nPUBLIC INTEGER : O"), A=exporter)
    assert ("import-two", 3) in faults_of(body("N = 1", "EXTERNAL A : N\nEXTERNAL B : Q"), A=exporter, B=exporter)


@pytest.mark.parametrize(
    "text, expected",
    [
        ("PROGRAM P\nBEGIN\nPROGRAM_END\nPROGRAM Q\nBEGIN\nPROGRAM_END", [("behind-the-end", 4)]),
        ("PROGRAM\nBEGIN\nHALT\nPROGRAM_END", [("syntax", 1)]),
        (";;KINEMATICS : (1 = K; 2 = L) ; C\nPROGRAM P\nK.POINT : P\nL.POINT : Q\nBEGIN\nPROGRAM_END", [("kinematics", 1)]),
        (
            ";;KINEMATICS : (1 = K)\n;;K.JC_NAMES A1; A2\nPROGRAM P\nJC_POINT : @P\nBEGIN\n@P.A2 = 1\nPROGRAM_END",
            [("instruction-value", 2)],
        ),
        (";;KINEMATICS : 1 = K ; 1\n;;K.WC_NAMES = X, Y ; axes\nPROGRAM P\nPOINT : P\nBEGIN\nP = (1, 2)\nPROGRAM_END", []),
        (";;SER_IO_STOP -\n;;SER_IO_STOP +\nPROGRAM P\nBEGIN\nPROGRAM_END", [("instruction-twice", 2)]),
        (
            "PROGRAM P\nBEGIN\nS\nPROGRAM_END\n;;FILE_ERROR -\nSR S\n;;SER_IO_STOP -\nBEGIN SR_END",
            [("instruction-place", 5), ("instruction-place", 7)],
        ),
        ("PROGRAM START\nINTEGER : I\nBEGIN\nI = 1\nPROGRAM_END", []),
        ("PROGRAM BEGIN\nSTART\nHALT\nPROGRAM_END", []),
        ("PROGRAM P\nINTEGER : I\nL: I = 1\nIF I = 1 THEN JUMP L\nPROGRAM_END", [("no-begin", 3)]),
        ("PROGRAM P\nINTEGER : I\nBEGIN\nS(I + 1)\nPROGRAM_END\nSR S(INTEGER : X)\nBEGIN\nSR_END", [("not-assignable", 4)]),
    ],
)
def test_each_fault_of_a_frame_is_reported_once(text: str, expected: list[tuple[str, int]]) -> None:
    assert faults_of(text) == expected


@pytest.mark.requirement("RHO-BAP-21", by="gateway.pure.languages.baps2.words:Words.token")
def test_words_in_lower_case_and_translator_s_words_are_read() -> None:
    text = "Program p\ninput : 1 = e\nStart\nWait until e = 1\nparallel\nif e = 1 then halt otherwise break\n"
    text += "also\nmove after p1\nparallel_end\nprogram_end"
    assert faults_of(text) == []


@given(
    st.lists(
        st.sampled_from(
            [
                *(each.text for row in WORDS.spellings.values() for each in row),
                *"X Y @P 1 2.5 ( ) , = : . [ ] + - * / < 'T' .. POS P.X \n".split(" "),
            ]
        ),
        max_size=80,
    )
)
def test_any_row_of_words_is_checked_without_an_exception(row: list[str]) -> None:
    library = library_of({})
    library.check("P.QLL", "PROGRAM P INTEGER : X TEXT : Y POINT : P BEGIN " + " ".join(row) + " PROGRAM_END")
    library.check("P.QLL", " ".join(row))


def test_long_chains_and_deep_loops_are_faults_and_no_crash() -> None:
    assert faults_of(body("I = 1\nI = " + "+".join(["I"] * 5_000), "INTEGER : I")) == [("too-complex", 5)]
    assert faults_of(body("IF I = 1 THEN BEGIN\nI = " + "+".join(["I"] * 150) + "\nEND", "INTEGER : I")) == [("too-complex", 5)]
    assert ("nesting-too-deep", 4) in faults_of(body("REPEAT 1 TIMES " * 40 + "REPEAT_END " * 40))
    assert [id for id, _ in faults_of(body("IF 1=1 THEN BEGIN\n" * 500 + "END " * 500))].count("nesting-too-deep") == 1


@pytest.mark.parametrize(
    "statements, expected",
    [
        ("MOVVE TO (1, 2)\nHALT", [("name-unknown", 4)]),
        ("S TO (1, 2)\nHALT", [("syntax", 4)]),
        ("FOO 5", [("name-unknown", 4)]),
        ("INT_ASC TO P", [("name-unknown", 4)]),
        ("MOVE N TO (1, 2)", [("kinematic-unknown", 4)]),
        ("MOVE N LINEAR VIA P TO Q", [("kinematic-unknown", 4)]),
        ("MOVE P, Q\nMOVE K TO P\nMOVE R TO Q\nS\nS S", []),
    ],
)
def test_a_misspelt_word_or_kinematic_is_one_fault(statements: str, expected: list[tuple[str, int]]) -> None:
    text = ";;KINEMATICS : (1=K)\n;;K.WC_NAMES = X,Y\n" + body(statements, "POINT : R") + "SUBROUTINE S\nBEGIN\nHALT\nSUB_END\n"
    assert faults_of(text) == [(kind, line + 2) for kind, line in expected]


def test_a_source_ends_at_the_end_mark_of_dos() -> None:
    source = {"P": body("HALT") + "\x1a\x00\x00garbage", "Q": "PROGRAM Q\nBEGIN\n\x1aHALT\nPROGRAM_END"}
    library = library_of(source)
    assert [[each.id for each in library.unit(name)[1]] for name in source] == [[], ["not-closed"]]


def test_a_name_that_begins_with_a_digit_is_one_fault() -> None:
    digit = "name-begins-with-digit"
    assert faults_of(body("3X = 1\n3x = 3X + 2", "INTEGER : 3X")) == [(digit, 2)]
    for statement in ("3X = 1", "A = 3X", "A = 3V", "MOVE TO 3P", "JUMP 3L\n3L:", "WRITE 3X", "3SUB(A)", "A = 3F(1)"):
        assert faults_of(body(statement, "INTEGER : A")) == [(digit, 4)], statement
    assert faults_of(body("RPT 3TIMES RPT_END")) == [("number-runs-into-word", 4)]
