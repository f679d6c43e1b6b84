"""What programs do: arithmetic, flow, texts, processes and motion, in virtual time."""

import tomllib

import pytest

from gateway.pure.languages.baps2.dry_run import DryRun
from gateway.pure.languages.baps2.feed import FeedFault, feed_of
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from hil_tests.unit.languages.baps2.running import all_of, body, faults_of, run, short, written
from hil_tests.unit.languages.baps2.words import WORDS


@pytest.mark.parametrize(
    "expression, expected",
    [
        ("7 / 2", "3"),
        ("-7 / 2", "-3"),
        ("-1 MOD 65536", "65535"),
        ("I / J", "-3"),
        ("I MOD J", "1"),
        ("ROUND(2.5)", "3"),
        ("TRUNC(-2.5)", "-2"),
        ("ORD('i')", "105"),
        ("CHR(321)", "A"),
        ("ORD(CHR(129))", "129"),
        ("ORD('\u00e1')", "160"),
        ("140%", "1.4"),
        ("1 + 2.5", "3.5"),
        ("1.5E2 + 1.0e-1", "150.1"),
        ("-1234.45", "-1234.45"),
    ],
)
@pytest.mark.requirement("RHO-BAP-04", by="gateway.pure.languages.baps2.values:code")
def test_expressions_have_the_values_of_the_manual(expression: str, expected: str) -> None:
    assert written(run(body(f"I = -7 J = 2 WRITE {expression}", "INTEGER : I, J"))) == [expected.rjust(8) if "." in expected else expected]


@pytest.mark.parametrize(
    "statements, code",
    [
        ("I = 2147483647 I = I + 1", 208),
        ("I = I / I", 209),
        ("R = 1 / R", 209),
        ("I = 11 A[I] = 1", 210),
        ("P1.X = P2.X", 200),
    ],
)
def test_runtime_errors_have_number_text_and_line(statements: str, code: int) -> None:
    head = ";;KINEMATICS : (1=K)\n;;K.WC_NAMES = X\n"
    events = run(head + body(statements, "INTEGER : I REAL : R ARRAY[1..10] INTEGER : A POINT : P1, P2"))
    assert short(events, "error", "end") == [(0.0, "error", code), (0.0, "end", "aborted")]
    assert [event["line"] for event in events if event["event"] == "error"] == [6]


def test_jumps_loops_and_choices_go_where_they_say() -> None:
    events = run(
        body(
            "I = 0\nLOOP: I = I + 1\nREPEAT 2 TIMES J = J + 1 IF J = 5 THEN JUMP OUT REPEAT_END\n"
            "IF I < 9 THEN JUMP LOOP\nOUT: WRITE I, ' ', J\n"
            "CASE J EQUAL 1,2 : WRITE 'A' EQUAL 5 : BEGIN WRITE 'B' END DEFAULT WRITE 'C' CASE_END",
            "INTEGER : I, J",
        )
    )
    assert written(events) == ["3 5", "B"]


@pytest.mark.requirement("RHO-BAP-02", by="gateway.pure.languages.baps2.bodies:Bodies._case")
def test_case_chooses_by_its_constants_and_does_nothing_without_default() -> None:
    text = "CASE B EQUAL 9,10 : O = 0 EQUAL 13 : O = 2 CASE_END WRITE O"
    assert written(run(body(f"O = 5 B = 13 {text}", "INTEGER : B, O"))) == ["2"]
    assert written(run(body(f"O = 5 B = 14 {text}", "INTEGER : B, O"))) == ["5"]
    german = "FALLS B GLEICH 1, 2 : O = 0 GLEICH 3 : WENN B = 3 DANN O = 3 SONST O = 4 SONST O = 7 FALLS_ENDE SCHREIBE O"
    assert [written(run(body(f"B = {value} {german}", "GANZ : B, O"))) for value in (2, 3, 9)] == [["0"], ["3"], ["7"]]


