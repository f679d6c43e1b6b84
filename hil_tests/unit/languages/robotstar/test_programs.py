"""Types of programs, calls, modes, START and STOP: the program rows of the requirements."""

import pytest

from hil_tests.unit.languages.robotstar.memory import checked, run

V = {"V.MPR": "VAR I1\nVAR I2\nVAR S_PROG(20)"}
AT = "POSITION #N, X:{}, Y:0, Z:0, A:0, B:0, C:0"
MOVES = f"TOOL T\nMOVE_MODE #LINEAR\nPATH_SPEED 100\nPATH_ACCEL 100\n{AT.format(100)}\n{AT.format(200)}\nCOPY 1,I1"


@pytest.mark.requirement("RSV-PRG-01", by="gateway.pure.languages.robotstar.machine:Machine.end")
def test_a_main_program_repeats_in_auto() -> None:
    files = {"P.MPR": "CALL S\nADD 1,I1", "S.SPR": "ADD 1,I2", "Q.MPR": "COPY 0,I1\nCOPY 0,I2\nPROGRAM P", **V}
    ran = run(files, "Q", mode="auto", until=1)
    assert ran.state == "running" and isinstance(count := ran.value("I1"), int) and count > 25
    assert ran.value("I2") in (count, count + 1), "the sub-program returns each time"


@pytest.mark.requirement("RSV-PRG-02", by="gateway.pure.languages.robotstar.machine:Machine.end")
def test_a_main_program_ends_in_a_sequential_test() -> None:
    ran = run({"P.MPR": "COPY 1,I1", **V}, until=5)
    assert (ran.state, ran.step, ran.value("I1")) == ("stopped", 1, 1)


@pytest.mark.requirement("RSV-PRG-03", by="gateway.pure.languages.robotstar.machine:Machine.end")
def test_a_sub_program_returns() -> None:
    assert run({"P.MPR": 'U_PROG Name: "S1"\nCOPY 1,I1', "S1.SPR": "COPY 2,I2", **V}, until=1).value("I1") == 1


@pytest.mark.requirement("RSV-PRG-04", by="gateway.pure.languages.robotstar.machine:Machine.end")
def test_a_sub_program_without_a_caller_cannot_return() -> None:
    ran = run({"S1.SPR": "COPY 2,I2", **V}, "S1", mode="auto", until=1)
    assert ran.texts()
    message = ran.message()
    assert [message[key] for key in ("number", "text", "program", "step", "class")] == [
        4017,
        "Operating error 4017",
        "S1",
        3,
        "operating",
    ]
    assert ran.state == "error" and ran.value("I2") == 2


@pytest.mark.requirement("RSV-PRG-05", by="gateway.pure.languages.robotstar.machine:Machine.call")
@pytest.mark.parametrize("kind", ["SPR", "MAC"])
def test_calls_nest_twelve_deep(kind: str) -> None:
    def chain(depth: int) -> dict[str, str]:
        call = "CALL N{}" if kind == "SPR" else "N{}"
        files = {f"N{n}.{kind}": call.format(n + 1) for n in range(1, depth)} | {f"N{depth}.{kind}": "COPY 1,I1"}
        return {"P.MPR": call.format(1), **files, **V}

    assert run(chain(12), until=1).value("I1") == 1
    ran = run(chain(13), until=1)
    assert (ran.state, ran.end["program"], ran.value("I1")) == ("error", "N12", None) and "nesting depth" in str(ran.texts()[0])


def test_inputs_given_at_0_are_there_as_the_program_begins() -> None:
    text = 'TEST_BIT #EINGANG,#=0,0,6,"L"\nCOPY 1,I1\nLABEL "L"\nSTOP'
    assert run({"P.MPR": text, **V}, mode="auto", at=("0 E0.6=1",)).value("I1") == 1
    assert run({"P.MPR": text, **V}, mode="auto", at=("0.1 E0.6=1",)).value("I1") is None


@pytest.mark.requirement("RSV-PRG-06", by="gateway.pure.languages.robotstar.checker:_position")
def test_a_macro_has_no_positions() -> None:
    _, faults = checked({"M1.MAC": AT.format(1), "M2.MAC": "COPY 1,I1", **V})
    assert [(fault.position.file, fault.text) for fault in faults] == [("M1.MAC", "step 2: POSITION: a macro contains no positions")]


