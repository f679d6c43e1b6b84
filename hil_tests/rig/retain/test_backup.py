"""`axisgate backup` and `restore`: what goes in comes back, and nothing else does (AX-426)."""

import hashlib
import json
import pathlib
import shutil
import zipfile

import pytest

import gateway
from gateway.assembly import axis_zeros as zeros
from gateway.assembly.integrated_plc import kept_of
from gateway.assembly.program_memory import program_folders
from gateway.cell_file.load import load_cell
from gateway.commands.backup import main as save
from gateway.commands.restore import main as put_back
from gateway.files.find import find_config
from gateway.recording import backup
from gateway.runtime.retained.writer import Retained, path_of
from hil_tests.lab.running.joined_running import cell_copy

MORE = """
[controller]
kind = "rho3"
files = "dat"
[retain]
values = ["counter.*"]
"""


@pytest.fixture
def plant(tmp_path: pathlib.Path) -> pathlib.Path:
    """A cell with DAT files, a layout beside it, retained data in use and a zero."""
    folder = tmp_path / "plant"
    (folder / "dat").mkdir(parents=True)
    (folder / "dat" / "MSD.DAT").write_bytes(b"01 = 'clamp open'\r\n\x1a")
    (folder / "own.dbc").write_text((pathlib.Path(gateway.__file__).parents[1] / "configs/drives/servodyn_gc.dbc").read_text())
    layout = ('axes     = "1"', 'axes     = "1"\nlayout   = "own.dbc"')
    cell = cell_copy("host-telegrams", folder, layout, more=MORE)
    kept = Retained(path_of(load_cell(str(cell))), ("counter.*",))
    kept.keep("counter.3", 42)
    kept.record("error", {"code": 647})
    assert kept.flush()
    zeros.append(load_cell(str(cell)), {"axis": "A1", "zero_inc": 12.5})
    return cell


def saved(cell: pathlib.Path) -> pathlib.Path:
    assert save([str(cell), "--to", str(cell.parent.parent / "saved.zip")]) == 0
    return cell.parent.parent / "saved.zip"


