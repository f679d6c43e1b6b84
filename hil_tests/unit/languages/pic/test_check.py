"""What `axisgate check` and `axisgate program check` say of a PIC program."""

import json
import pathlib
import shutil

import pytest

import configs
from gateway.cell_file.load import CellFaults, load_cell
from gateway.commands.program import main

CELLS = pathlib.Path(configs.__file__).parent / "cells"
SOUND = "EMSTOP_OK_RCI = 1\nUSER_1_RCI = LAMP\n"


def cell_with(folder: pathlib.Path, program: str | None, pic: str = "LOCK", own: tuple[int, ...] = (3, 58)) -> list[str]:
    """Faults of the palletiser with this program."""
    shutil.copytree(CELLS / "palletiser", folder / "palletiser")
    if program is not None:
        (folder / "palletiser" / "LOCK.QLS").write_text(program)
        (folder / "palletiser" / "LOCK.SYM").write_text("LAMP = I88.0\n")
    text = (CELLS / "palletiser.toml").read_text().replace('kind   = "rho3"', f'kind   = "rho3"\npic    = "{pic}"')
    for byte in own:
        text = text.replace(f'"{byte}" = "rack"', f'"{byte}" = "pic"')
    (folder / "cell.toml").write_text(text)
    try:
        load_cell(str(folder / "cell.toml"))
    except CellFaults as found:
        return [str(fault) for fault in found.faults]
    return []


def test_a_sound_program_is_taken(tmp_path: pathlib.Path) -> None:
    assert cell_with(tmp_path, SOUND) == []


@pytest.mark.parametrize(
    ("program", "pic", "own", "words"),
    [
        (None, "LOCK", (3,), "has no LOCK.QLS"),
        (SOUND, "2LOCK", (), "up to 8 letters"),
        ("O3.0 = NOWHERE\nO3.1 = 2", "LOCK", (3,), "2 errors"),
        (SOUND, "LOCK", (3,), "it is the byte of rack; give it to the PIC"),
        ("O70.0 = 1", "LOCK", (3,), "it has no owner"),
    ],
)
def test_what_does_not_fit_is_refused(tmp_path: pathlib.Path, program: str | None, pic: str, own: tuple[int, ...], words: str) -> None:
    found = cell_with(tmp_path, program, pic, own)
    assert len(found) == 1 and words in found[0], found


def test_a_byte_of_a_pic_needs_one(tmp_path: pathlib.Path) -> None:
    shutil.copytree(CELLS / "palletiser", tmp_path / "palletiser")
    (tmp_path / "cell.toml").write_text((CELLS / "palletiser.toml").read_text().replace('"3" = "rack"', '"3" = "pic"'))
    with pytest.raises(CellFaults, match="no such command source"):
        load_cell(str(tmp_path / "cell.toml"))


def test_the_command_lists_faults_of_source_and_symbols(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "LOCK.QLS").write_text("O3.0 = NOWHERE\nUSER_1_RCI = LAMP\n")
    (tmp_path / "LOCK.SYM").write_text("LAMP = I88.0\n?\n")
    assert main(["check", str(tmp_path / "LOCK.QLS"), "--json"]) == 1
    rows = json.loads(capsys.readouterr().out)
    assert [(pathlib.Path(row["file"]).name, row["line"], row["id"], row["severity"]) for row in rows] == [
        ("LOCK.QLS", 1, "name", "error"), ("LOCK.SYM", 2, "symbol-line", "error")
    ]  # fmt: skip
    (tmp_path / "LOCK.QLS").write_text("USER_1_RCI = LAMP\n")
    (tmp_path / "LOCK.SYM").write_text("LAMP = I88.0\n")
    assert main(["check", str(tmp_path / "LOCK.QLS")]) == 0