@pytest.mark.requirement("RSV-PRG-07", by="gateway.pure.languages.robotstar.machine:Machine.switch")
def test_program_goes_to_another_main_program() -> None:
    ran = run({"P.MPR": 'PROGRAM "B"\nCOPY 1,I2', "B.MPR": "COPY 1,I1\nSTOP", **V}, until=1)
    assert (ran.end["program"], ran.value("I1"), ran.value("I2")) == ("B", 1, None)


@pytest.mark.requirement("RSV-PRG-08", by="gateway.pure.languages.robotstar.machine:Machine.switch")
@pytest.mark.parametrize("name, said", [("X", "program X not found"), ("S1", "program S1 is not a main program")])
def test_program_needs_a_main_program(name: str, said: str) -> None:
    ran = run({"P.MPR": f'COPY 1,I1\nPROGRAM "{name}"', "S1.SPR": "COPY 1,I2", **V}, until=1)
    assert (ran.texts(), ran.state, ran.step, ran.value("I1")) == ([said], "error", 3, 1)


def test_program_in_a_sub_program_is_found_before_the_start() -> None:
    _, faults = checked({"P.MPR": "CALL S1", "S1.SPR": "PROGRAM P", **V})
    assert [(fault.position.file, fault.text) for fault in faults] == [("S1.SPR", "step 2: PROGRAM is allowed in a main program only")]


def test_a_macro_is_not_named_like_a_command() -> None:
    _, faults = checked({"WARTE.MAC": "WAIT 1", "WARTEN.MAC": "WAIT 1"})
    assert [fault.text for fault in faults] == ["step 1: WARTE is a command of the control: a macro of this name is never called"]


@pytest.mark.requirement("RSV-PRG-09", by="gateway.pure.languages.robotstar.access:text")
def test_indirect_calls() -> None:
    files = {"3344.SPR": "COPY 3,I1", "S_PROG.SPR": "COPY 4,I1", **V}
    assert run({"P.MPR": 'KOPIERE Quelle: "3344", Ziel_Var: S_PROG\nCALL Name: S_PROG', **files}).value("I1") == 3
    assert run({"P.MPR": 'KOPIERE Quelle: "3344", Ziel_Var: S_PROG\nCALL Name: "S_PROG"', **files}).value("I1") == 4


@pytest.mark.requirement("RSV-PRG-10", by="gateway.pure.languages.robotstar.reader:_step")
def test_an_invalid_step_is_skipped() -> None:
    text = "\\COPY 5,I1\n\\ NONSENSE here\nCOPY 1,I2\n\\COPY 5,I1\nADD 1,I2\nADD 1,I2\nSTOP"
    ran = run({"P.MPR": text, **V}, mode="auto", until=0.005)
    assert (ran.value("I1"), ran.value("I2"), ran.faults, ran.step) == (None, 3, [], 9)


@pytest.mark.requirement("RSV-PRG-11", by="gateway.pure.languages.robotstar.reader:_definitions_first")
def test_definitions_are_at_the_beginning() -> None:
    _, faults = checked({"P.MPR": f"TOOL T\n{AT.format(1)}\nVAR I1", "Q.MPR": "C text\nVAR I2"})
    assert [fault.text for fault in faults] == ["step 4: definitions belong at the beginning, before step 2"]


WAITS = "WAIT_BIT #EINGANG, Pegel: 1, Byte: 0, Bit_Nr: 5, Max_Zeit: 0.0, Marke: X\nCOPY 1,I1"
STARTS = tuple(f"0.{n} START" for n in range(1, 6))


@pytest.mark.requirement("RSV-PRG-12", by="gateway.pure.languages.robotstar.robot:Robot.key")
def test_test_1_simulates_inputs() -> None:
    assert run({"P.MPR": WAITS, **V}, mode="test1", at=(*STARTS, "0.7 E0.5=1"), until=9).state == "waiting"
    ran = run({"P.MPR": WAITS, **V}, mode="test1", at=(*STARTS, "1 F1", "2 F2", "3 START"))
    assert ran.value("I1") == 1
    text = "TEST_BIT #EINGANG, #=1, 0, 0, X\nCOPY 1,I1\nLABEL X\nCOPY 1,I2"
    assert run({"P.MPR": text, **V}, mode="test4", at=("1 F2",)).value("I1") is None
    assert run({"P.MPR": text, **V}, mode="test4", at=("1 F1",)).value("I1") == 1