@pytest.mark.requirement("RHO-BAP-05", by="gateway.pure.languages.baps2.values:int_asc")
def test_int_asc_is_right_aligned_and_leaves_the_array_on_errors() -> None:
    declared = "ARRAY[1..10] CHAR : A TEXT : T INTEGER : E"
    assert written(run(body("INT_ASC(-1234, A, 1, 6, E) WRITE A, E", declared))) == [" -1234    0"]
    assert written(run(body("A = 'XYZ' INT_ASC(-1234, A, 1, 3, E) WRITE A, E", declared))) == ["XYZ       -3"]
    assert written(run(body("INT_ASC(5, A, 8, 5, E) WRITE E INT_ASC(5, A, 0, 1, E) WRITE E INT_ASC(5, A, 1, 0, E) WRITE E", declared))) == [
        "-2",
        "-1",
        "-6",
    ]
    assert written(run(body("INT_ASC(1234, T, 1, 8, E) T[9] = CHR(0) WRITE T, E", declared))) == ["    12340"]


@pytest.mark.requirement("RHO-BAP-06", by="gateway.pure.languages.baps2.values:asc_int")
def test_asc_int_reads_to_the_first_sign_that_is_no_digit() -> None:
    declared = "ARRAY[1..10] CHAR : A INTEGER : I, E"
    assert written(run(body("A = '12A' ASC_INT(A, I, 1, 5, E) WRITE I, ' ', E", declared))) == ["12 0"]
    assert written(run(body("I = 7 A = 'AaBc' ASC_INT(A, I, 1, 5, E) WRITE I, ' ', E", declared))) == ["7 -7"]


def test_subroutines_set_what_is_passed_by_reference_and_not_what_is_passed_by_value() -> None:
    text = (
        body("I = 1 J = 1 SUB(I, J) WRITE I, J, A[2]\nSUB(A[2], J) WRITE A[2]", "INTEGER : I, J ARRAY[1..3] INTEGER : A")
        + "SUBROUTINE SUB(INTEGER : X VALUE INTEGER : Y)\nBEGIN X = X + 10 Y = 99 DEEPER(X) SUB_END\n"
        + "SUBROUTINE DEEPER(INTEGER : Z)\nINTEGER : L\nBEGIN L = Z Z = L + 1 SUB_END\n"
    )
    assert written(run(text)) == ["1210", "11"]


def test_a_sign_in_quotes_is_no_sign() -> None:
    signs = ("=", "[", ".", ":", "(", ",", "]", ";")
    assert written(run(body(" ".join(f"WRITE '{sign}'" for sign in signs)))) == list(signs)


def test_components_and_characters_are_passed_by_reference() -> None:
    names = ";;KINEMATICS : (1 = K)\n;;K.WC_NAMES = X, Y\n"
    text = body(
        "P = (1, 2) D = (3, 4) F[2] = (5, 6) T = 'ABC' N = 2\nTWICE(P.Y) TWICE(D.X) TWICE(F[N].Y) MARK(T[N])\n"
        "WRITE P.X, P.Y, D.X, F[2].Y, T\nWHOLE(P) WRITE P.X",
        "POINT : P DEF POINT : D ARRAY[1..2] POINT : F TEXT : T INTEGER : N",
    )
    twice = "SUBROUTINE TWICE(REAL : R)\nBEGIN R = R * 2 SUB_END\n"
    text += twice + "SUBROUTINE MARK(CHAR : C)\nBEGIN C = '-' SUB_END\nSUBROUTINE WHOLE(POINT : Q)\nBEGIN TWICE(Q.X) SUB_END\n"
    assert [row.split() for row in written(run(names + text))] == [["1.0", "4.0", "6.0", "12.0A-C"], ["2.0"]]
    assert [faults_of(names + body(f"TWICE({value})") + twice)[0][1] for value in ("K.VFACTOR", "VFACTOR", "POS.X")] == [6, 6, 6]
    assert short(run(names + body("TWICE(P.X)", "POINT : P") + twice), "error") == [(0.0, "error", 200)]


