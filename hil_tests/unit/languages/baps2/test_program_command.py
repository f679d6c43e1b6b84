"""axisgate program: what it prints, and its exit codes."""

import contextlib
import json
import os
import pathlib

import pytest

from gateway.commands.program import main
from gateway.runtime.exit_codes import Exit

GOOD = "PROGRAM PICK\nOUTPUT : 1 = O\nBEGIN\nMOVE TO HERE\nO = 1\nPROGRAM_END\n"


@pytest.fixture
def folder(tmp_path: pathlib.Path) -> pathlib.Path:
    (tmp_path / "pick.qll").write_text(GOOD)
    (tmp_path / "PICK.PKT").write_text("; taught\nHERE = (1, 2)\n")
    (tmp_path / "BAD.QLL").write_text("PROGRAM BAD\nINTEGER : A_NAME_TOO_LONG\nBEGIN\nX = 1\nPROGRAM_END\n")
    return tmp_path


def test_check_prints_a_list_of_faults(folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(folder / "pick.qll"), "--json"]) == Exit.OK
    assert json.loads(capsys.readouterr().out) == []
    assert main(["check", str(folder / "BAD.QLL"), "--json"]) == Exit.FINDING
    rows = json.loads(capsys.readouterr().out)
    assert [(row["line"], row["column"], row["severity"], row["id"]) for row in rows] == [
        (2, 11, "warning", "long-name"),
        (4, 1, "error", "name-unknown"),
    ]
    assert {row["file"] for row in rows} == {str(folder / "BAD.QLL")}


def test_trace_prints_one_object_an_event(folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    feed = folder / "feed.toml"
    feed.write_text('block_s = 0.5\n[files]\n"A.DAT" = "31"\n')
    assert main(["trace", str(folder), "pick", "--feed", str(feed), "--json"]) == Exit.OK
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [(event["t"], event["event"]) for event in events] == [
        (0.0, "start"),
        (0.0, "move"),
        (0.0, "moving"),
        (0.5, "moved"),
        (0.5, "out"),
        (0.5, "end"),
        (0.5, "files"),
    ]
    assert events[1] == {
        "t": 0.0,
        "process": "PICK",
        "line": 4,
        "event": "move",
        "n": 1,
        "kinematic": "1",
        "way": "ptp",
        "pass": "to",
        "space": "wc",
        "target": [1.0, 2.0],
    }
    assert events[-1]["files"] == {"A.DAT": "31"}


@pytest.mark.parametrize(
    "arguments, code, told",
    [
        (["trace", ".", "GONE"], Exit.INVALID, "there is no program GONE"),
        (["trace", "./gone", "PICK"], Exit.INVALID, "No such file"),
        (["trace", ".", "BAD"], Exit.FINDING, "X is not declared"),
        (["trace", ".", "old"], Exit.FINDING, "OLD.IRD is a translation; axisgate runs sources; put OLD.QLL into its folder"),
        (["trace", ".", "PICK", "--feed", "feed.toml"], Exit.INVALID, "p5_ms = 0: a number from 1 to 1000 is expected"),
        (["check", "gone.qll"], Exit.INVALID, "No such file"),
    ],
)
def test_what_is_not_there_is_one_sentence(
    folder: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: list[str], code: int, told: str
) -> None:
    (folder / "feed.toml").write_text("p5_ms = 0\n")
    (folder / "OLD.IRD").write_bytes(b"\x80\x01")
    monkeypatch.chdir(folder)
    assert main(arguments) == code
    assert told in capsys.readouterr().err


def test_a_reader_that_has_seen_enough_is_no_fault_of_a_file(folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with pytest.raises(BrokenPipeError), open(writing, "w", buffering=1) as out, contextlib.redirect_stdout(out):
        main(["trace", str(folder), "pick"])
    assert capsys.readouterr().err == ""


def test_list_names_all_programs(folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", str(folder), "--json"]) == Exit.OK
    assert [(row["program"], row["errors"]) for row in json.loads(capsys.readouterr().out)] == [("BAD", 1), ("PICK", 0)]


def test_points_are_listed_with_their_components(folder: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["points", str(folder), "pick", "--json"]) == Exit.OK
    assert json.loads(capsys.readouterr().out) == {"HERE": [1.0, 2.0]}
    (folder / "PICK.PKT").write_text("HERE = (1, 2)\nno point\n")
    assert main(["points", str(folder), "PICK"]) == Exit.FINDING
    told = capsys.readouterr()
    assert told.out == "HERE          1, 2\n" and told.err.startswith("PICK.PKT:2")
    assert main(["points", str(folder), "NONE"]) == Exit.INVALID
    assert "there is no NONE.PKT" in capsys.readouterr().err


def test_a_cell_without_a_memory_is_reported_in_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["start", "portal", "PICK"]) == Exit.INVALID
    sentence = 'portal has no programs: [controller] with memory = "FOLDER" names their folder, [val3] an application'
    assert capsys.readouterr().err == f"axisgate program: {sentence}\n"
