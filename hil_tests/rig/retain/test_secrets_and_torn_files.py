"""Keys and users stay out of backups unless asked for; torn files are passed over and told; places are kept while running (AX-625)."""

import os
import pathlib
import sqlite3
import zipfile

import pytest

from gateway.assembly import axis_zeros as zeros
from gateway.assembly.last_positions import LastPlaces, judge
from gateway.cell_file.load import load_cell
from gateway.commands.backup import main as save
from gateway.commands.restore import main as put_back
from gateway.files.safe_file import append_line, write_whole
from gateway.pure.image.records.cell import AxisState, CellState
from gateway.recording import backup
from gateway.runtime.page_data import data_file
from gateway.tools.drives.first_enable import WORDS, confirm, log_of, unconfirmed
from gateway.web.store import Role, Store
from hil_tests.lab.running.joined_running import cell_copy
from hil_tests.rig.canopen.test_first_enable import real

KEY = "-----BEGIN PRIVATE KEY-----\nMIIE\n-----END PRIVATE KEY-----\n"
MORE = """
[web]
bind = "127.0.0.1:8480"
tls_certificate = "tls/page.pem"
tls_key = "tls/page.key"
"""


@pytest.fixture
def plant(tmp_path: pathlib.Path) -> pathlib.Path:
    """A cell whose page has a key and users."""
    folder = tmp_path / "plant"
    (folder / "tls").mkdir(parents=True)
    (folder / "tls" / "page.pem").write_text("-----BEGIN CERTIFICATE-----\n")
    (folder / "tls" / "page.key").write_text("a key in a form of its own")
    file = cell_copy("host-telegrams", folder, more=MORE)
    cell = load_cell(str(file))
    assert cell.web is not None
    store = Store(data_file(cell, cell.web, simulated=False))
    store.put_user("anna", Role.ADMIN, "correct horse battery")
    store.close()
    return file


def names(file: pathlib.Path) -> set[str]:
    with zipfile.ZipFile(file) as archive:
        return set(archive.namelist())


def test_keys_and_users_are_withheld_and_the_backup_says_so(plant: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, other = plant.parent.parent / "plain.zip", plant.parent.parent / "other"
    assert save([str(plant), "--to", str(file)]) == 0
    said = capsys.readouterr().out
    assert "withheld: tls/page.key (a secret)" in said and "withheld: web/host-telegrams.sqlite (a secret)" in said
    assert names(file) == {"manifest.json", "host-telegrams.toml", "tls/page.pem"}
    assert b"anna" not in file.read_bytes()
    assert put_back([str(file), "--to", str(other)]) == 0, "it can be restored all the same"
    assert "not in the backup: tls/page.key (a secret)" in capsys.readouterr().out
    assert not (other / "tls" / "page.key").exists(), "no empty key is left behind"


def test_asked_for_they_are_in_it_and_nobody_else_can_read_it(plant: pathlib.Path) -> None:
    file, other = plant.parent.parent / "whole.zip", plant.parent.parent / "other"
    assert save([str(plant), "--to", str(file), "--secrets"]) == 0
    assert file.stat().st_mode & 0o777 == 0o600
    assert {"tls/page.key", "web/host-telegrams.sqlite"} <= names(file)
    assert put_back([str(file), "--to", str(other)]) == 0
    assert (other / "tls" / "page.key").stat().st_mode & 0o777 == 0o600
    with sqlite3.connect(other / "web" / "host-telegrams.sqlite") as users:
        assert "anna" in str(users.execute("SELECT name FROM user").fetchall())


def test_a_private_key_is_known_by_its_content_too(plant: pathlib.Path) -> None:
    plant.write_text(plant.read_text().replace('tls_certificate = "tls/page.pem"', 'tls_certificate = "tls/both.pem"'))
    (plant.parent / "tls" / "both.pem").write_text(KEY)
    file = plant.parent.parent / "plain.zip"
    assert "tls/both.pem" in backup.make(load_cell(str(plant)), file).withheld


def test_a_torn_line_of_a_history_is_passed_over_and_reported(plant: pathlib.Path) -> None:
    cell = load_cell(str(plant))
    path = zeros.path_of(cell)
    path.parent.mkdir(exist_ok=True)
    path.write_text('{"axis": "A1", "zero_inc": 12.5}\n{"axis": "A1", "zero_i')
    assert zeros.zero_inc(cell, "A1") == 12.5
    assert zeros.torn_lines(cell) == [f"{path}: line 2: cut off and passed over; check what it held, then remove it"]
    log_of(cell).write_text('{"wall": "2026-01-01", "ax')
    assert "A1" in unconfirmed(cell)
    assert confirm(cell, ["A1"], lambda text: f"{WORDS} A. Fitter", lambda text: None)
    assert "A1" not in unconfirmed(cell)


def test_a_line_after_a_torn_one_is_whole(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "log.jsonl"
    path.write_text('{"cut')
    append_line(path, '{"whole": 1}')
    append_line(path, '{"whole": 2}')
    assert path.read_text() == '{"cut\n{"whole": 1}\n{"whole": 2}\n'


def test_a_file_is_replaced_as_a_whole_and_flushed_with_its_folder(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flushed: list[int] = []
    fsync = os.fsync

    def seen(fd: int) -> None:
        flushed.append(os.fstat(fd).st_ino)
        fsync(fd)

    monkeypatch.setattr(os, "fsync", seen)
    path = tmp_path / "places.json"
    write_whole(path, b"{}")
    assert path.stat().st_ino in flushed and tmp_path.stat().st_ino in flushed
    path.unlink()
    path.mkdir()
    with pytest.raises(OSError) as refused:
        write_whole(path, b"new")
    assert refused.value.filename == str(path), "commands print it"
    assert list(tmp_path.iterdir()) == [path], "nothing is left beside it"


def test_places_are_kept_while_the_run_goes_on(tmp_path: pathlib.Path) -> None:
    cell = real(tmp_path)
    absolute = [n for n, axis in enumerate(cell.axis) if axis.home.by == "none"]
    places, path = LastPlaces(cell), zeros.path_of(cell).with_suffix(".last.json")
    axes = [AxisState() for _ in range(12)]
    places.look(CellState(axes=axes))
    writer = places._writer
    assert writer is not None
    writer.join()
    first = path.read_text()
    places.look(CellState(axes=axes))
    assert places._writer is writer, "nothing moved: nothing is written"
    axes[absolute[0]] = AxisState(actual=0.05)
    places.look(CellState(axes=axes))
    assert places._writer is not None
    places._writer.join()
    assert path.read_text() != first
    assert judge(cell, CellState(axes=axes)) == []
    path.write_text('{"A1": 12')
    assert judge(cell, CellState(axes=axes)) == [], "a torn file tells nothing and stops nobody"