def test_what_goes_in_comes_back(plant: pathlib.Path, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, other = saved(plant), tmp_path / "other"
    capsys.readouterr()
    assert put_back([str(file), "--to", str(other), "--dry-run", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    named = {row["name"]: (row["role"], row["what"]) for row in told["files"]}
    assert named == {
        "host-telegrams.toml": ("cell file", "new"),
        "own.dbc": ("named by the cell", "new"),
        "dat/MSD.DAT": ("named by the cell", "new"),
        "retain/host-telegrams.sqlite": ("retained data", "new"),
    }
    assert told["version"] == backup.version() and not other.exists(), "a dry run changes nothing"
    assert put_back([str(file), "--to", str(other)]) == 0
    again = load_cell(str(other / "host-telegrams.toml"))
    for name in ("host-telegrams.toml", "own.dbc", "dat/MSD.DAT"):
        assert (other / name).read_bytes() == (plant.parent / name).read_bytes()
    assert Retained(path_of(again), ("counter.*",)).value("counter.3", 0) == 42
    assert zeros.zero_inc(again, "A1") == 12.5


def test_other_files_are_refused_then_kept_beside(plant: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, folder = saved(plant), plant.parent
    old = plant.read_text().replace("Host line", "Changed line")
    plant.write_text(old)
    kept = Retained(path_of(load_cell(str(plant))), ("counter.*",))
    kept.keep("counter.3", 43)
    kept.close()
    assert put_back([str(file), "--to", str(folder)]) == 1
    assert "--replace" in capsys.readouterr().err and plant.read_text() == old, "nothing was changed"
    assert put_back([str(file), "--to", str(folder), "--replace"]) == 0
    assert "Host line" in plant.read_text()
    assert [path.read_text() for path in folder.glob("host-telegrams.toml.before-*")] == [old]
    assert Retained(path_of(load_cell(str(plant))), ("counter.*",)).value("counter.3", 0) == 42
    assert len(list((folder / "retain").glob("*.before-*"))) == 1


@pytest.mark.parametrize(
    ("name", "programs", "below"), [("cs8", "cs8", "lib/lib.pgx"), ("reis-palletiser", "reis-palletiser", "LIB/A.SPR")]
)
def test_programs_of_all_folders_come_back(name: str, programs: str, below: str, tmp_path: pathlib.Path) -> None:
    """Without its application a cell of VAL 3 could neither be restored nor a recording of it be replayed."""
    cell, source = cell_copy(name, tmp_path), find_config(f"{name}.toml", "cells").parent / programs
    shutil.copytree(source, tmp_path / programs)
    place = next(iter(program_folders(load_cell(str(cell))))) / below
    place.parent.mkdir()
    place.write_text("one more program")
    place.with_name(".being-written.part").write_text("half")
    file = tmp_path / "saved.zip"
    manifest = backup.make(load_cell(str(cell)), file)
    saved_files = {part.name for part in manifest.parts if part.role == "named by the cell"}
    assert saved_files == {str(path.relative_to(tmp_path)) for path in (tmp_path / programs).rglob("[!.]*") if path.is_file()}
    other = tmp_path / "other"
    assert put_back([str(file), "--to", str(other)]) == 0 and load_cell(str(other / cell.name))
    assert (other / place.relative_to(tmp_path)).read_text() == "one more program"


def test_markers_of_the_plc_come_back(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    """On a machine they outlive power-off in a file of their own."""
    (tmp_path / "plant").mkdir()
    cell = cell_copy("reis-plc", tmp_path / "plant")
    shutil.copytree(find_config("reis-plc.toml", "cells").parent / "reis-plc", cell.parent / "reis-plc")
    markers = kept_of(load_cell(str(cell)))
    assert markers is not None
    markers.parent.mkdir()
    markers.write_bytes(b"markers, timers, counters")
    file, later = saved(cell), tmp_path / "other" / "reis-plc" / "PLC" / "LATER.PLC"
    later.parent.mkdir(parents=True)
    later.write_text("PLC LATER\nEND\n")
    assert put_back([str(file), "--to", str(tmp_path / "other")]) == 0
    assert "stays: reis-plc/PLC/LATER.PLC is not in the backup" in capsys.readouterr().out
    again = kept_of(load_cell(str(tmp_path / "other" / cell.name)))
    assert again is not None and again.read_bytes() == markers.read_bytes()


def test_a_memory_that_is_the_folder_of_the_cell_reveals_no_secret(tmp_path: pathlib.Path) -> None:
    (tmp_path / "plant" / "web").mkdir(parents=True)
    cell = cell_copy("palletiser", tmp_path / "plant", ('memory = "palletiser"', 'memory = "."'), ('files  = "palletiser"', 'files  = "."'))
    for name in ("A.QLL", "saved.zip", "A.KEY", "web/palletiser.users.sqlite-wal"):
        (cell.parent / name).write_text("-----BEGIN PRIVATE KEY-----" if name == "A.KEY" else "")
    manifest = backup.make(load_cell(str(cell)), cell.parent / "saved.zip")
    assert {part.name: part.role for part in manifest.parts} == {"A.QLL": "named by the cell", cell.name: "cell file"}
    assert manifest.withheld == ("A.KEY",)


@pytest.mark.parametrize(
    ("name", "key", "folder"),
    [("cs8", "", "cs8/usrapp"), ("reis-plc", "path  = ", "reis-plc/PLC"), ("palletiser", "files  = ", "palletiser")],
)
def test_programs_elsewhere_are_named_and_left_out(
    name: str, key: str, folder: str, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cells = find_config("cs8.toml", "cells").parent
    (tmp_path / "plant").mkdir()
    cell = cell_copy(name, tmp_path / "plant", (f'{key}"{folder}"', f'{key}"../elsewhere"'))
    if name == "palletiser":
        shutil.copytree(cells / folder, cell.parent / folder)
    shutil.copytree(cells / folder, tmp_path / "elsewhere")
    assert save([str(cell), "--to", str(tmp_path / "saved.zip")]) == 0
    printed = capsys.readouterr().out
    assert printed.count("left out:") == 1
    assert f"left out: {tmp_path / 'elsewhere'} is outside the folder of the cell; save it yourself" in printed


def test_a_backup_that_cannot_be_read_back_leaves_no_file(
    plant: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(backup, "MOST_BYTES", 100)
    assert save([str(plant), "--to", str(tmp_path / "saved.zip")]) == 3
    assert "more than 0 MiB" in capsys.readouterr().err and list(tmp_path.glob("saved.zip*")) == []


SPOILED = {
    "byte": "own.dbc is not what was saved",
    "missing": "its manifest lists",
    "more": "surprise.txt",
    "path": "../own.dbc: name",
    "version": "which is older",
    "no zip": "is not a backup",
    "cell": "its cell has faults here",
    "database": "damaged",
}


def spoiled(file: pathlib.Path, bad: pathlib.Path, how: str) -> None:
    """A backup with one thing wrong."""
    with zipfile.ZipFile(file) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    manifest = json.loads(parts["manifest.json"])
    match how:
        case "byte":
            parts["own.dbc"] = parts["own.dbc"][:-1] + b"X"
        case "missing":
            del parts["dat/MSD.DAT"]
        case "more":
            parts["surprise.txt"] = b"?"
        case "path":
            row = next(row for row in manifest["parts"] if row["name"] == "own.dbc")
            row["name"] = "../own.dbc"
            parts["../own.dbc"] = parts.pop("own.dbc")
        case "version":
            manifest["version"] = "99.0.0"
        case "cell" | "database":
            name = "host-telegrams.toml" if how == "cell" else "retain/host-telegrams.sqlite"
            parts[name] = b"format = 1\n[cell]\n" if how == "cell" else b"spoiled" * 1000
            row = next(row for row in manifest["parts"] if row["name"] == name)
            row["size"], row["sha256"] = len(parts[name]), hashlib.sha256(parts[name]).hexdigest()
    parts["manifest.json"] = json.dumps(manifest).encode()
    with zipfile.ZipFile(bad, "w") as archive:
        for name, body in parts.items():
            archive.writestr(name, body)
    if how == "no zip":
        bad.write_bytes(b"PK nothing")


def test_a_spoiled_backup_changes_nothing(plant: pathlib.Path, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, bad, other = saved(plant), tmp_path / "bad.zip", tmp_path / "other"
    for how, words in SPOILED.items():
        spoiled(file, bad, how)
        capsys.readouterr()
        assert put_back([str(bad), "--to", str(other)]) == 2, how
        assert words in capsys.readouterr().err, how
        assert not (tmp_path / "own.dbc").exists() and (not other.exists() or list(other.iterdir()) == []), how


def test_words_for_the_command_line(plant: pathlib.Path, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert save([str(plant), "--to", str(tmp_path / "no" / "folder.zip")]) == 3
    assert save([str(tmp_path / "nothing.toml"), "--to", str(tmp_path / "x.zip")]) == 2
    assert put_back([str(tmp_path / "nothing.zip"), "--to", str(tmp_path)]) == 2
    outside = tmp_path / "outside.dbc"
    outside.write_text((plant.parent / "own.dbc").read_text())
    plant.write_text(plant.read_text().replace('"own.dbc"', '"../outside.dbc"'))
    capsys.readouterr()
    assert save([str(plant), "--to", str(tmp_path / "x.zip")]) == 0
    assert f"left out: {outside}" in capsys.readouterr().out
