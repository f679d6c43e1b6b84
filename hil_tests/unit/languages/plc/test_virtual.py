"""`axisgate plc` as a user calls it: check, run in virtual time, import."""

import json
import pathlib

import pytest

from gateway.commands.plc import main

TEXTS = 'PLC PLCMSG_CNF\nI 5, 0, "text \\d"\nI 7, 7, "no air"\nEND\n'
MAIN = """PLC MAIN
U E0.6
= A5.1
U M20.0
SP N,0
L 80000005H
TD M948
L 9
TD M952
R M20.0
M N
L M1874
T M30
U E0.7
M LOOP
SP LOOP,1
END
"""


@pytest.fixture
def folder(tmp_path: pathlib.Path) -> pathlib.Path:
    (tmp_path / "main.plc").write_text(MAIN)
    (tmp_path / "PLCMSG_CNF.PLC").write_text(TEXTS)
    (tmp_path / "SUB").mkdir()
    (tmp_path / "SUB" / "BAD.PLC").write_text("PLC BAD\nU(\nU E40.0\nSU MAIN\nEND\n")
    return tmp_path


def ran(folder: pathlib.Path, capsys: pytest.CaptureFixture[str], *options: str, start: str = "MAIN") -> tuple[int, dict[str, object]]:
    code = main(["run", str(folder), "--start", start, "--virtual", "--json", *options])
    return code, json.loads(capsys.readouterr().out)


RUN = "gateway.pure.languages.plc.virtual:VirtualRun.run"


