"""[controller] judged before anything runs: parameters, processes, points, files; entries of data blocks that name addresses."""

import pathlib
import re
import shutil

import pytest

from gateway.cell_file.load import CellFaults, load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.cell.cell import Cell

DEMO = read_text(find_config("demo", "cells"))
PROCESS = '[[controller.process]]\nname = "PICK"\nsteps = [ {step} ]\n'
POINT = '[[controller.point]]\nname = "p"\nboard = "b"\nmodule = "m"\naddress = "1"\n'


def faults(more: str, *edits: tuple[str, str]) -> list[str]:
    text = DEMO
    for old, new in edits:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    try:
        load_cell("cell.toml", text + more)
    except CellFaults as found:
        return [str(fault) for fault in found.faults]
    return []


@pytest.mark.parametrize(
    "more, words",
    [
        ("[controller]\nkind = 'siemens'", "controller.kind"),
        ("[controller]\nfiles = 'nowhere'", "no such folder"),
        ("[controller]\nmemory = 'nowhere'", "no such folder"),
        ("[controller]\neeprom = 'eeprom.zip'", "it keeps the memory of a rho3"),
        ("[controller]\nmemory = '.'\neeprom = 'nowhere/eeprom.zip'", "the folder of the file must exist"),
        ("[controller]\n[rho3]\nP35 = 2", "0 (transparent, 9600 baud) or 1"),
        ("[controller]\ncode_words = ['1']", 'code words belong to kind = "reis"'),
        ("[controller]\npin = '9'", 'code words belong to kind = "reis"'),
        ("[controller]\nkind = 'reis'\ncode_words = ['1', '']", "at least one letter or digit"),
        ("[controller]\nkind = 'reis'\ncode_words = ['ab']\npin = 'AB'", "two access levels have the same code"),
        ("[controller]\nkind = 'reis'\npin = '9-9'", "up to 16 letters and digits"),
        ("[controller]\nkind = 'val3'\nmemory = '.'", 'programs belong to kind = "rho3" and kind = "reis"'),
        ("[controller]\nmemory = '.'", "programs need the kinematics of a [robot] with a model"),
        ("[controller]\nhardware = 'rho3.0'\n[rho3]\nP36 = [24, 18]", "signals are in I24"),
        ("[controller]\n[rho3]\nP20 = 19\nP21 = [5, 92, 0, 87]", "a start above 0"),
        ("[controller]\n[rho3]\nP20 = 15\nP21 = [0, 44]", "four numbers"),
        ("[controller]\n[rho3]\nP3 = 12", "8, 16, 24 or 32"),
        ("[controller]\n[rho3]\nP13 = 'x'", "whole numbers"),
        ("[controller]\n[rho3]\nP27 = 2", "P27 = 2"),
        ("[controller]\n" + PROCESS.format(step="{ output = 1, input = 2 }"), "exactly one of"),
        ("[controller]\n" + PROCESS.format(step="{ }"), "exactly one of"),
        ("[controller]\n" + PROCESS.format(step="{ to = { A9 = 1.0 } }"), "no such axis"),
        ("[controller]\n" + PROCESS.format(step="{ to = { A1 = 9999.0 } }"), "-5..1500"),
        ("[controller]\n" + PROCESS.format(step="{ program = 7 }"), "no [[program]]"),
        ("[controller]\n" + PROCESS.format(step="{ output = 1 }") + "kinematics = [2]", "1..1"),
        ("[controller]\n" + 2 * PROCESS.format(step="{ output = 1 }"), "two processes"),
        ("[controller]\n" + PROCESS.format(step="{ output = 1 }").replace("PICK", "MUCHTOOLONG"), "up to 8 letters"),
        ("[controller]\nkind = 'reis'\n" + PROCESS.format(step="{ output = 1 }"), 'kind = "rho3"'),
        ("[controller]\n" + POINT + "bit = 3", 'kind = "val3"'),
        ("[controller]\nkind = 'val3'\n" + POINT, "a digital point has bit"),
        ("[controller]\nkind = 'val3'\n" + POINT + "byte = 3\nsteps = 100", "min below max"),
        ("[controller]\nkind = 'val3'\n" + 2 * (POINT + "bit = 3\n"), "two points"),
        ("[controller]\nkind = 'reis'\ndoor = 'plc9'", "no such command source"),
    ],
)
def test_what_does_not_fit_is_reported_by_its_key(more: str, words: str) -> None:
    found = faults(more)
    assert found and all("controller" in each or "rho3" in each for each in found), found
    assert any(words in each for each in found), found


def test_a_sound_controller_has_no_faults() -> None:
    assert faults("[controller]\nkinematics = 2\n" + PROCESS.format(step="{ to = { A1 = 10.0 }, speed = '50 %' }, { wait_ms = 5 }")) == []
    assert faults("[controller]\nkind = 'val3'\n" + POINT + "byte = 3\nsteps = 100\nmin = -1.0\nmax = 1.0") == []


