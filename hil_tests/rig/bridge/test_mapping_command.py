"""`axisgate mapping`: a cell's tables to every file and back, in the encodings old tools save."""

import pathlib
import re
import tomllib

import pytest

from gateway.cell_file.load import load_cell
from gateway.commands.mapping import main
from gateway.files.find import find_config

MORE = """
[[db]]
number = 40
words = 40
writer = "plc2"
line = "plc1"
comment = "recipes; by Modbus"
[[route]]
name = "swapped"
from = "DB40.DD 2"
type = "u32"
order = "BADC"
to = "AD 40"
to_type = "u32"
to_order = "CDAB"
on_loss = "value"
loss_value = 7
loss_after_ms = 500
debounce_ms = 20
every_ms = 30
within_ms = 5000
valid = "A 46.0"
life = "AW 48"
[[route]]
name = "pulse"
from = "DB40.D 5.3"
to = "A 50.1"
edge = "rising"
pulse_ms = 250
comment = "one each time"
"""


@pytest.mark.parametrize("suffix", ["csv", "xlsx"])
def test_the_tables_of_a_cell_come_back_as_they_were(suffix: str, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    table, toml = tmp_path / f"t.{suffix}", tmp_path / "t.toml"
    assert main(["s5-rk512", str(table)]) == 0 and main([str(table), str(toml)]) == 0
    found = tomllib.loads(toml.read_text())
    shipped = tomllib.loads((pathlib.Path(__file__).parents[3] / "configs/cells/s5-rk512.toml").read_text())
    assert [block["entries"] for block in found["db"]] == [
        [{key: float(value) if key in ("min", "max") else value for key, value in entry.items()} for entry in block["entries"]]
        for block in shipped["db"]
    ]
    capsys.readouterr()


@pytest.mark.parametrize("suffix", ["csv", "xlsx"])
@pytest.mark.parametrize("name", ["cl300-bits", "rho3-coupled", "modbus-servodyn", "s5-rk512", "demo"])
def test_a_cell_whose_tables_went_through_a_spreadsheet_is_the_same_cell(name: str, suffix: str, tmp_path: pathlib.Path) -> None:
    text = find_config(name, "cells").read_text() + (MORE if name == "demo" else "")
    whole, table, toml = load_cell(f"{name}.toml", text), tmp_path / f"t.{suffix}", tmp_path / "t.toml"
    (tmp_path / "before.toml").write_text(text)
    assert main([str(tmp_path / "before.toml"), str(table)]) == 0 and main([str(table), str(toml)]) == 0
    parts = re.split(r"(?m)^(?=\[)", text)
    rest = "".join(part for part in parts if not part.startswith(("[[route]]", "[[db]]")))
    again = load_cell(f"{name}.toml", f"{rest}\n{toml.read_text()}")
    assert again.route == whole.route and again.db == whole.db and (whole.route or whole.db)


def test_signals_as_an_assignment_list_in_the_old_character_set(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    listed, table = tmp_path / "ANLAGEZ0.SEQ", tmp_path / "t.csv"
    assert main(["demo", str(listed)]) == 0
    assert b"E 8.0\tREADY_RCO\t" in listed.read_bytes()
    assert main([str(listed), str(table), "--encoding", "cp437"]) == 0
    table.write_bytes("table;name;at;comment\r\nsymbol;PUMPE;A 12.0;Kühlung läuft\r\n".encode("cp850"))
    assert main([str(table), str(tmp_path / "p.seq"), "--encoding", "cp850"]) == 0
    assert (tmp_path / "p.seq").read_bytes() == "A 12.0\tPUMPE\tKühlung läuft\r\n".encode("cp850")
    assert main([str(table), str(tmp_path / "p.toml")]) == 2, "cp850 read as UTF-8 is told"
    assert "try --encoding" in capsys.readouterr().err


def test_files_that_are_none_are_reported(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "x.xlsx").write_bytes(b"no zip")
    assert main([str(tmp_path / "x.xlsx"), str(tmp_path / "y.csv")]) == 2
    assert main([str(tmp_path / "absent.csv"), str(tmp_path / "y.csv")]) == 3
    assert main(["demo", str(tmp_path / "y.pdf")]) == 2
    assert "ends in" in capsys.readouterr().err