def test_a_subroutine_without_end_of_calls_is_a_runtime_error() -> None:
    events = run(body("SUB") + "SUBROUTINE SUB\nBEGIN SUB SUB_END\n")
    assert short(events, "error") == [(0.0, "error", 207)]


@pytest.mark.requirement("RHO-BAP-20", by="gateway.pure.languages.baps2.tasks:Task.prepared")
@pytest.mark.requirement("RHO-MOT-51", by="gateway.pure.languages.baps2.tasks:Task.prepared")
def test_normal_inputs_wait_for_the_last_two_p5_and_asynchronous_ones_do_not() -> None:
    text = body("MOVE LINEAR TO P1 B = S MOVE TO P2 B = N", "INPUT : 1 = N, 1001 = S BINARY : B")
    events = run(text, "p5_ms = 20\n[points.P]\nP1 = [1]\nP2 = [2]\n[[input]]\nchannel = 1\nat = 0.5")
    assert short(events, "in", "moved") == [
        (0.0, "in", 1001, 0),
        (1.0, "moved", 1),
        (1.96, "in", 1, 1),
        (2.0, "moved", 2),
    ]


def test_outputs_and_waits_act_where_the_block_before_ends() -> None:
    events = run(body("MOVE VIA (1,0) O = 1 MOVE TO (2,0) WAIT 0.5 O = 0", "OUTPUT : 1 = O"))
    assert short(events, "moving", "moved", "out", "end") == [
        (0.0, "moving", 1),
        (1.0, "moved", 1),
        (1.0, "out", 1, 1),
        (1.0, "moving", 2),
        (2.0, "moved", 2),
        (2.5, "out", 1, 0),
        (2.5, "end", "ended"),
    ]
    assert [event["t"] for event in events if event["event"] == "move"] == [0.0, 0.0]


def test_eleven_blocks_are_prepared_ahead_or_what_special_function_46_says() -> None:
    moves = "REPEAT 15 TIMES MOVE_REL (1,0) REPEAT_END"
    head = ";;KINEMATICS : (1=K)\n;;K.WC_NAMES = X,Y\n"
    events = run(head + body(moves))
    assert sum(event["t"] == 0.0 for event in events if event["event"] == "move") == 12
    declared = "SPC_FCT : 46 = SEARCH(VALUE INTEGER : K VALUE INTEGER : N)"
    events = run(head + body(f"SEARCH(1, 3) {moves}", declared))
    assert sum(event["t"] == 0.0 for event in events if event["event"] == "move") == 4
    assert [event["target"] for event in events if event["event"] == "move"][-1] == [15.0, 0.0]


def test_move_until_stops_on_the_path_and_runs_its_error_part_when_not_met() -> None:
    text = body("MOVE LINEAR UNTIL E = 1 ERROR WRITE 'NO' TO (10)\nWRITE 'NEXT'\nMOVE_REL LINEAR (1)", "INPUT : 1 = E")
    met = run(text, "[[input]]\nchannel = 1\nat = 0.25")
    assert short(met, "moved")[0] == (0.25, "moved", 1, True)
    assert [event["target"] for event in met if event["event"] == "move"] == [[10.0], [3.5]]
    assert written(met) == ["NEXT"]
    missed = run(text)
    assert short(missed, "moved")[0] == (1.0, "moved", 1, False)
    assert written(missed) == ["NO", "NEXT"]


def test_a_probe_needs_a_change_and_stores_the_position() -> None:
    head = ";;KINEMATICS : (1=K)\n;;K.JC_NAMES = X\n"
    text = head + body("MOVE LINEAR UNTIL PROBE = 1 TO (10) @M = @MPOS WRITE @M.X", "K.JC_POINT : @M INPUT : 610 = PROBE")
    pressed = run(text, "[[input]]\nchannel = 610")
    assert short(pressed, "moved", "error") == [(1.0, "moved", 1, False), (1.0, "error", 200)]
    events = run(text, "[[input]]\nchannel = 610\nat = 0.5")
    assert written(events) == ["     5.0"]