@pytest.mark.requirement("RSV-PRG-13", by="gateway.pure.languages.robotstar.control_steps:write_bit")
def test_outputs_are_not_switched_in_simulation() -> None:
    text = "WRITE_BIT #AUSGANG,1,0,3\nCOPY 255,_IBIN_OUT[2]\nWRITE_BIT #MERKER,1,20,0\nWRITE_BIT #MERKER,1,2016,0\nCOPY 1,_SPS[506]"
    ran = run({"P.MPR": text}, mode="test4")
    assert not any(ran.when(byte) for byte in ("A0", "A4", "A8", "A12")) and ran.when("M20"), "by their markers neither"
    ran = run({"P.MPR": text}, mode="test2")
    assert ran.when("A0") == [(0.0, 8)] and ran.when("A4") == [(0.0, 255)]
    assert ran.when("A8") == ran.when("A12") == [(0.0, 1)]


@pytest.mark.requirement("RSV-PRG-14", by="gateway.pure.languages.robotstar.robot:Robot._step_done")
def test_each_single_step_needs_start() -> None:
    files = {"P.MPR": "COPY 1,I1\nCOPY 2,I1\nCOPY 3,I1", **V}
    assert run(files, mode="test3").end["step"] == 2
    ran = run(files, mode="test3", at=("1 START", "2 START"))
    assert (ran.step, ran.value("I1"), ran.state) == (4, 2, "stopped")


@pytest.mark.requirement("RSV-PRG-15", by="gateway.pure.languages.robotstar.robot:Robot.stop")
def test_a_position_step_stops_where_it_is() -> None:
    ran = run({"P.MPR": MOVES, **V}, mode="test3", at=(*STARTS, "1 STOP"))
    assert not ran.targets() and 0 < ran.cell.actual().pose[0] < 100


@pytest.mark.requirement("RSV-PRG-16", by="gateway.pure.languages.robotstar.steps:_guarded")
def test_the_executer_refuses_what_moves_or_waits() -> None:
    for text in (WAITS.splitlines()[0], AT.format(1), "PTP_SPEED 10"):
        ran = run({"P.MPR": f"TOOL T\n{text}", **V}, mode="test5", at=("1 START", "2 START"))
        assert "is not executable in Test 5" in str(ran.texts()[0]) and (ran.state, ran.step) == ("stopped", 3)
    ran = run({"P.MPR": "COPY 1,I1", **V}, mode="test5", at=("1 START", "2 START", "3 START"))
    assert (ran.value("I1"), ran.step, ran.texts()) == (1, 3, [])


def test_the_executer_waits() -> None:
    """WAIT is effective in all test modes (L658)."""
    ran = run({"P.MPR": "WAIT 0.5\nWRITE_BIT #MERKER, 1, 1, 0", **V}, mode="test5", at=("1 EXEC", "2 EXEC"), until=1.4)
    assert (ran.texts(), ran.state) == ([], "waiting")
    ran = run({"P.MPR": "WAIT 0.5\nWRITE_BIT #MERKER, 1, 1, 0", **V}, mode="test5", at=("1 EXEC", "2 EXEC"))
    assert ran.when("M1") == [(2.0, 1)]


@pytest.mark.requirement("RSV-PRG-17", by="gateway.pure.languages.robotstar.robot:Robot._steps")
def test_macros_are_one_step_or_stepped_into() -> None:
    files = {"P.MPR": "GREIFE\nCOPY 2,I2", "GREIFE.MAC": "COPY 1,I1\nCOPY 1,I2", **V}
    ran = run(files, mode="test1", at=("1 START",))
    assert (ran.end["program"], ran.step, ran.value("I1"), ran.value("I2")) == ("P", 3, 1, 1)
    ran = run(files, mode="test6", at=("1 START",))
    assert (ran.end["program"], ran.step, ran.value("I1")) == ("GREIFE", 1, None)


@pytest.mark.requirement("RSV-PRG-18", by="gateway.pure.languages.robotstar.robot:Robot.start")
def test_a_stopped_program_goes_on_where_it_was() -> None:
    ran = run({"P.MPR": MOVES + "\nSTOP", **V}, mode="auto", at=("0.5 STOP", "10 START"))
    first = ran.cell.events[0]["at"]
    assert ran.targets() == [(100, 0, 0), (200, 0, 0)] and ran.value("I1") == 1
    assert first == pytest.approx(10 + 1 + 0.05 - 0.5, abs=1e-6)  # 100 mm at 100 mm/s, 2000 mm/s2
    ran = run({"P.MPR": MOVES + "\nSTOP", "Q.MPR": "COPY 1,I2\nSTOP", **V}, mode="auto", at=("0.5 STOP", "10 START Q"))
    assert not ran.targets() and ran.value("I2") == 1


