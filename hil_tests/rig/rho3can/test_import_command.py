"""`axisgate import p-list FILE`: file, report, exit codes."""

import json
import pathlib

import pytest

from gateway.commands.import_list import main

LIST = pathlib.Path(__file__).parents[2] / "vectors" / "rho3_plist.txt"


def test_the_list_becomes_a_file_beside_a_report(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell = tmp_path / "robot2.toml"
    assert main(["p-list", str(LIST), "-o", str(cell)]) == 0
    said = capsys.readouterr().out
    assert 'name     = "robot2"' in cell.read_text()
    assert "assumed  P401 of axis 1: gear factor 360" in said and f"next: axisgate check {cell}" in said


def test_for_a_program_and_without_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["p-list", str(LIST), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["faults"] == [] and found["missing"] == [] and len(found["taken"]) > 60
    assert main(["p-list", str(LIST)]) == 0
    both = capsys.readouterr()
    assert both.out.startswith("# rho3_plist:") and "values taken" in both.err


def test_a_short_list_is_a_finding_and_no_list_is_invalid(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    short, junk = tmp_path / "short.txt", tmp_path / "junk.txt"
    short.write_text("P5 : 8\nP401\nA_1 CAN input : 1\n")
    junk.write_text("nothing\n")
    assert main(["p-list", str(short)]) == 1
    assert "missing  P103 of axis 1" in capsys.readouterr().err
    assert main(["p-list", str(junk)]) == 2 and main(["p-list", str(tmp_path / "none")]) == 2
    assert f"{tmp_path / 'none'}: No such file" in capsys.readouterr().err


def test_a_list_without_measuring_systems_is_a_finding(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    bare = tmp_path / "bare.txt"
    bare.write_text("P5 : 8\nP15 : 3\n")
    assert main(["p-list", str(bare)]) == 1
    assert "missing  P401" in capsys.readouterr().err
