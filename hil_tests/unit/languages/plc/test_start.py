"""Start, checks of the start, errors of the run, messages, test display."""

import zlib

import pytest

from gateway.pure.languages.plc.check import check_programs
from gateway.pure.languages.plc.plc import Plc, PlcState, Settings
from gateway.pure.languages.plc.translation import Translation, start_name
from hil_tests.unit.languages.plc.rig import TICK, Rig

RUN = "gateway.pure.languages.plc.translation:Translation.run"
PLC = "gateway.pure.languages.plc.plc:Plc"


@pytest.mark.requirement("RSV-PLC-28", by=RUN)
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("SU MAIN", "Nesting depth too big"),
        ("SP NOWHERE", "Branch destination not defined"),
        ("POSITION #N", "No PLC-command"),
        ("SCHR_BIT #AUSGANG, 1, 0, 1", "No PLC-command"),
        ("SU NOTHING", "Subprogram not found"),
        ("SU DIR/PART", "Subprogram not found"),
        ("U(\nU E0.0", "Incorrect parentheses"),
        (")", "Incorrect parentheses"),
        ("U(\n)", "Incorrect parentheses"),
        ("U(\nU E0.0\nSP L\n)\nM L", "Incorrect parentheses"),
        ("M L\nM l", "Multiple definition of label"),
    ],
)
def test_a_faulty_program_is_not_started(text: str, message: str) -> None:
    rig = Rig(text)
    assert rig.refused[0] == message
    assert not rig.runs


def test_a_start_program_that_is_not_there() -> None:
    assert Rig("", start="OTHER").refused == ["Start program doesn't exist"]
    assert Rig("", start="").refused == ["Start program doesn't exist"]


def levels(count: int) -> dict[str, str]:
    calls = {f"P{n}": f"PLC P{n}\nSU P{n + 1}\nEND" for n in range(count)}
    return {**calls, f"P{count}": f"PLC P{count}\nU E0.0\n= A0.0\nEND"}


def test_subprograms_nest_to_16_levels() -> None:
    assert Rig(sources=levels(16), start="P0").scan("E0.0").output("A0.0")
    assert Rig(sources=levels(17), start="P0").refused == ["Nesting depth too big"]


def test_a_chain_of_calls_of_any_length_is_a_fault_and_no_more() -> None:
    assert set(Rig(sources=levels(3000), start="P0").refused) == {"Nesting depth too big"}
    assert {fault.id for fault in Translation(levels(3000)).check_all()} == {"depth"}


def test_all_faults_are_named_at_once_with_file_and_line() -> None:
    translation = Translation({"MAIN": "PLC MAIN\n\nU E40.0\nU M1.8\nSP X\nSU P\nEND", "P": "PLC P\nL BA12CD33\nST X,T1\nR T32"})
    rows = [(fault.position.file, fault.position.line, fault.id) for fault in translation.check_all()]
    assert rows == [
        ("MAIN", 3, "operand"),
        ("MAIN", 4, "operand"),
        ("MAIN", 5, "label"),
        ("P", 2, "operand"),
        ("P", 3, "operand"),
        ("P", 4, "no-end"),
        ("P", 4, "operand"),
    ]


@pytest.mark.parametrize("head", ["PLC MAIN", "PLC 'main'", 'plc "Main" ; the first', "1 PLC MAIN"])
def test_a_head_names_its_file(head: str) -> None:
    assert not check_programs({"MAIN": f"{head}\nEND"})
    assert not check_programs({"PROJEKT1/MAIN": f"{head}\nEND"})


@pytest.mark.parametrize(("head", "named"), [("PLC OTHER", "OTHER"), ("PLC 'OTHER'", "OTHER"), ("PLC", "nothing")])
def test_a_program_under_a_foreign_head_is_a_fault_and_does_not_start(head: str, named: str) -> None:
    text = f"the head names {named}, the file MAIN"
    rows = [(fault.id, fault.position.line, fault.text) for fault in check_programs({"MAIN": f"\n{head}\nU E0.0\n= A0.0\nEND"})]
    assert rows == [("head", 2, f"step 1: {text}")]
    assert Rig(sources={"MAIN": f"{head}\nEND"}).refused == [text]