@pytest.mark.requirement("RHO-BAP-09", by="gateway.pure.languages.baps2.control:Control._parallel")
def test_branches_move_kinematics_at_once_and_the_program_goes_on_behind_both() -> None:
    head = ";;KINEMATICS : (1=K, 2=L)\n;;K.WC_NAMES = X\n;;L.WC_NAMES = Y\n"
    events = run(head + body("PARALLEL MOVE K TO (1) ALSO MOVE L VIA (1) MOVE L TO (2) PARALLEL_END WRITE 'BOTH'"))
    assert short(events, "moving") == [(0.0, "moving", 1), (0.0, "moving", 2), (1.0, "moving", 3)]
    assert [event["t"] for event in events if event["event"] == "write"] == [2.0]
    assert {event["process"] for event in events} == {"P"}


@pytest.mark.requirement("RHO-BAP-10", by="gateway.pure.languages.baps2.control:Control.stop_named")
def test_stop_ends_a_program_with_what_it_started_and_its_kinematic_rests() -> None:
    events = run(
        body("START A WAIT 0.5 STOP A WAIT 1 START NONE", "EXTERNAL : A"),
        A="PROGRAM A\nEXTERNAL : B\nBEGIN START B MOVE TO (10) PROGRAM_END",
        B="PROGRAM B\nBEGIN WAIT 9 PROGRAM_END",
    )
    ends = [(event["t"], event["process"], event["how"]) for event in events if event["event"] == "end"]
    assert ends == [(0.5, "B", "stopped"), (0.5, "A", "stopped"), (1.5, "P", "aborted")]
    assert short(events, "moved", "error") == [(1.5, "error", 1092)]


@pytest.mark.requirement("RHO-BAP-11", by="gateway.pure.languages.baps2.control:Control._give_up")
def test_break_gives_the_turn_to_the_others() -> None:
    other = "PROGRAM {0}\nBEGIN REPEAT 2 TIMES WRITE '{0}' BREAK REPEAT_END PROGRAM_END"
    events = run(body("START A START B REPEAT 2 TIMES WRITE 'P' BREAK REPEAT_END"), A=other.format("A"), B=other.format("B"))
    assert "".join(written(events)) == "PABPAB"


@pytest.mark.requirement("RHO-BAP-08", by="gateway.pure.languages.baps2.semaphores:Semaphores.enter")
def test_sections_of_one_semaphore_never_overlap() -> None:
    section = "EXCLUSIVE S WRITE '{0}' WAIT 1 WRITE '{0}' EXCLUSIVE_END"
    events = run(body(f"PARALLEL {section.format('A')} ALSO {section.format('B')} PARALLEL_END", "SEMAPHORE : S"))
    assert written(events) == ["A", "A", "B", "B"]


@pytest.mark.requirement("RHO-BAP-07", by="gateway.pure.languages.baps2.control:Control.shared")
def test_an_importer_sees_exported_values_and_is_warned_when_it_is_older() -> None:
    exporter = "PROGRAM A\nPUBLIC INTEGER : N\nBEGIN N = N + 5 PROGRAM_END"
    text = body("START A WAIT 0.1 WRITE N", "EXTERNAL A : N")
    assert written(run(text, A=exporter)) == ["5"]
    assert [event["event"] for event in run(text, 'compiled = ["P", "A"]', A=exporter)][:2] == ["start", "warning"]


@pytest.mark.requirement("RHO-BAP-22", by="gateway.pure.languages.baps2.outside:Outside._write")
def test_an_open_write_is_sent_with_the_next_one() -> None:
    assert written(run(body("WRITE 'A', .. WRITE 'B', 1, .. WRITE 'C'"))) == ["AB1C"]