def test_the_time_of_a_wait_goes_on_after_a_stop() -> None:
    ran = run({"P.MPR": "WAIT 2.0\nWRITE_BIT #AUSGANG,1,0,0\nSTOP"}, mode="auto", at=("0.5 STOP", "10 START"))
    assert ran.when("A0") == [(11.5, 1)]


@pytest.mark.requirement("RSV-PRG-20", by="gateway.pure.languages.robotstar.memory:Memory._take")
def test_directories_nest_six_deep() -> None:
    def faults(depth: int) -> list[str]:
        path = "/".join(f"D{n}" for n in range(depth))
        return [fault.id for fault in checked({f"{path}/P.MPR": "COPY 1,_SPS[1]"})[1]]

    assert faults(6) == [] and faults(7) == ["rsv.depth"]


def test_an_error_needs_an_acknowledgement() -> None:
    files = {"P.MPR": "COPY I1,I2\nSTOP", "Q.MPR": "COPY 1,I1\nSTOP", **V}
    ran = run(files, at=("1 START", "2 ACK", "3 START Q", "4 START P"))
    assert ran.texts() == ["Variable not initialized!", "START is refused: the error is not acknowledged; ACK acknowledges it"]
    assert (ran.state, ran.value("I2"), ran.step) == ("stopped", 1, 4)


def test_drives_and_power() -> None:
    files = {"P.MPR": "COPY 1,I1\nWRITE_BIT #AUSGANG,1,0,0\nWAIT 100", **V}
    ran = run(files, until=9, at=("1 DRIVES OFF", "2 START", "3 POWER", "4 START"))
    assert ran.texts() == ["START is refused: the drives are off"] and ran.when("drives") == [(1.0, "OFF")]
    assert ran.when("A0") == [(0.0, 1), (3.0, 0), (4.0, 1)] and (ran.state, ran.value("I1")) == ("waiting", 1)


def test_a_start_that_is_refused_is_a_message() -> None:
    for files, said in (({"P.MPR": "NONSENSE"}, "neither a command nor a macro"), ({"Q.MPR": "STOP"}, "program P not found")):
        ran = run(files)
        assert said in str(ran.texts()[0]) and ran.message()["at"] == 0.0 and ran.state == "error"


def test_markers_start_and_stop() -> None:
    files = {"P.MPR": "WAIT 2\nWRITE_BIT #AUSGANG,1,0,0\nSTOP"}
    ran = run(files, mode="auto", at=("1 M968.2=1", "4 M968.2=0", "5 M968.1=1"))
    assert ran.when("A0") == [(6.0, 1)]


def test_hold_by_marker_stops_the_way_but_not_the_program() -> None:
    ran = run({"P.MPR": MOVES + "\nSTOP", **V}, mode="auto", at=("0.5 M1020.7=1", "3 M1020.7=0"))
    assert ran.cell.events[-1]["at"] == pytest.approx(2.1 + 2.5) and ran.targets() == [(100, 0, 0), (200, 0, 0)]


def test_the_same_input_gives_the_same_events() -> None:
    files = {"P.MPR": MOVES, **V}
    assert run(files, mode="auto", until=20).cell.events == run(files, mode="auto", until=20).cell.events


@pytest.mark.parametrize("last, count", [("POSITION", 3), ("MOVE_MODE #PTP", 1)])
def test_a_circle_needs_an_even_number_of_positions(last: str, count: int) -> None:
    del last
    body = (
        "TOOL T\nMOVE_MODE #ZIRK_BAHN_ORI\n"
        + "\n".join(f"POSITION #N, X:{100 * n}, Y:{n * n}, Z:0, A:0, B:0, C:0" for n in range(1, count + 1))
        + "\nMOVE_MODE #PTP"
    )
    assert "an even number of positions" in str(run({"P.MPR": body}).texts()[0])


TURNED = AT.format(1).replace("A:0", "A:30")