def test_a_fault_names_its_step() -> None:
    texts = 'PLC PLCMSG_CNF\n\nI 5, 9, "door"\nEND'
    found = check_programs({"A/B": "PLC B\n\n\\ U E40.0\nU E40.0\n\nSP X\nEND", "PLCMSG_CNF": texts})
    assert [fault.text.partition(":")[0] for fault in found] == ["step 3", "step 4", "step 2"]


@pytest.mark.requirement("RSV-PLC-02", by="gateway.pure.languages.plc.translation:start_name")
def test_the_start_program_is_made_of_path_and_name() -> None:
    assert start_name("S:/PLC", "MAIN            ") == "S:/PLC/MAIN"
    assert start_name("S:/PLC", "PROJEKT1/MAIN") == "S:/PLC/PROJEKT1/MAIN"
    assert start_name("S:/PLC", " " * 16) == ""
    rig = Rig(sources={"PROJEKT1/MAIN": "PLC MAIN\nSU PART\nEND", "PROJEKT1/PART": "U E0.0\n= A0.0\nEND"}, start="projekt1/main")
    assert rig.scan("E0.0").output("A0.0")


@pytest.mark.requirement("RSV-PLC-29", "RSV-PLC-30", by=PLC + ".start")
def test_the_copy_runs_until_a_start_without_faults() -> None:
    rig = Rig("U E0.0\n= A0.0")
    rig.sources["MAIN"] = "PLC MAIN\nU(\nU E0.1\nEND"
    assert rig.scan("E0.0").output("A0.0")
    assert [message.text for message in rig.plc.start("MAIN")] == ["Incorrect parentheses"]
    assert rig.scan("E0.0").output("A0.0")
    rig.sources["MAIN"] = "PLC MAIN\nU E0.1\n= A0.0\nEND"
    assert rig.plc.start("MAIN") == []
    assert (rig.scan("E0.0").output("A0.0"), rig.scan("E0.1").output("A0.0")) == (False, True)
    del rig.sources["MAIN"]
    assert rig.scan("E0.1").output("A0.0")


@pytest.mark.requirement("RSV-PLC-04", by=PLC + "._period")
def test_a_load_of_commands_a_period() -> None:
    text = "L M100\nZV ACCU,1\nT M100\n" + "U E0.0\n" * 96 + "= A0.0"
    rig = Rig(text, settings=Settings(load=20))
    seen = [rig.scan("E0.0", ticks=1).output("A0.0") for _ in range(10)]
    assert (seen, rig.plc.scans) == ([False] * 4 + [True] * 6, 2)
    assert not Rig(text, settings=Settings(load=0)).runs


@pytest.mark.parametrize("load", [1, 64, 70, 1000])
def test_a_jump_over_many_commands_executes_none_of_them_at_any_load(load: int) -> None:
    jumps, skipped = "U E0.0\n" * 69 + "SP L,1\n", "S A0.0\n" * 70
    rig = Rig(f"{jumps}{skipped}M L\n= A0.1", settings=Settings(load=load))
    assert rig.plc.watch("MAIN")
    while not rig.plc.scans:
        rig.scan("E0.0", ticks=0)
    assert (rig.output("A0.0"), rig.output("A0.1")) == (False, True)
    assert list(rig.plc.display()) == [*range(2, 72), 142, 143]


@pytest.mark.requirement("RSV-PLC-05", by=PLC + "._fail")
@pytest.mark.parametrize("load", [None, 20])
def test_an_endless_loop_stops_the_plc_the_drives_and_the_outputs(load: int | None) -> None:
    rig = Rig("U E0.0\n= A0.0\nU E0.1\nM L\nSP L,1", settings=Settings(load=load))
    rig.scan("E0.0")
    assert rig.output("A0.0")
    for _ in range(31):
        rig.scan("E0.0", "E0.1")
        if load and rig.ticks < 31:
            assert rig.runs
    assert (rig.plc.state, rig.plc.drives, rig.outputs) == (PlcState.STOP, False, bytes(40))
    (message,) = rig.plc.take_messages()
    assert (message.text, message.number, message.program) == ("PLC error 7000", 7000, "MAIN")