def test_protocol_8_sends_bytes_and_a_unit_not_named_has_no_interface() -> None:
    declared = "INTEGER : I REAL : R TEXT : T"
    events = run(body("I = -2 R = 1 T = 'AB' WRITE V24_1, I, R, CHR(7) WRITE V24_1, T", declared), "[devices.V24_1]\nprotocol = 8")
    assert [event["hex"] for event in events if event["event"] == "write"] == ["feffffff0000803f07", "4142" + "00" * 78]
    assert short(run(body("WRITE V24_1, 1")), "error", "end") == [(0.0, "error", 212), (0.0, "end", "aborted")]
    text = ";;SER_IO_STOP -\n" + body("READ V24_1, I WRITE CONDITION(V24_1)", declared)
    assert written(run(text)) == ["-1"]


def test_a_block_border_inside_a_value_is_a_protocol_error() -> None:
    feed = '[devices.V24_1]\nprotocol = 8\n[[devices.V24_1.in]]\nhex = "0100"\n'
    events = run(body("READ V24_1, I", "INTEGER : I"), feed)
    assert [(event["code"], event["text"]) for event in events if event["event"] == "error"] == [(201, "Protocol error READ")]


@pytest.mark.requirement("RHO-BAP-15", "RHO-BAP-16", by="gateway.pure.languages.baps2.filing:Filing.begin_reading")
def test_binary_files_are_placed_by_bytes_and_hold_four_bytes_a_value() -> None:
    feed = '[files]\n"F.BNR" = "0100000002000000"'
    declared = "BNR_FILE : F, G INTEGER : I BINARY : B REAL : R"
    assert written(run(body("READ_BEGIN F, 4 READ F, I WRITE I", declared), feed)) == ["2"]
    last = all_of(body("WRITE_BEGIN G B = 1 R = 1 WRITE G, B, 7, R", declared), feed)[-1]
    assert last["files"] == {"F.BNR": "0100000002000000", "G.BNR": "01000000070000000000803f"}
    assert short(run(body("WRITE_BEGIN F READ_BEGIN F", declared), feed), "error") == [(0.0, "error", 1057)]


@pytest.mark.requirement("RHO-BAP-13", "RHO-BAP-14", by="gateway.pure.languages.baps2.filing:file_name")
def test_assign_takes_names_as_the_manual_allows_them() -> None:
    declared = "FILE : F TEXT : T"
    assert short(run(body("ASSIGN F, 'lower.dat'", declared)), "error") == [(0.0, "error", 202)]
    text = ";;FILE_ERROR -\n" + body("ASSIGN F, 'lower.dat' WRITE CONDITION(F), CONDITION(F)", declared)
    assert written(run(text, '[files]\n"F.DAT" = "31"')) == ["-10"]
    text = body("ASSIGN F, 'CADDATEN' WRITE F, 'X' CLOSE F ASSIGN F, 'X.' WRITE F, 'Y'", declared)
    assert all_of(text)[-1]["files"] == {"CADDATEN.DAT": "580d0a", "X.   ": "590d0a"}


@pytest.mark.requirement("RHO-BAP-18", by="gateway.pure.languages.baps2.typing:signal_place")
def test_signals_have_english_and_german_letters() -> None:
    text = body("WRITE CONDITION('I0.1'), ZUSTAND('E0.1'), CONDITION('O0.3'), STATUS('A0.3')", "OUTPUT : 3 = O")
    assert written(run(text.replace("WRITE", "O = 1 WRITE"), "[[input]]\nchannel = 1")) == ["1111"]


