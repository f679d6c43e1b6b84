"""Modes 9.6 and 9.7 of the pendant in a cell: the user memory to the EEPROM and back (rho 3 releases L4846-4911)."""

import pathlib
from dataclasses import replace
from typing import Literal

import pytest

from gateway.assembly.interpreter import Baps2Programs
from gateway.assembly.run import RunPlan
from gateway.files import safe_file
from gateway.pure.image.records.cell import CellState
from gateway.runtime import unwritten
from gateway.services.rho3_panel import Rho3Panel
from hil_tests.lab.virtual.baps2_bench import CELL, ProgramCell, VirtualPort, one

SOURCE = one("WRITE_BEGIN NOTES\nWRITE NOTES, 'kept'\nWAIT 60\nCLOSE NOTES", "FILE : NOTES")


class EepromCell(ProgramCell):
    """With a folder that is its memory, and a file that is its EEPROM."""

    def __init__(
        self,
        folder: pathlib.Path,
        *,
        eeprom: str = "eeprom.zip",
        hardware: Literal["rho3.0", "rho3.1"] = "rho3.1",
        printer: str = "",
        card: str = "",
    ) -> None:
        memory = folder / "memory"
        if not memory.exists():
            memory.mkdir(parents=True)
            for name, text in SOURCE.items():
                (memory / name).write_text(text)
        assert CELL.controller is not None
        own = replace(CELL.controller, memory="memory", eeprom=eeprom, hardware=hardware, printer=printer, sram_card=card)
        self.folder, self.eeprom = memory, folder / "eeprom.zip"
        super().__init__({}, replace(CELL, file=str(folder / "cell.toml"), controller=own))
        self.panel = Rho3Panel(self.control, self.bench.dispatcher)
        self.chain = self.control.setup.numbers.chain

    def born(self, identity: int) -> None:
        self.port = VirtualPort(identity)
        self.programs = Baps2Programs(RunPlan("eeprom", self.cell, True, self.folder.parent, 4, {}, {}, {}, ()), self.port)
        self.language, self.memory = self.programs.language, self.programs.memory

    def _interpreter(self, port: VirtualPort, state: CellState, now: int) -> None:
        super()._interpreter(port, state, now)
        assert self.programs.write_back() == []

    def stopped(self) -> "EepromCell":
        self.bench.permit(self.chain, value=False)
        self.bench.run(0.2)
        return self

    def mode(self, mode: str) -> str:
        """Chosen, and ENTER; what line 2 or the level says then."""
        self.panel.answer({"mode": mode}, 1, self.bench.now)
        self.bench.run(0.3)
        self.panel.answer({"key": "ENTER"}, 1, self.bench.now)
        self.bench.run(0.6)
        return str(self.control.functions.display.screen()[1]).rstrip()


@pytest.fixture
def cell(tmp_path: pathlib.Path) -> EepromCell:
    return EepromCell(tmp_path)


def test_a_file_changed_on_the_disk_while_programs_run_is_not_lost(cell: EepromCell) -> None:
    """An operator edits points or data in the folder; the program that runs writes the same file."""
    (cell.folder / "N.DAT").write_bytes(b"read")
    assert cell.programs.refresh(lambda: None) is not None
    (cell.folder / "N.DAT").write_bytes(b"of the operator")
    cell.memory.files["N.DAT"] = b"of the program"
    (fault,) = cell.programs.write_back()
    (aside,) = cell.folder.glob("N.DAT.before-*")
    assert aside.name in fault and aside.read_bytes() == b"of the operator"
    assert (cell.folder / "N.DAT").read_bytes() == b"of the program"
    cell.memory.files["N.DAT"] = b"once more"
    assert cell.programs.write_back() == [] and len(list(cell.folder.glob("*.before-*"))) == 1