RESET = '{ at = "D 0.2",  type = "bit", to = "cell.reset",       edge = "rising" }'
READY = '{ at = "D 0.0",  type = "bit", from = "cell.ready" }'


@pytest.mark.parametrize(
    "old, entry, words",
    [
        (RESET, '{ at = "D 0.2", type = "bit", to = "K01_A_MN_RCI" }', ""),
        (RESET, '{ at = "D 0.2", type = "bit", to = "O8.2" }', ""),
        (RESET, '{ at = "D 0.2", type = "bit", to = "READY_RCO" }', "read with from"),
        (READY, '{ at = "D 0.0", type = "bit", from = "I8.4" }', ""),
        (READY, '{ at = "DW 20", type = "KH", from = "EW 8" }', ""),
        (READY, '{ at = "DW 20", type = "KH", from = "M 3.0" }', ""),
        (READY, '{ at = "DW 20", type = "KF", from = "rho3.integer.401" }', ""),
        (READY, '{ at = "DW 20", type = "KF", from = "rho3.integer.400" }', "unknown name"),
    ],
)
def test_entries_may_name_addresses(old: str, entry: str, words: str) -> None:
    found = faults("[controller]\n", (old, entry))
    assert (found == []) if not words else any(words in each for each in found), found


def test_lines_the_dat_files_lose_are_warnings(tmp_path: pathlib.Path) -> None:
    (tmp_path / "dat").mkdir()
    (tmp_path / "dat" / "EXPROG.DAT").write_text("02 = PICK\n03 = WHO\n0G = BAD\n")
    path = tmp_path / "cell.toml"
    path.write_text(DEMO + "[controller]\nfiles = 'dat'\n" + PROCESS.format(step="{ output = 1 }"))
    cell: Cell = load_cell(str(path))
    told = [str(notice.text) for notice in cell.notices if notice.where.startswith("dat/")]
    assert [text.partition(":")[0] for text in told] == ["line 3", "code 03 selects WHO, which no [[controller.process]] declares"]


def test_programs_with_errors_and_two_of_one_name_are_named(tmp_path: pathlib.Path) -> None:
    shipped = find_config("palletiser", "cells")
    (tmp_path / "palletiser").mkdir()
    for path in (shipped.parent / "palletiser").iterdir():
        (tmp_path / "palletiser" / path.name).write_bytes(path.read_bytes())
    (tmp_path / "palletiser" / "BAD.QLL").write_text("PROGRAM BAD\nBEGIN\nX = 1\nPROGRAM_END\n")
    cell = load_cell(str(tmp_path / "palletiser.toml"), read_text(shipped))
    told = [str(notice) for notice in cell.notices if "QLL" in str(notice)]
    assert len(told) == 1 and "palletiser/BAD.QLL" in told[0] and "1 error, it does not run" in told[0]
    text = read_text(shipped) + PROCESS.format(step="{ output = 1 }").replace("PICK", "PALLET")
    with pytest.raises(CellFaults, match="palletiser has a program of this name"):
        load_cell(str(tmp_path / "palletiser.toml"), text)


def test_programs_of_a_reis_with_errors_are_named_and_a_damaged_memory_is_refused(tmp_path: pathlib.Path) -> None:
    shipped = find_config("reis-palletiser", "cells")
    shutil.copytree(shipped.parent / "reis-palletiser", tmp_path / "reis-palletiser")
    (tmp_path / "reis-palletiser" / "BAD.MPR").write_text('MPR "BAD"\nGOTO\nBLA\nEND\n')
    (tmp_path / "reis-palletiser" / "MANUAL.PDF").write_bytes(b"x" * 5_000_000)
    cell = load_cell(str(tmp_path / "reis-palletiser.toml"), read_text(shipped))
    (notice,) = [each for each in cell.notices if each.where.startswith("reis-palletiser/")]
    assert notice.where == "reis-palletiser/BAD.MPR"
    assert str(notice.text) == "2 errors, it does not run: axisgate robotstar check names them"
    (tmp_path / "reis-palletiser" / ".protection").write_text("nothing\n")
    with pytest.raises(CellFaults, match="not a letter of a protection"):
        load_cell(str(tmp_path / "reis-palletiser.toml"), read_text(shipped))


def test_the_former_key_of_the_command_source_is_read() -> None:
    """AX-1792: recordings hold the cell they were made with."""
    path = find_config("reis-plc", "cells")
    text = read_text(path)
    former = re.sub(r"^command_source *= ", "door = ", text, flags=re.MULTILINE)
    assert former != text
    controllers = [load_cell(str(path), each).controller for each in (text, former)]
    assert controllers[0] == controllers[1] and controllers[0] is not None and controllers[0].command_source == "plc"
    both = text.replace("command_source", 'door = "net"\ncommand_source')
    with pytest.raises(CellFaults, match=r"controller\.door"):
        load_cell(str(path), both)