def test_work_pieces_move_and_turn_world_targets_and_not_joints() -> None:
    head = ";;KINEMATICS : (1=K)\n;;K.WC_NAMES = X,Y,Z\n"
    text = head + body("K.WC_SYSTEM = WC_FRAME(10,0,30,0,0,90) MOVE TO (1,0,0) WRITE ROUND(POS.X) MOVE TO @(1,0,0) WC_SYSTEM = WC_UR")
    events = run(text)
    targets = [event["target"] for event in events if event["event"] == "move"]
    assert targets[0] == pytest.approx([10, 1, 30])
    assert targets[1] == [1, 0, 0]
    assert written(events) == ["1"]


def test_halt_in_a_branch_ends_the_whole_program() -> None:
    events = run(body("PARALLEL WAIT 9 ALSO WAIT 1 HALT PARALLEL_END WRITE 'NEVER'"))
    assert short(events, "write", "end") == [(1.0, "end", "ended")]


def test_an_endless_loop_takes_time_and_ends_with_the_run() -> None:
    events = run(
        body("L: I = I + 1 IF E = 1 THEN HALT JUMP L", "INTEGER : I INPUT : 1 = E"), "until_s = 0.05\n[[input]]\nchannel = 1\nat = 0.02"
    )
    assert short(events, "end") == [(0.02, "end", "ended")]
    assert run(body("L: JUMP L"), "until_s = 0.05")[-1]["event"] == "start"


def test_a_sync_waits_for_the_belt_and_sets_its_counter() -> None:
    head = ";;KINEMATICS : (1=K)\n;;K.WC_NAMES = X, B\n"
    declared = "K.BELT : 501 = B1 SPC_FCT : 28 = SETB(VALUE INTEGER : N VALUE REAL : V)"
    events = run(head + body("SETB(1, -20) SYNC B1 >= 100 WRITE B1", declared), "belts = [100]")
    assert [(event["t"], written([event])) for event in events if event["event"] == "write"] == [(1.0, ["   -20.0"])]


@pytest.mark.requirement("RHO-BAP-17", by="gateway.pure.languages.baps2.special:Specials._delete")
def test_command_refuses_to_delete_a_file_that_is_open_even_one_that_is_new() -> None:
    declared = "SPC_FCT : 4 = CMD (VALUE INTEGER : C TEXT : S, T INTEGER : R)\nFILE : LOG, OLD\nTEXT : NAME\nINTEGER : R"
    text = "WRITE_BEGIN LOG\nREAD_BEGIN OLD\nNAME = 'LOG.DAT'\nCMD (3, NAME, NAME, R)\nWRITE PHG, R\n"
    text += "NAME = 'OLD.DAT'\nCMD (3, NAME, NAME, R)\nWRITE PHG, R\nCLOSE OLD\n"
    text += "CMD (3, NAME, NAME, R)\nWRITE PHG, R\n" * 2
    assert written(run(body(text, declared), **{"OLD.DAT": "1"})) == ["-5", "-5", "0", "-2"]


COMPILER = "SPC_FCT : 4 = CMD (VALUE INTEGER : C TEXT : S, T INTEGER : R)\nTEXT : NAME\nINTEGER : R, R2"


@pytest.mark.requirement("RHO-BAP-17", by="gateway.pure.languages.baps2.special:Specials._compile")
def test_the_compiler_serves_one_process_at_a_time_and_is_free_again_behind_it() -> None:
    text = "NAME = 'GOOD.QLL'\nPARALLEL\nCMD (1, NAME, NAME, R)\nALSO\nCMD (1, NAME, NAME, R2)\nPARALLEL_END\nWRITE PHG, R, ' ', R2\n"
    text += "CMD (1, NAME, NAME, R2)\nWRITE PHG, ' ', R2"
    events = run(body(text, COMPILER), GOOD="PROGRAM GOOD\nBEGIN\nPROGRAM_END\n")
    assert "".join(written(events)) == "0 -7 0"
    assert [event["t"] for event in events if event["event"] == "end"] == [0.02], "a P5 each"