def test_a_scan_may_be_long_as_long_as_the_clock_allows() -> None:
    asked: list[str] = []

    def more(routine: str, line: int) -> int:
        asked.append(f"{routine} {line}")
        return 1_000_000

    text = "L 0\nTD M4\nM L\nLD M4\nZV ACCU,1\nTD M4\nL 60000\n<\nSP L,1"
    rig = Rig(text, settings=Settings(more=more)).scan()
    assert (rig.runs, rig.plc.number(4), asked) == (True, 60000, ["MAIN 10"])
    assert not Rig(text).scan().runs


def test_a_killed_plc_comes_back_with_the_copy_that_ran() -> None:
    rig = Rig("U E0.0\n= A0.0")
    copy = rig.plc.copy()
    again = Plc({}, Settings(load=1))
    assert again.start_copy(copy) == []
    assert [again.scan(at, bytes([1]) + bytes(39))[0] for at in range(3)] == [0, 1, 1]
    assert [message.text for message in again.start_copy(copy[:-1] + b" ")] == ["PLC error 7004"]
    assert (again.state, again.drives, again.outputs) == (PlcState.STOP, False, bytes(40))
    with pytest.raises(ValueError, match="no PLC program"):
        Plc({}).copy()


def test_a_copy_with_an_unknown_function_code_is_error_7003() -> None:
    data = Rig("U E0.0\n= A0.0").plc.copy()[4:].replace(b'"assign"', b'"nosuch"')
    assert [message.number for message in Plc({}).start_copy(zlib.crc32(data).to_bytes(4, "little") + data)] == [7003]


def test_an_overload_is_system_error_1052() -> None:
    rig = Rig("U E0.0\n= A0.0").scan("E0.0")
    rig.plc.overload()
    assert (rig.plc.take_messages()[0].text, rig.runs, rig.plc.drives, rig.plc.outputs) == ("System error 1052", False, False, bytes(40))


TEXTS = """PLC PLCMSG_CNF
I 5, 0, "text \\d"
I 6, 3, "gripper\\n\\h \\b"
I 7, 7, "drives off"
I 8 259 "with drives only"
END"""


def messenger() -> Rig:
    sources = {"MAIN": "PLC MAIN\nUN E0.0\nSP N,1\nLD M40\nTD M948\nM N\nU E0.1\n= A0.0\nEND", "PLCMSG_CNF": TEXTS}
    return Rig(sources=sources)


def ordered(rig: Rig, order: int, *parameters: int) -> list[tuple[str, int | None, str]]:
    rig.plc.set_number(40, order)
    for at, value in enumerate(parameters):
        rig.plc.set_number(952 + 4 * at, value)
    rig.scan("E0.0")
    assert rig.plc.number(948) == 0
    return [(message.text, message.number, message.kind) for message in rig.plc.take_messages()]


@pytest.mark.requirement("RSV-PLC-32", by=PLC + "._end_of_scan")
def test_clear_text_and_standard_messages() -> None:
    rig = messenger()
    assert ordered(rig, 0x80000005, 7) == [("text 7", 5, "message")]
    assert not rig.plc.bit(1021, 1)
    rig.plc.acknowledge()
    assert rig.plc.bit(1021, 1)
    assert ordered(rig, 42) == [("PLC error 42", 42, "error")]
    assert (rig.plc.bit(1021, 0), rig.plc.number(944)) == (True, 42)
    assert ordered(rig, 42) == []  # it is there already
    assert ordered(rig, 0x80000006, -1, 5) == [("gripper\nFFFFFFFF 101", 6, "error")]


@pytest.mark.requirement("RSV-PLC-33", by="gateway.pure.languages.plc.messages:ordered")
def test_reactions() -> None:
    rig = messenger()
    ordered(rig, 0x80000006)
    assert rig.plc.drives
    assert ordered(rig, 0x80000008) == [("with drives only", 8, "error")]
    ordered(rig, 0x80000007)
    assert not rig.plc.drives
    assert ordered(rig, 0x80000008) == []
    assert rig.runs  # a message stops the robot, not the PLC


