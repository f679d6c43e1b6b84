"""The directory of a memory: what it shows, protection, delete, rename, copy."""

import json
import pathlib

import pytest

from gateway.commands.robotstar import main

MAIN = 'MPR "PICK"\nVAR I1\nCOPY 1, I1\nCALL "GRIP"\nSTOP\nEND\n'
GRIP = "SPR GRIP\nWAIT 0.1\nEND\n"


@pytest.fixture
def memory(tmp_path: pathlib.Path) -> pathlib.Path:
    (tmp_path / "TOOLS").mkdir()
    (tmp_path / "PICK.MPR").write_text(MAIN)
    (tmp_path / "PICK.MPR.VAL").write_text("I1 = 5\n")
    (tmp_path / "GRIP.SPR").write_text(GRIP)
    (tmp_path / "TOOLS" / "3344.SPR").write_text("SPR 3344\nEND\n")
    return tmp_path


def listed(memory: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> dict[str, dict[str, object]]:
    capsys.readouterr()
    assert main(["list", str(memory), "--json"]) == 0
    return {str(row["name"]): row for row in json.loads(capsys.readouterr().out)}


def test_the_directory_shows_type_protection_and_var(memory: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = listed(memory, capsys)
    assert [*found] == ["GRIP", "PICK", "TOOLS", "TOOLS/3344"]
    assert (found["PICK"]["kind"], found["PICK"]["length"], found["PICK"]["variables"]) == ("MPR", len(MAIN), True)
    assert found["TOOLS"]["kind"] == "<DIR>" and found["GRIP"]["protection"] == "L/A/E/S/U"


@pytest.mark.requirement("RSV-PRG-19", by="gateway.pure.languages.robotstar.protection:demand")
def test_a_locked_program_is_not_deleted_but_copied(memory: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["protect", str(memory), "pick", "LS"]) == 0
    assert listed(memory, capsys)["PICK"]["protection"] == "-/A/E/-/U"
    assert main(["delete", str(memory), "PICK"]) == 1
    assert "PICK.MPR is protected against deletion (-/A/E/-/U)" in capsys.readouterr().err
    assert (memory / "PICK.MPR").exists()
    (memory / "PICK.MPR").write_text(MAIN.replace("COPY 1", "COPY 2"))
    assert main(["copy", str(memory), "PICK", "OLD"]) == 0
    assert (memory / "OLD.MPR").read_text().startswith('MPR "OLD"') and (memory / "OLD.MPR.VAL").read_text() == "I1 = 5\n"
    assert listed(memory, capsys)["OLD"]["protection"] == "L/A/E/S/U", "the copy is free"
    assert main(["protect", str(memory), "PICK", "-"]) == 0 and main(["delete", str(memory), "PICK"]) == 0
    assert not (memory / "PICK.MPR").exists() and not (memory / "PICK.MPR.VAL").exists()


def test_renaming_keeps_the_letters_and_may_be_locked(memory: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["protect", str(memory), "GRIP", "L"]) == 0 and main(["rename", str(memory), "GRIP", "GRAB"]) == 0
    assert listed(memory, capsys)["GRAB"]["protection"] == "-/A/E/S/U"
    assert main(["protect", str(memory), "GRAB", "U"]) == 0 and main(["rename", str(memory), "GRAB", "GRIP"]) == 1
    assert main(["protect", str(memory), "GRAB", "X"]) == 1 and "not a letter" in capsys.readouterr().err
    assert main(["copy", str(memory), "GRAB", "PICK"]) == 0, "another kind"
    assert main(["delete", str(memory), "PICK"]) == 2 and "several" in capsys.readouterr().err


def test_a_program_locked_against_execution_is_neither_started_nor_called(memory: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["protect", str(memory), "GRIP", "A"]) == 0
    capsys.readouterr()
    assert main(["run", str(memory), "--program", "PICK", "--virtual", "--json"]) == 1
    assert "GRIP is protected against execution (L/-/E/S/U)" in capsys.readouterr().out
    assert main(["run", str(memory), "--program", "GRIP", "--virtual", "--json"]) == 1
    (memory / ".protection").write_text("GRIP.SPR\n")
    assert main(["check", str(memory)]) == 2
    assert ".protection" in capsys.readouterr().err