@pytest.mark.requirement("RHO-BAP-17", by="gateway.pure.languages.baps2.special:Specials._start")
def test_command_answers_1092_for_the_start_of_a_program_that_is_not_there_and_goes_on() -> None:
    text = "NAME = 'NOWHERE'\nCMD (4, NAME, NAME, R)\nWRITE PHG, R, ' '\nNAME = 'GOOD'\nCMD (4, NAME, NAME, R)\nWRITE PHG, R"
    events = run(body(text, COMPILER), GOOD="PROGRAM GOOD\nBEGIN\nPROGRAM_END\n")
    assert "".join(written(events)) == "1092 0"
    assert not short(events, "error"), "the status reports it, no runtime error does"
    assert "GOOD" in [event["process"] for event in events if event["event"] == "start"]


@pytest.mark.requirement("RHO-BAP-17", by="gateway.pure.languages.baps2.compiling:compile_program")
def test_a_program_that_compiles_leaves_ird_or_err_with_the_faults_in_the_memory() -> None:
    text = "NAME = 'BAD.QLL'\nCMD (1, NAME, NAME, R)\nWRITE PHG, R\nNAME = 'GOOD.QLL'\nCMD (1, NAME, NAME, R)\nWRITE PHG, R"
    files = {"P.QLL": body(text, COMPILER), "BAD.QLL": "PROGRAM BAD\nBEGIN\nX = 1 Y = 2\nPROGRAM_END\n"}
    files |= {"BAD.IRD": "old", "GOOD.QLL": "PROGRAM GOOD\nBEGIN\nPROGRAM_END\n", "GOOD.ERR": "old"}
    memory = Memory({name: each.encode() for name, each in files.items()})
    machine = DryRun(Library(WORDS, memory), memory, feed_of({}))
    assert machine.run("P") is None
    assert written(list(machine.trace)) == ["2", "0"], "the sum of errors and warnings"
    assert sorted(name for name in memory.files if name.endswith((".IRD", ".ERR"))) == ["BAD.ERR", "GOOD.IRD"]
    assert str(memory.text("BAD.ERR")).startswith("BAD.QLL:3:")
    assert memory.age("GOOD") == 1


ROBOT = ";;KINEMATICS : (1 = K)\n;;K.WC_NAMES = X, Y\n"


def test_def_points_of_an_array_are_in_the_point_file_and_there_at_the_next_start() -> None:
    declared = "DEF FIELD[1..3] POINT : P\nDEF JC_POINT : @S"
    memory = Memory({"A.QLL": (ROBOT + body("P[1] = (1, 2) P[3] = P[1] P[3].X = 7", declared)).replace("PROGRAM P", "PROGRAM A").encode()})
    memory.files["B.QLL"] = (ROBOT + body("MOVE TO P[2]\nWRITE P[3].X", declared)).replace("PROGRAM P", "PROGRAM B").encode()
    memory.files["B.PKT"] = b"P [ 2 ] = (4, 5) ; taught\nP[3] = (8, 9)\n"
    for name in "AB":
        machine = DryRun(Library(WORDS, memory), memory, feed_of({}))
        assert machine.run(name) is None
    assert memory.text("A.PKT") == "P[1] = (1, 2)\nP[3] = (7, 2)\n"
    events = list(machine.trace)
    assert [event["target"] for event in events if event["event"] == "move"] == [[4.0, 5.0]] and written(events) == ["     8.0"]
    assert "P [ 2 ] = (4, 5) ; taught" in str(memory.text("B.PKT")), "what is not assigned to is as it was"


def test_point_selection_names_what_is_wrong_with_the_point() -> None:
    declared = "SPC_FCT : 16 = SEL (TEXT : F, N INTEGER : R)\nTEXT : F, N\nINTEGER : R"
    wanted = ["TEST", "1X", "P[4]", "P[2]", "NONE", "Q[1]", " "]
    text = "F = 'TEST.PKT'\n" + "".join(f"N = '{name}'\nSEL (F, N, R)\nWRITE PHG, R, ' '\n" for name in wanted)
    found = written(run(body(text, declared), **{"TEST.PKT": "P[1] = (1)\nP[2] = (2)\nTEST = (3)\n"}))
    assert "".join(found).split() == ["0", "11", "13", "0", "12", "12", "0"]