@pytest.mark.requirement("RSV-PLC-32", by=RUN)
def test_events_of_orders_in_virtual_time(folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    orders = ["--at", "3 E0.6=1", "--at", "5 M20=1", "--at", "7 E0.6=0 EA2=10", "--at", "8 DRIVES OFF", "--at", "9 ACK"]
    code, found = ran(folder, capsys, "--scans", "12", *orders)
    events = found["events"]
    assert isinstance(events, list)
    assert code == 0
    assert events[0] == {"at": 0, "what": "state", "value": "RUN"}
    assert {"at": 3, "what": "A5", "value": 2} in events
    assert {"at": 7, "what": "A5", "value": 0} in events
    assert {"at": 7, "what": "M30", "value": 255} in events
    assert {"at": 8, "what": "drives", "value": "OFF"} in events
    (message,) = [event for event in events if event["what"] == "message"]
    assert (message["at"], message["number"], message["text"], message["class"]) == (5, 5, "text 9", "message")
    assert (message["program"], message["step"]) == ("MAIN", 17), "it comes up at END of the start program (L2857)"
    assert [event["value"] for event in events if event["what"] == "M1021"] == [6]
    end = found["end"]
    assert isinstance(end, dict)
    assert (end["state"], end["program"], end["scans"], end["time_s"]) == ("running", "MAIN", 12, 0.12)


def test_the_same_input_gives_the_same_bytes(folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["run", str(folder), "--start", "MAIN", "--virtual", "--json", "--load", "7", "--at", "2 E0.6=1 M20=1"]
    texts = [(main(arguments), capsys.readouterr().out) for _ in range(2)]
    assert texts[0] == texts[1]


@pytest.mark.requirement("RSV-PLC-05", by="gateway.pure.languages.plc.virtual:VirtualRun._message")
@pytest.mark.parametrize("load", [[], ["--load", "20"]])
def test_an_endless_loop_ends_as_error_7000(load: list[str], folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, found = ran(folder, capsys, "--at", "1 E0.6=1", "--at", "4 E0.7=1", *load)
    events, end = found["events"], found["end"]
    assert isinstance(events, list)
    assert isinstance(end, dict)
    assert code == 1
    assert [(event["what"], event["value"]) for event in events if event["at"] == 4][:4] == [
        ("message", "PLC error 7000"),
        ("state", "STOP"),
        ("drives", "OFF"),
        ("A5", 0),
    ]
    assert (end["state"], end["program"]) == ("error", "MAIN")


def test_a_refused_start_is_a_message_at_0(folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, found = ran(folder, capsys, "--scans", "2", start="sub/bad")
    events = found["events"]
    assert isinstance(events, list)
    end = found["end"]
    assert isinstance(end, dict)
    assert (code, end["state"]) == (1, "error")
    assert [(event["at"], event["text"], event["step"]) for event in events[:3]] == [
        (0, "Incorrect parentheses", 2),
        (0, "E40: outside 0..39", 3),
        (0, "Subprogram not found", 4),
    ]
    assert all(event["what"] != "state" for event in events)


@pytest.mark.parametrize(("start", "said"), [("sub/bad", "correct sub/bad; all faults"), ("NIX", "has no program NIX; it has MAIN")])
def test_a_refused_start_says_what_to_do(start: str, said: str, folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(folder), "--start", start, "--virtual", "--scans", "2"]) == 1
    told = capsys.readouterr().out
    assert "START is refused" in told and said in told


@pytest.mark.parametrize("start", ["main", "MAIN.PLC", "S:/PLC/MAIN", "s:\\plc\\main.plc", "/PLC/MAIN"])
def test_a_start_program_is_named_as_the_control_or_the_folder_has_it(start: str, folder: pathlib.Path) -> None:
    assert main(["run", str(folder), "--start", start, "--virtual", "--scans", "2"]) == 0


def test_start_stop_and_power(folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "NEXT.PLC").write_text("PLC NEXT\nU M1020.4\nS M40.0\nR M1020.4\nL M41\nZV ACCU,1\nT M41\nEND\n")
    orders = ["--at", "2 STOP", "--at", "4 START NEXT", "--at", "6 M40=0", "--at", "8 POWER"]
    _, found = ran(folder, capsys, "--scans", "10", *orders)
    events = found["events"]
    assert isinstance(events, list)
    assert [(event["at"], event["value"]) for event in events if event["what"] == "state"] == [(0, "RUN"), (2, "STOP"), (4, "RUN")]
    assert [(event["at"], event["value"]) for event in events if event["what"] == "M40"] == [(4, 1), (6, 0), (8, 1)]
    assert [event["value"] for event in events if event["what"] == "M41"] == [1, 2, 3, 4, 5, 6]


def test_check_names_every_fault_with_its_file(folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(folder), "--json"]) == 1
    rows = json.loads(capsys.readouterr().out)["faults"]
    assert [(row["file"], row["line"], row["id"]) for row in rows] == [
        ("SUB/BAD", 2, "brackets"),
        ("SUB/BAD", 3, "operand"),
        ("SUB/BAD", 4, "subprogram"),
    ]


@pytest.mark.parametrize(
    ("at", "said"),
    [
        ("E0.6=1", "number of a scan"),
        ("1 E40=1", "E0 to E39"),
        ("1 E0.8=1", "bit 8"),
        ("1 M5=256", "0 to 255"),
        ("1 EA2=11", "volts"),
        ("1 JUMP", "JUMP"),
    ],
)
def test_a_wrong_order_is_one_sentence(at: str, said: str, folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(folder), "--start", "MAIN", "--virtual", "--at", at]) == 2
    told = capsys.readouterr().err
    assert said in told
    assert len(told.splitlines()) == 1


def test_a_folder_that_is_not_there(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(tmp_path / "none")]) == 2
    assert "no such folder" in capsys.readouterr().err


def test_an_imported_list_runs(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "LIST.TXT").write_text("OB 1\n  :U E 0.0\n  :L KT 20.0\n  :SE T 1\n  :U T 1\n  := A 0.0\n  :BE\n")
    assert main(["import", str(tmp_path / "LIST.TXT"), "--to", str(tmp_path / "PLC")]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "6 statements, 0 not translated"
    _, found = ran(tmp_path / "PLC", capsys, "--at", "5 E0.0=1", start="OB1")
    events = found["events"]
    assert isinstance(events, list)
    assert {"at": 25, "what": "A0", "value": 1} in events
    assert main(["import", str(tmp_path / "LIST.TXT"), "--to", str(tmp_path / "PLC")]) == 2
    assert "exists already" in capsys.readouterr().err


def test_a_binary_file_of_step_5_is_answered_with_how_to_print_it(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "TESTST.S5D").write_bytes(b"\x00\x01\x02STEP")
    assert main(["import", str(tmp_path / "TESTST.S5D"), "--to", str(tmp_path / "PLC")]) == 2
    assert "Documentation" in capsys.readouterr().err
    assert not (tmp_path / "PLC").exists()
