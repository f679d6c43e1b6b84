"""Mode 9.8 of the pendant in a cell: the SRAM card of a rho 3.0 (rho 3 releases L11424-11581)."""

import pathlib

import pytest

from hil_tests.unit.languages.baps2.test_eeprom import EepromCell

MEGABYTE = 1 << 20


def cell_with(folder: pathlib.Path, size: int | None = MEGABYTE) -> EepromCell:
    if size is not None:
        (folder / "card.img").write_bytes(b"")
        with (folder / "card.img").open("r+b") as card:
            card.truncate(size)
    return EepromCell(folder, hardware="rho3.0", card="card.img")


def initialised(cell: EepromCell) -> str:
    """The mode, ENTER on the first question, and on the second."""
    cell.mode("9.8")
    assert str(cell.control.functions.display.screen()[2]).rstrip() == "sure? (yes): ENTER"
    cell.panel.answer({"key": "ENTER"}, 1, cell.bench.now)
    cell.bench.run(0.6)
    return str(cell.control.functions.display.screen()[1]).rstrip()


def codes(cell: EepromCell) -> list[int]:
    return [each.code for each in cell.control.errors.records]


@pytest.mark.requirement("RHO-SYS-04", by="gateway.pure.languages.baps2.cell_eeprom:card_not_now")
def test_a_card_is_initialised_in_emergency_stop_alone_and_on_a_rho_3_0(tmp_path: pathlib.Path) -> None:
    cell = cell_with(tmp_path)
    assert initialised(cell) == "EMERGENCY STOP input" and (cell.folder / "P.QLL").exists()
    other = EepromCell(tmp_path, card="card.img").stopped()
    assert initialised(other) == "Option not active"


@pytest.mark.requirement("RHO-SYS-04", by="gateway.assembly.sram_card:card_refused")
def test_a_card_that_is_missing_protected_or_too_small_is_refused(tmp_path: pathlib.Path) -> None:
    cell = cell_with(tmp_path, None).stopped()
    assert initialised(cell) == "No SRAM-Card"
    card = tmp_path / "card.img"
    card.write_bytes(bytes(MEGABYTE - 1))
    assert initialised(cell) == "SRAM - Card too smal"
    card.write_bytes(bytes(MEGABYTE))
    card.chmod(0o444)
    assert initialised(cell) == "Write protection"
    assert (cell.folder / "P.QLL").exists(), "nothing is formatted"


@pytest.mark.requirement("RHO-SYS-04", by="gateway.pure.controllers.rho3.signals.control:RhoControl._look_at_memory")
def test_a_card_in_use_is_the_memory_and_has_to_stay(tmp_path: pathlib.Path) -> None:
    cell = cell_with(tmp_path).stopped()
    initialised(cell)
    assert cell.control.functions.phg.mode == "0", "the control starts up"
    cell.until(lambda: cell.control.pendant.phg.read("phg.34568") == MEGABYTE, 2.0)
    assert list(cell.folder.glob("*.QLL")) == [] and codes(cell).count(3622) == 0
    (tmp_path / "card.img").rename(tmp_path / "away.img")
    cell.until(lambda: 3622 in codes(cell), 2.0)
    again = EepromCell(tmp_path, hardware="rho3.0", card="card.img")
    again.until(lambda: 3883 in codes(again), 2.0)
    (tmp_path / "card.img").write_bytes(bytes(MEGABYTE))
    blank = EepromCell(tmp_path, hardware="rho3.0", card="card.img")
    blank.until(lambda: 3883 in codes(blank), 2.0)


def backed_up(cell: EepromCell) -> str:
    """The keys of the EPROM backup; line 3 then."""
    cell.panel.answer({"key": "ALT+MODE+DELETE+PERMISSION"}, 1, cell.bench.now)
    cell.bench.run(0.6)
    return str(cell.control.functions.display.screen()[2]).rstrip()


def test_the_keys_of_the_eprom_backup_empty_the_memory_in_emergency_stop_alone(tmp_path: pathlib.Path) -> None:
    cell = EepromCell(tmp_path)
    (cell.folder / "KEY.BNR").write_bytes(b"faulty")
    assert backed_up(cell) == "no EMERGENCY STOP" and (cell.folder / "P.QLL").exists()
    cell.stopped().mode("9.6")
    (cell.folder / "Q.QLL").write_text("PROGRAM Q\nBEGIN\nPROGRAM_END\n")
    cell.programs.refresh(lambda: None)
    assert backed_up(cell) == "" and cell.control.functions.phg.mode == "0", "the control starts up"
    assert sorted(each.name for each in cell.folder.glob("*.QLL")) == ["P.QLL"], "what the EEPROM has"
    cell.eeprom.unlink()
    backed_up(cell)
    assert list(cell.folder.glob("*.*")) == []


def test_the_keys_of_the_eprom_backup_take_another_card_or_the_internal_memory(tmp_path: pathlib.Path) -> None:
    cell = cell_with(tmp_path).stopped()
    initialised(cell)
    (tmp_path / "card.img").write_bytes(bytes(2 * MEGABYTE))
    other = EepromCell(tmp_path, hardware="rho3.0", card="card.img")
    other.until(lambda: 3883 in codes(other), 2.0)
    backed_up(other)
    other.until(lambda: other.control.pendant.phg.read("phg.34568") == 2 * MEGABYTE, 2.0)
    assert 3883 not in codes(other), "the new card is the memory"
    (tmp_path / "card.img").unlink()
    other.until(lambda: 3622 in codes(other), 2.0)
    backed_up(other)
    other.until(lambda: other.control.pendant.phg.read("phg.34568") == 128 * 1024, 2.0)
    assert codes(other).count(3622) == 0, "the internal memory again"