def test_a_changed_file_is_kept_by_the_second_attempt_where_the_disk_was_full(cell: EepromCell, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    (cell.folder / "N.DAT").write_bytes(b"of the operator")
    cell.memory.files["N.DAT"] = b"of the program"
    with monkeypatch.context() as disk:
        disk.setattr(safe_file, "put_in_place", full)
        assert ["No space left on device" in fault for fault in cell.programs.write_back()] == [True]
    assert (cell.folder / "N.DAT").read_bytes() == b"of the operator"
    monkeypatch.setattr(unwritten, "AGAIN_S", 0.0)
    cell.programs._unwritten._due = 0.0  # a second later
    assert cell.programs.write_back() == []
    (aside,) = cell.folder.glob("N.DAT.before-*")
    assert (aside.read_bytes(), (cell.folder / "N.DAT").read_bytes()) == (b"of the operator", b"of the program")


def test_what_could_not_be_written_is_tried_again(cell: EepromCell, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as disk:
        disk.setattr(safe_file, "put_in_place", full)
        for name in ("N.DAT", "M.DAT"):
            cell.memory.files[name] = b"of the program"
        assert ["No space left on device" in fault for fault in cell.programs.write_back()] == [True, True]
    monkeypatch.setattr(unwritten, "AGAIN_S", 0.0)
    cell.programs._unwritten._due = 0.0  # a second later
    (cell.folder / "M.DAT").write_bytes(b"of the operator")
    assert cell.programs.write_back() == []
    assert (cell.folder / "N.DAT").read_bytes() == b"of the program"
    assert (cell.folder / "M.DAT").read_bytes() == b"of the operator", "what came into its place meanwhile stays"
    assert cell.port is not None
    assert [words for words in cell.port.words if "N.DAT" in words] == [
        f"{cell.folder / 'N.DAT'} line 0: is written now, nothing in it is lost"
    ]


@pytest.mark.requirement("RHO-PHG-15", by="gateway.pure.languages.baps2.cell_eeprom:refused")
def test_the_memory_is_saved_in_emergency_stop_alone(cell: EepromCell) -> None:
    assert cell.mode("9.6") == "no EMERGENCY STOP"
    assert not cell.eeprom.exists()
    cell.stopped().mode("9.6")
    assert cell.eeprom.exists() and cell.control.functions.phg.mode == "0", "the control starts up"


@pytest.mark.requirement("RHO-PHG-15", by="gateway.pure.languages.baps2.filing:Filing.any_open")
def test_open_files_and_processes_keep_the_memory_from_being_saved(cell: EepromCell) -> None:
    cell.start("P")
    cell.until(cell.language.filing.any_open, 5.0)
    assert cell.stopped().mode("9.6") == "File(s) not closed"
    cell.language.filing.close_all(next(iter(cell.language.tasks)))
    assert cell.mode("9.6") == "Prog. is active"
    assert not cell.eeprom.exists()


@pytest.mark.requirement("RHO-PHG-15", by="gateway.pure.languages.baps2.cell_eeprom:save_refused")
def test_sizes_and_write_protection_are_refused(cell: EepromCell) -> None:
    cell.stopped()
    cell.memory.files["BIG.DAT"] = bytes(96 * 1024)
    assert cell.mode("9.6") == "Memory too full"
    cell.memory.files["BIG.DAT"] = bytes(129 * 1024)
    assert cell.mode("9.6") == "EEPROM not enough"
    del cell.memory.files["BIG.DAT"]
    cell.eeprom.write_bytes(b"")
    cell.eeprom.chmod(0o444)
    assert cell.mode("9.6") == "EEPROM write protect"
    assert cell.eeprom.read_bytes() == b""


def test_what_was_saved_comes_back_and_all_else_is_gone(cell: EepromCell, tmp_path: pathlib.Path) -> None:
    cell.stopped().mode("9.6")
    (cell.folder / "P.QLL").write_text("changed")
    cell.memory.files["P.QLL"] = b"changed"
    cell.memory.files["NEW.DAT"] = b"later"
    cell.bench.run(0.1)
    assert (cell.folder / "NEW.DAT").exists()
    cell.mode("9.7")
    assert cell.control.functions.phg.mode == "0"
    assert (cell.folder / "P.QLL").read_text() == SOURCE["P.QLL"] and not (cell.folder / "NEW.DAT").exists()
    cell.bench.permit(cell.chain)
    other = EepromCell(tmp_path, hardware="rho3.0").stopped()
    assert other.mode("9.7") == "Memory <> EEPROM"


def test_nothing_is_loaded_from_what_is_no_eeprom(cell: EepromCell) -> None:
    cell.stopped()
    for data in (None, b"", b"PK no archive"):
        if data is not None:
            cell.eeprom.write_bytes(data)
        assert cell.mode("9.7") == "EEPROM data n. valid"
    assert (cell.folder / "P.QLL").read_text() == SOURCE["P.QLL"]


def test_a_cell_without_an_eeprom_has_no_such_option(tmp_path: pathlib.Path) -> None:
    cell = EepromCell(tmp_path, eeprom="").stopped()
    assert [cell.mode("9.6"), cell.mode("9.7")] == ["Option not found", "Option not found"]


def test_the_pendant_switches_the_movement_and_steps(tmp_path: pathlib.Path) -> None:
    cell = EepromCell(tmp_path)
    assert cell.mode("5.10") == "WITHOUT movement"
    assert cell.mode("5.10") == "WITH movement"
    assert cell.mode("5.9") == "no process"
