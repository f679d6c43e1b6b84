"""Nothing of worth lives in the runtime folder: it goes to one configured folder, or `run` says so (AX-627)."""

import json
import os
import pathlib
import subprocess
import sys
import time

import pytest

import gateway
from drivers.ports.base import PortError, runtime_dir
from gateway.assembly import axis_zeros as zeros
from gateway.cell_file.load import load_cell
from gateway.pure.cell.web import Web
from gateway.runtime import state_folder as statefolder
from gateway.runtime.page_data import data_file
from gateway.runtime.retained import writer as retain
from hil_tests.lab.running.cell_running import P5_MS, running_cell
from hil_tests.rig.canopen.test_first_enable import real


def test_state_goes_to_the_configured_folder_and_two_cells_of_one_name_do_not_meet(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "other").mkdir()
    one, other, state = real(tmp_path), real(tmp_path / "other"), tmp_path / "state"
    assert zeros.path_of(one) == tmp_path / "zero" / "mine.jsonl", "without it: beside the cell"
    monkeypatch.setenv(statefolder.VARIABLE, str(state))
    files = [zeros.path_of(one), retain.path_of(one), data_file(one, Web(), simulated=False), zeros.path_of(other)]
    assert all(path.is_relative_to(state) for path in files) and len({*files}) == 4
    zeros.append(one, {"axis": "X", "zero_inc": 12.5})
    assert zeros.zero_inc(one, "X") == 12.5 and zeros.zero_inc(other, "X") is None
    assert retain.path_of(one).exists() and not (tmp_path / "retain").exists()
    shipped = load_cell(str(pathlib.Path(gateway.__file__).parents[1] / "configs" / "cells" / "demo.toml"))
    assert zeros.path_of(shipped).is_relative_to(state)


def test_what_lies_beside_the_cell_already_counts(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cell = real(tmp_path)
    zeros.append(cell, {"axis": "X", "zero_inc": 7.0})
    monkeypatch.setenv(statefolder.VARIABLE, str(tmp_path / "state"))
    assert zeros.zero_inc(cell, "X") == 7.0, "no zero is lost by naming a folder"
    beside = tmp_path / "retain" / "line[1].plc"
    beside.write_text("")
    assert statefolder.place(str(tmp_path / "line[1].toml"), "retain", beside.name) == beside, "whatever its name is"


def test_run_says_what_does_not_stay(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cell = real(tmp_path)
    assert statefolder.warning(cell.file, simulated=False).startswith(f"state: the journal lies in {runtime_dir()}")
    assert statefolder.warning(cell.file, simulated=True) == ""
    shipped = pathlib.Path(gateway.__file__).parents[1] / "configs" / "cells" / "demo.toml"
    assert "zeros, last places" in statefolder.warning(str(shipped), simulated=False)
    monkeypatch.setenv(statefolder.VARIABLE, str(tmp_path / "state"))
    assert statefolder.warning(cell.file, simulated=False) == ""


def test_a_folder_that_cannot_be_made_is_refused_before_anything_starts(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv(statefolder.VARIABLE, str(tmp_path / "file" / "state"))
    with pytest.raises(PortError, match="cannot be made"):
        statefolder.usable()
    command = [sys.executable, "-m", "gateway", "run", "demo", "--sim", "--name", "nowhere"]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 3 and done.stderr.startswith("axisgate run: AXISGATE_STATE=") and done.stderr.count("\n") == 1


def test_the_journal_of_a_run_lies_there_too(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(statefolder.VARIABLE, str(tmp_path / "state"))
    with running_cell(name="kept", plc=False, p5_ms=max(P5_MS, 20)) as run:
        journal = tmp_path / "state" / "journal" / "kept.jsonl"
        assert run.status()["journal"] == str(journal)
        time.sleep(0.2)
        assert any("services started" in json.loads(line)["text"] for line in journal.read_text().splitlines())
        assert not os.path.exists(pathlib.Path(run.status()["folder"]) / "journal.jsonl")