BELT_ROBOT = ";;KINEMATICS : (1 = K, 3 = L)\n;;K.WC_NAMES = X, Y\n;;L.WC_NAMES = X, Y\n;;INT = LINEAR\n"


@pytest.mark.parametrize(
    "blocks, code",
    [("MOVE L (1, 20) MOVE L (2, 30)", None), ("MOVE L (1, 20) MOVE L (2, 15)", 930), ("MOVE L (1, 20) MOVE_REL L (2, 0)", 89)],
)
def test_belt_type_2_goes_one_way_in_its_synchronous_part(blocks: str, code: int | None) -> None:
    declared = "SPC_FCT : 21 = TYPE (VALUE INTEGER : N, T)\nL.BELT : 501 = B1"
    events = run(BELT_ROBOT + body(f"TYPE(1, 2) SYNCHRON L B1 {blocks} SYNCHRON_END MOVE L (0, 0)", declared), "belts = [100]")
    assert [event["code"] for event in events if event["event"] == "error"] == ([] if code is None else [code])


def test_pos_of_a_program_that_names_no_kinematic_is_where_the_feed_starts() -> None:
    text = body("Q = POS WRITE Q MOVE TO Q", "POINT : Q")
    assert written(run(text, "[start]\n1 = [1, 2]"))[0] == "     1.0,     2.0"
    assert written(run(text, "[points.P]\nR = [4, 5, 6]"))[0] == "     0.0,     0.0,     0.0", (
        "as many components as the points that are known"
    )


def test_the_files_at_the_end_are_also_those_with_other_extensions() -> None:
    events = all_of(body('ASSIGN F, "RESULT.TXT" WRITE_BEGIN F WRITE F, 1', "FILE : F"), '[files]\n"GIVEN.X" = "41"', OTHER="; a source")
    assert events[-1]["files"] == {"GIVEN.X": "41", "RESULT.TXT": "310d0a"}


def test_a_program_with_parameters_is_an_external_subroutine() -> None:
    square = "PROGRAM SQUARE (VALUE INTEGER : A INTEGER : B)\nBEGIN\nB = A * A\nPROGRAM_END\n"
    assert written(run(body("I = 0 SQUARE(7, I) WRITE I", "EXTERNAL : SQUARE\nINTEGER : I"), SQUARE=square)) == ["49"]
    events = run(body("START SQUARE", "EXTERNAL : SQUARE"), SQUARE=square)
    assert [event["code"] for event in events if event["event"] == "error"] == [1073]


def test_a_workpiece_system_that_is_turned_by_a_right_angle_leaves_no_rest() -> None:
    declared = "K.WC_FRAME : F\nPOINT : Q"
    text = body("F = WC_FRAME(100, 0, 0, 0, 0, 90) K.WC_SYSTEM = F MOVE (10, 0, 0) Q = POS WRITE Q", declared)
    assert written(run(";;KINEMATICS : (1 = K)\n;;K.WC_NAMES = X, Y, Z\n" + text)) == ["    10.0,     0.0,     0.0"]


@pytest.mark.parametrize(
    "feed, named",
    [
        ("[[input]]\nchannel = 1\natt = 2", "att"),
        ("[devices.V24_1]\nprotokoll = 1", "protokoll"),
        ("[devices.V24_1]\n[[devices.V24_1.in]]\nhexx = '00'", "hexx"),
        ("compiled = [1]", "compiled"),
    ],
)
def test_a_misspelt_key_of_a_feed_is_refused(feed: str, named: str) -> None:
    with pytest.raises(FeedFault, match=named):
        feed_of(tomllib.loads(feed))
