"""One mistake of a declaration is one fault at its place: what the rest of the program does with it is no further one."""

import pytest

from hil_tests.unit.languages.baps2.running import body, faults_of, library_of, run, short

ROBOT = ";;KINEMATICS : (1 = K)\n;;K.JC_NAMES = A1, A2, A3\n;;K.WC_NAMES = X, Y\n"
MOVES = body("@J.A2 = @J.A3\nMOVE K TO @(1, 2, 3)\n@J = JC((1, 2))\nMOVE TO @J\nP.Y = 1", "K.JC_POINT : @J K.POINT : P")


@pytest.mark.parametrize(
    "right, wrong, found",
    [
        ("A1, A2, A3", "A1, A2,, A3", ("instruction-value", 2)),
        ("A1, A2, A3", "A1, A 2, A3", ("instruction-value", 2)),
        ("K.JC_NAMES", "K.JC_NAMS", ("instruction-unknown", 2)),
        ("K.WC_NAMES", "K.WCNAMEN", ("instruction-unknown", 3)),
        ("WC_NAMES = X, Y", "WC_NAMES = X, 2Y", ("instruction-value", 3)),
    ],
)
def test_faulty_names_of_components(right: str, wrong: str, found: tuple[str, int]) -> None:
    assert faults_of(ROBOT + MOVES) == []
    assert faults_of(ROBOT.replace(right, wrong) + MOVES) == [found]
    assert faults_of(ROBOT.replace(right, wrong) + MOVES + "SR S\nBEGIN\nX = 1\nSR_END\n") == [found, ("name-unknown", 15)], (
        "what is not a consequence is reported"
    )


ROUTINE = "SUBROUTINE S (INTEGER : X, Y INTEGER : Z)\nBEGIN\nZ = X + Y\nSUB_END\n"


@pytest.mark.parametrize(
    "calls, found",
    [
        ("S(1, 2, I)\nS(I + 1, 3, I)", [("value-missing", 7)]),
        ("S(C, 2, I)\nS(C, 3, I)\nS(2, C, I)", [("value-missing", 8)]),
        ("S(1, I, I)", [("not-assignable", 4)]),
        ("S(1, I, I)\nS(I, I, I)\nS(2, I, I)", [("not-assignable", 4), ("not-assignable", 6)]),
        ("S(1, I, Q)\nS(2, 3, I)", [("name-unknown", 4), ("value-missing", 7)]),
    ],
)
def test_a_missing_value_in_front_of_parameters(calls: str, found: list[tuple[str, int]]) -> None:
    assert faults_of(body(calls, "INTEGER : I CONST : C = 7") + ROUTINE) == found


def test_a_missing_value_of_a_special_function() -> None:
    declared = "SPC_FCT : 28 = SET_BELT (INTEGER : N VALUE REAL : R)"
    assert faults_of(body("SET_BELT(1, 2.5)\nSET_BELT(2, 3.5)", declared)) == [("value-missing", 2)]
    fault = next(iter(library_of({}).check("P.QLL", body("SET_BELT(1, 2.5)\nSET_BELT(2, 3.5)", declared))[1]))
    assert (fault.text, fault.position.column) == ("VALUE is missing in front of INTEGER", 26)


def test_a_missing_program_that_data_are_imported_from() -> None:
    declared = "EXTERNAL GONE : N, M\nEXTERNAL GONE : Q"
    assert faults_of(body("N = 1 M[3] = 2 Q.X = N MOVE TO Q START GONE WRITE N", declared)) == [("import-missing", 2)]


@pytest.mark.parametrize(
    "text, found",
    [
        ("INTEGER : I\nPROGRAM P\nBEGIN\nI = 1\nPROGRAM_END\n", [("no-program", 1)]),
        (body("SYNCHRON K B1\nSYNCHRON_END", "K.BELT : 501 = B1"), [("kinematic-unknown", 2)]),
        (body("R = NOT R", "REAL : R"), [("type", 4)]),
        (body("R = R AND 1 = 1", "REAL : R"), [("type", 4)]),
        (body("I = 1.5.2\nR = .5.2 + 1.5", "INTEGER : I REAL : R"), [("no-token", 4), ("no-token", 5)]),
    ],
)
def test_other_mistakes_are_one_fault(text: str, found: list[tuple[str, int]]) -> None:
    assert faults_of(text) == found


def test_an_output_that_is_passed_on_is_set_and_read() -> None:
    """The output of a parameter was channel 0."""
    text = body("S(O4)\nS(O5)", "OUTPUT : 4 = O4, 5 = O5") + "SUBROUTINE S (OUTPUT : O)\nBEGIN\nO = 1\nO = NOT O\nSUB_END\n"
    assert short(run(text), "out") == [(0.0, "out", 4, 1), (0.0, "out", 4, 0), (0.0, "out", 5, 1), (0.0, "out", 5, 0)]


def test_a_file_that_is_read_is_copied() -> None:
    """Only an open target is refused (L5893-5900)."""
    declared = "SPC_FCT : 4 = CMD (VALUE INTEGER : C TEXT : S, T INTEGER : R)\nFILE : A\nTEXT : S, T\nINTEGER : R"
    text = body("READ_BEGIN A S = 'A.DAT' T = 'B.DAT' CMD(2, S, T, R) WRITE PHG, R CMD(2, T, S, R) WRITE PHG, R", declared)
    events = run(text, '[files]\n"A.DAT" = "31"')
    assert [event["hex"] for event in events if event["event"] == "write"] == ["30", "2d35"]