@pytest.mark.parametrize(
    "line",
    ['I 5, 1, "x"', "I 5, 0, x", f'I 5, 0, "{"x" * 257}"', 'I 5, 0, "\\d\\d\\d\\d\\h"', 'I 5, 0, "a"\nI 5, 0, "b"', "U E0.0"],
)
def test_faulty_texts_refuse_the_start(line: str) -> None:
    rig = Rig(sources={"MAIN": "PLC MAIN\nEND", "PLCMSG_CNF": f"PLC PLCMSG_CNF\n{line}\nEND"})
    assert len(rig.refused) == 1


@pytest.mark.requirement("RSV-PLC-39", by=PLC + ".display")
def test_the_test_display_shows_what_ran_as_long_as_source_and_copy_agree() -> None:
    rig = Rig("U E0.0\nSP L,1\nL 5\nL 6\nM L\nU E0.0\n= A0.0")
    assert rig.plc.watch("MAIN")
    assert rig.plc.bit(1021, 6)
    rig.scan()
    shown = rig.plc.display()
    assert [(step, row.status, row.result, row.accu1, row.accu2) for step, row in shown.items()][3:5] == [
        (5, False, False, 6, 5),
        (6, False, False, 6, 5),
    ]
    assert sorted(rig.scan("E0.0").plc.display()) == [2, 3, 6, 7, 8]
    rig.sources["MAIN"] += "\n"
    assert (rig.plc.display(), rig.plc.bit(1021, 6)) == ({}, False)
    assert not rig.plc.watch("MAIN")
    rig.plc.start("MAIN")
    assert rig.plc.watch("MAIN")


@pytest.mark.requirement("RSV-PLC-01", by=PLC + ".scan")
def test_the_plc_cycles_and_says_which_outputs_it_wrote() -> None:
    rig = Rig("UN M10.0\n= M10.0\nU E0.0\nS A1.0\n= A2.3")
    assert [rig.scan().plc.bit(10, 0) for _ in range(4)] == [True, False, True, False]
    assert (rig.plc.outputs_written[1], rig.plc.outputs_written[2]) == (0, 8)
    assert rig.scan("E0.0").plc.outputs_written[1] == 1
    assert len(rig.scan().outputs) == 40
    with pytest.raises(ValueError, match="40"):
        rig.plc.scan(TICK, b"")


@pytest.mark.parametrize(
    ("text", "step", "message", "hint"),
    [
        ("SP NO,1\nU E0.0\nSP NO", 2, "Branch destination not defined", "there is no M NO; also at step 4"),
        ("SU NO,1\nU E0.0\nSU NO\nSU NO", 2, "Subprogram not found", "NO is not in the directory; also at steps 4, 5"),
        ("U E0.0\nSP L,1\nM L ; further on", 4, "A comment cannot follow M", ""),
        ("U( E0.0\nO E0.1\n)\n= A0.0", 2, "U( E0.0: wrong operand", "U( is a step of its own"),
        ("UN(\nO E0.1\n)\n= A0.0", 2, "UN(: wrong operand", "brackets are opened by U(, O( and XO("),
        ("ST (E,T1)\n= A0.0", 2, "ST (E,T1): wrong operand", "ST I,T5 with the timer type I, V, E or A"),
        ("SP ENDE1,1\nM ENDEL", 2, "Branch destination not defined", "there is no M ENDE1; did you mean ENDEL?"),
        ("SU LMAPE", 2, "Subprogram not found", "LMAPE is not in the directory; did you mean LAMPE?"),
        ("U E0.0\nEND\n= A0.0\nU E0.1", 4, "'= A0.0' after END", "END is the last step; also at steps 5, 6"),
        ("L E0\nL 5\n==\n= A0.0", 4, "= =: wrong operand", "here it is =?"),
        ("= A0.0\nEDN", 3, "END is missing", ""),
    ],
)
def test_one_mistake_is_one_fault(text: str, step: int, message: str, hint: str) -> None:
    (fault,) = check_programs({"MAIN": f"PLC MAIN\n{text}" if "EDN" in text else f"PLC MAIN\n{text}\nEND", "LAMPE": "PLC LAMPE\nEND"})
    assert (fault.text, fault.position.line) == (f"step {step}: {message}", step)
    assert fault.hint.endswith(hint)