@pytest.mark.parametrize(
    "body, number",
    [
        (f"COPY 50,_IORI_WEIGHT\n{AT.format(1)}\nCOPY 50,_IORI_WEIGHT\n{AT.format(2)}", 903),
        ("POSITION #N, X:0, Y:0, Z:0, A:30, B:0, C:0", 622),
        (f"UEBERSCHL #EIN\n{AT.format(1)}\nUEBERSCHL #AUS\n{TURNED}", 625),
        (f"UEBERSCHL #EIN\n{AT.format(1)}\nUEBERSCHL #AUS\nBAHN_ZEIT 1.0\n{TURNED}", 624),
        (f"UEBERSCHL #EIN\n{AT.format(1)}\nUEBERSCHL #AUS\n{AT.format(1)}", 623),
        (f"UEBERSCHL #EIN\nBAHN_ZEIT 1.0\n{TURNED.replace('X:1', 'X:0')}", 621),
        (f"UEBERSCHL #EIN\nBAHN_RADIUS 0\n{AT.format(1)}", 102),
        (f"UEBERSCHL #EIN\n{AT.format(0)}", 620),
    ],
)
def test_path_errors(body: str, number: int) -> None:
    ran = run({"P.MPR": f"TOOL T\nMOVE_MODE #LINEAR\n{body}"}, mode="auto", until=30)
    assert (ran.message()["number"], ran.message()["class"], ran.state) == (number, "path", "error")


@pytest.mark.requirement("RSV-MOT-22", by="gateway.pure.languages.robotstar.motion_steps:relative")
@pytest.mark.requirement("RSV-MOT-23", by="gateway.pure.languages.robotstar.motion_steps:_give_relation")
def test_displacement() -> None:
    text = f"TOOL T\n{AT.format(10)}\nCALC_REL V1\n{AT.format(4)}\n{AT.format(7)}"
    text += f"\nRELATIVE V1\n{AT.format(7)}\nRELATIVE Vector: _VNULL\n{AT.format(9)}"
    ran = run({"P.MPR": text, "V.MPR": "VAR V1"})
    assert [target[0] for target in ran.targets()] == [10, 7, 13, 9]


def test_relative_adds_the_vector_to_each_position_anew_until_vnull() -> None:
    text = f"TOOL T\nRELATIVE V1\n{AT.format(100)}\n{AT.format(100)}\nRELATIVE V2\n{AT.format(100)}\nRELATIVE _VNULL\n{AT.format(100)}"
    values = "VAR V1, X:10, Y:0, Z:0, A:0, B:0, C:0\nVAR V2, X:0, Y:5, Z:0, A:0, B:0, C:90"
    ran = run({"P.MPR": text, "V.MPR": values})
    assert ran.targets() == [(110, 0, 0), (110, 0, 0), (100, 5, 0), (100, 0, 0)]
    refused = run({"P.MPR": "TOOL T\nRELATIVE V1", "V.MPR": "VAR V1"})
    assert refused.texts() == ["Variable not initialized!"]


def test_calc_rel_gives_actual_minus_programmed_and_the_robot_stays() -> None:
    place = "POSITION #N, X:{}, Y:{}, Z:{}, A:0, B:0, C:0"
    text = f"TOOL T\n{place.format(10, 20, 30)}\nCALC_REL V1\n{place.format(1, 2, 3)}\nSTOP"
    ran = run({"P.MPR": text, "V.MPR": "VAR V1"})
    assert ran.targets() == [(10, 20, 30)]
    assert [ran.value(f"V1.{name}") for name in ("X", "Y", "Z")] == [9, 18, 27]
    framed = run({"P.MPR": text.replace("Z:3,", "Z:3, Frame:2,"), "V.MPR": "VAR V1"})
    assert "frame" in str(framed.texts()[0])


