"""Modes 4.1, 4.2 and 9.4.2 of the pendant: Define, Teach in, printing of point files (L4768-4844, 8117-8194, 9912-10070)."""

import pathlib

from gateway.services.rho3_panel import Rho3Panel
from hil_tests.lab.virtual.baps2_bench import AUTOMATIC, ProgramCell, one
from hil_tests.unit.languages.baps2.test_eeprom import EepromCell

TEACH = ("MODE", "0", ".", "4", ".", "2", "ENTER", "ENTER")
OVERWRITE = "pnt. overwr.:ENTER"


def teaching(*, manual: bool = True) -> ProgramCell:
    cell = ProgramCell(one("MOVE TO HOME\nMOVE TO DEPOT") | {"P.PKT": "HOME = (1, 2, 3, 4) ; as taught in 1994\n"})
    cell.bench.run(0.5)
    if manual:
        cell.bench.permit(AUTOMATIC, value=False)
        cell.bench.run(0.2)
    return cell


def pressed(cell: ProgramCell, *keys: str) -> list[str]:
    panel = Rho3Panel(cell.control, cell.bench.dispatcher)
    for key in keys:
        panel.answer({"key": key}, 1, cell.bench.now)
        cell.bench.run(0.4)
    return [line.rstrip() for line in cell.control.functions.display.screen()]


def test_a_point_that_is_named_and_not_defined_is_taught_at_once() -> None:
    cell = teaching()
    assert pressed(cell, *TEACH)[:3] == ["4.2 P.PKT", "HOME", "DEPOT        -"]
    assert pressed(cell, "DOWN", "ENTER")[1:3] == ["DEPOT", "taught"]
    assert cell.memory.text("P.PKT") == "HOME = (1, 2, 3, 4) ; as taught in 1994\nDEPOT = (0, 15, 0, 2.999817)\n"


def test_a_defined_point_is_overwritten_by_a_second_enter_alone() -> None:
    cell = teaching()
    before = cell.memory.text("P.PKT")
    assert pressed(cell, *TEACH, "ENTER")[1:3] == ["HOME", OVERWRITE]
    assert pressed(cell, "DOWN", "UP")[2] != OVERWRITE and cell.memory.text("P.PKT") == before, "any other key retains it"
    assert pressed(cell, "ENTER")[2] == OVERWRITE and cell.memory.text("P.PKT") == before
    assert pressed(cell, "ENTER")[2] == "taught"
    assert cell.memory.text("P.PKT") == "HOME = (0, 15, 0, 2.999817) ; as taught in 1994\n"


def test_teach_in_needs_manual() -> None:
    cell = teaching(manual=False)
    assert pressed(cell, *TEACH, "DOWN", "ENTER")[2] == "kin. in automatic"
    assert "DEPOT" not in (cell.memory.text("P.PKT") or "")


DEFINE = ("MODE", "0", ".", "4", ".", "1", "ENTER", "ENTER")


def test_a_component_gets_a_number_and_the_point_file_has_it() -> None:
    cell = teaching(manual=False)
    assert pressed(cell, *DEFINE, "DOWN")[:3] == ["4.1 P.PKT", "HOME.2", "2"]
    assert pressed(cell, "-", "1", "2", ".", "5")[3] == "=-12.5"
    assert pressed(cell, "ENTER")[1:3] == ["HOME.2", "-12.5"]
    assert cell.memory.text("P.PKT") == "HOME = (1, -12.5, 3, 4) ; as taught in 1994\n"
    assert pressed(cell, "1", ".", ".", "ENTER")[2] == "no number"


def test_a_point_that_is_not_defined_is_stored_when_all_components_are_there() -> None:
    cell = teaching()
    before = cell.memory.text("P.PKT")
    pressed(cell, *DEFINE, "UP", "4", "0", "ENTER")
    assert pressed(cell, "UP", "3", "0", "ENTER")[1:3] == ["DEPOT.3", "30"]
    assert pressed(cell, "UP")[1:3] == ["DEPOT.2", "-"]
    assert pressed(cell, "LEFT", *DEFINE, "UP")[1:3] == ["DEPOT.4", "-"], "forgotten with the mode"
    assert cell.memory.text("P.PKT") == before
    for number in "4321":
        pressed(cell, number, "ENTER", "UP")
    assert cell.memory.text("P.PKT") == f"{before}DEPOT = (1, 2, 3, 4)\n"


def test_a_point_file_is_printed_as_it_is(tmp_path: pathlib.Path) -> None:
    cell = EepromCell(tmp_path, printer="printer.txt")
    cell.memory.files["P.PKT"] = b"HOME = (1, 2, 3, 4)\n"
    cell.bench.run(0.5)
    assert cell.mode("9.4.2") == "P.PKT"
    assert str(cell.control.functions.display.screen()[2]).rstrip() == "done"
    assert (tmp_path / "printer.txt").read_bytes() == b"P.PKT\r\n\r\nHOME = (1, 2, 3, 4)\r\n\x0c"


def test_without_a_printer_the_interface_is_not_available(tmp_path: pathlib.Path) -> None:
    cell = EepromCell(tmp_path)
    cell.memory.files["P.PKT"] = b"HOME = (1, 2, 3, 4)\n"
    cell.bench.run(0.5)
    cell.mode("9.4.2")
    assert str(cell.control.functions.display.screen()[2]).rstrip() == "Interface: n.avail."