@pytest.mark.requirement("RSV-MOT-19", by="gateway.pure.languages.robotstar.system:System.names")
def test_l2043_the_table_of_defaults_as_a_program_reads_and_changes_it() -> None:
    table = {
        "_IDEF_MOVMOD": 0, "_IDEF_FLYFLG": 0, "_RDEF_VEL_CP": 10.0, "_IDEF_ACC_CP": 50, "_IDEF_VELPTP": 20, "_IDEF_ACCPTP": 50,
        "_RDEF_PATH_R": 1.0, "_RDEF_PATH_D": 0.0, "_RDEF_PATH_T": 0.0, "_IDEF_VFLY_S": 100, "_IDEF_VFLY_O": 0, "_IDEF_VCRC_O": 100,
        "_IDEF_SPLTEN": 100, "_IDEF_ORITEN": 100, "_IDEF_ORIWGT": 100, "_IDEF_ORICRC": 100, "_IDEF_ACCTIM": 25,
    }  # fmt: skip
    plain = {"_IV_FLYBY_S": 100, "_IV_FLYBY_O": 0, "_IV_CIRCHP_O": 100, "_ISPL_TENS": 100, "_IORI_TENS": 100, "_IACC_TIME": 25}
    copies = "\n".join(f"COPY {name}, {name[1]}_V[{place}]" for place, name in enumerate((*table, *plain), 1))
    ran = run({"P.MPR": copies, "V.MPR": "VAR I_V[30]\nVAR R_V[30]"})
    found = [ran.value(f"{name[1]}_V[{place}]") for place, name in enumerate((*table, *plain), 1)]
    assert found == [*table.values(), *plain.values()]
    places = "\n".join(f"{AT.format(x)}" for x in (10, 20))
    slow = run({"P.MPR": f"TOOL T\nMOVE_MODE #LINEAR\n{places}"})
    first, second = (float(str(at)) for at, _ in slow.when("target"))
    assert second - first == pytest.approx(1.0, abs=0.02), "BAHN_GESCHW 10 mm/s where the program names none"


@pytest.mark.requirement("RSV-IO-06", by="gateway.pure.languages.robotstar.control_steps:analog_output")
def test_an_analog_output_takes_10_volts_and_no_more() -> None:
    ran = run({"P.MPR": "ANA_OUTP 5.0,1\nANA_OUTP -10.0,24\nCOPY 10.5,R1\nANA_OUTP R1,1\nANA_OUTP 1.0,2", "V.MPR": "VAR R1"})
    outputs = [int.from_bytes(ran.cell.image[place : place + 2], "little", signed=True) for place in range(1920, 1968, 2)]
    assert outputs == [16384, *[0] * 22, -32767]
    assert ran.texts() == ["voltage 10.5 is outside -10 .. 10"] and ran.step == 5
    assert run({"P.MPR": "ANA_OUTP 10.5,1"}).faults == ["step 2: ANA_OUTP: voltage 10.5 is outside -10 .. 10"]


def test_position_variables() -> None:
    text = f"TOOL T\n{AT.format(10)}\nACT_POS P1\nCOPY 30,P1.X\nCOPY P1,P_A[2]\nVAR_POS P_A[2]\nVAR_POS P1"
    ran = run({"P.MPR": text, "V.MPR": "VAR P1\nVAR P_A[2]"})
    assert [target[0] for target in ran.targets()] == [10, 30, 30]
    assert run({"P.MPR": "TOOL T\nVAR_POS P1", "V.MPR": "VAR P1"}).texts() == ["Variable not initialized!"]


HOME = "TOOL T\nPOSITION #N, X:100, Y:0, Z:0, A:0, B:0, C:0"


@pytest.mark.parametrize(
    "more", ["", '\nPROGRAM "Q"', "\nLABEL A\nPOSITION #N, X:100, Y:0, Z:0, A:0, B:0, C:0\nTEST_BIT #EINGANG, #=0, 0, 0, A"]
)
def test_a_position_that_the_robot_is_at_comes_once_a_cycle_at_most(more: str) -> None:
    """In rounds of AUTO, in programs that go to one another, in a loop: not hundreds of times at one moment."""
    ran = run({"P.MPR": HOME + more, "Q.MPR": 'PROGRAM "P"'}, mode="auto", until=2.0)
    times = [at for at, _ in ran.when("target")]
    assert len(times) > 50
    assert max(times.count(at) for at in set(times)) <= 3, "in front of the loop, and two passes that show that it changes nothing"


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("", ["Variable not initialized!"]),
        ("COPY 100.0, T1.Z", []),
        ("COPY 1.0, T1.RX", []),
        ("COPY_OFFSETS 1, 100.0, 12, T1, 1", []),
        ("COPY 100.0, T1.Z\nCOPY T1.X, R1", ["Variable not initialized!"]),
    ],
)
def test_a_tool_counts_as_written_once_an_element_is(written: str, said: list[str]) -> None:
    """The manual's own example writes the hand length alone (L858)."""
    ran = run({"P.MPR": f"{written}\nTOOL T1\nPOSITION #N, X:1, Y:0, Z:0, A:0, B:0, C:0", "V.MPR": "VAR T1\nVAR R1"})
    assert ran.texts() == said
    assert len(ran.targets()) == (not said)
