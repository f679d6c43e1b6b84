"""What the pendant has of the user memory of a cell: text lists, list of files, assignment of its keys."""

import pytest

from gateway.pure.controllers.rho3.functions.system_variables import VariableError
from gateway.pure.controllers.rho3.pendant.keys import FIXED, INDEX, KeyTable, standard
from gateway.services.rho3_panel import Rho3Panel
from hil_tests.lab.virtual.baps2_bench import ProgramCell, one

LONG = "\n".join(f"line {n}" for n in range(1, 1200))
NOTHING = one("WAIT 0.1")


def cell_with(**files: str) -> ProgramCell:
    cell = ProgramCell(NOTHING | {name.replace("_", "."): text for name, text in files.items()})
    cell.bench.run(0.5)
    return cell


@pytest.mark.requirement("RHO-PHG-04", by="gateway.pure.languages.baps2.cell_files:lines_of_list")
def test_a_line_of_a_text_list_is_a_variable() -> None:
    cell = cell_with(VTL005_DAT="first\r\nsecond\r\nPfad \u0084lter\r\nlast\r\n\x1a", VTL255_DAT=LONG)
    read = cell.control.pendant.phg.read
    assert [read(f"phg.34821.{n}") for n in (1, 2, 4, 5)] == ["first", "second", "last", ""]
    assert read("phg.34821.3").__class__ is str and str(read("phg.34821.3")).startswith("Pfad ")
    cell.until(lambda: read("phg.35071.999") == "line 999", 5.0)
    assert read("phg.34816.1") == ""
    with pytest.raises(VariableError, match="1 to 999"):
        read("phg.34821.1000")


@pytest.mark.requirement("RHO-PHG-04", by="gateway.pure.controllers.rho3.pendant.user_memory:UserMemory.hear")
def test_a_text_list_that_changes_or_goes_is_seen() -> None:
    cell = cell_with(VTL005_DAT="old one\nold two\nold three")
    files, read = cell.memory.files, cell.control.pendant.phg.read
    files["VTL005.DAT"] = b"new"
    cell.until(lambda: [read(f"phg.34821.{n}") for n in (1, 2)] == ["new", ""], 2.0)
    del files["VTL005.DAT"]
    cell.until(lambda: read("phg.34821.1") == "", 2.0)


def test_files_are_listed_with_size_and_date() -> None:
    cell = cell_with(A_DAT="x" * 848)
    cell.language.pendant.files.stamps["A.DAT"] = ("24.09.95", "09:40")
    read = cell.control.pendant.phg.read
    cell.until(lambda: read("phg.34561.1") == f"{'A.DAT':<12} {848:>8} Byte  24.09.95  09:40", 2.0)
    assert str(read("phg.34564.2")).strip() == "P.QLL"
    used = sum(len(data) for data in cell.memory.files.values())
    assert [read("phg.34568"), read("phg.34569"), read("phg.34570")] == [98304, used, 98304 - used]


def table_with(**codes: int) -> bytes:
    data = bytearray(standard())
    for place, code in codes.items():
        data[int(place.removeprefix("at"))] = code
    return bytes(data)


@pytest.mark.requirement("RHO-PHG-10", by="gateway.pure.controllers.rho3.pendant.keys:KeyTable.named")
def test_key_bnr_makes_another_key_of_a_place() -> None:
    cell = cell_with()
    cell.memory.files["KEY.BNR"] = table_with(at40=0x0A)
    cell.language.stop_all(cell.bench.now)  # the services begin anew
    cell.bench.run(0.5)
    panel = Rho3Panel(cell.control, cell.bench.dispatcher)
    for key in ("K17", "K21", "K34", "K29"):  # MODE 7 . 1
        panel.answer({"key": key}, 1, cell.bench.now)
    cell.bench.run(0.1)
    assert cell.control.functions.phg.mode == "0"
    panel.answer({"key": "K1"}, 1, cell.bench.now)
    cell.bench.run(0.1)
    assert cell.control.functions.phg.mode == "7.1", "K1 is ENTER"
    panel.answer({"key": "SHIFT+K29"}, 1, cell.bench.now)
    cell.bench.run(0.1)
    assert cell.control.functions.phg.mode == "7", "the left arrow"


@pytest.mark.requirement("RHO-PHG-10", by="gateway.pure.controllers.rho3.pendant.keys:KeyTable.load")
def test_a_faulty_file_gives_the_standard_keys_without_a_message() -> None:
    table = KeyTable()
    assert table.load(table_with(at40=0x0A)) and table.named("K1") == "ENTER"
    for place, _ in FIXED:
        assert not table.load(table_with(**{"at40": 0x0A, f"at{place}": 0x41}))
        assert table.named("K1") == "MOVE"
    for data in (b"", table_with(at40=0x0A)[:255], table_with(at40=0x0A) + b" "):
        assert not table.load(data) and table.named("K1") == "MOVE"
    cell = cell_with(KEY_BNR="no table")
    assert cell.control.memory.keys.named("K36") == "ENTER" and cell.told == []


def test_levels_and_keys_without_effect() -> None:
    table = KeyTable()
    named = [table.named(key) for key in ("K36", "K35", "K34", "SHIFT+K1", "ALT+K1", "SHIFT+K26", "K28", "ALT+K3", "SHIFT+K18")]
    assert named == ["ENTER", "DELETE", ".", "A", "_", "UP", None, None, "KIN"]
    assert [table.named("K5", mode) for mode in ("0", "6.1", "3.2.1")] == ["WAIT", None, None]
    assert table.named("K9", "6.1") == "BEGIN" and table.named("K9", "7.1") == "IF"
    assert table.named("ENTER") == "ENTER", "a name is a key by itself"
    assert table.load(table_with(at36=0x00)) and table.named("K9") is None
    shift = INDEX[31]
    assert table.load(table_with(**{f"at{shift}": 0x0A}))
    assert table.named("K32") == "ENTER" and table.named("SHIFT+K1") is None and table.named("ALT+K1") == "_"


SPCF16 = """SPC_FCT : 16 = PNT_SELECT (TEXT : PNT_FNAM TEXT : PNT_PNAM INT : RET_CODE)
TEXT : PNTFNAM, PNTPNAM
INT : RET
OUTPUT : 401 = CODE"""
POINTS = "HOME = (0, 0, 100, 0)\nSTARTPOS = (10, 20.5, 30, 45)\nROW[1] = (1, 1, 1, 1)\n"


def selecting(file: str, point: str) -> ProgramCell:
    body = f"PNTFNAM = '{file}'\nPNTPNAM = '{point}'\nRET = 99\nPNT_SELECT (PNTFNAM, PNTPNAM, RET)\nCODE = RET"
    cell = ProgramCell(one(body, SPCF16) | {"TEST.PKT": POINTS, "EMPTY.PKT": ""})
    cell.bench.run(0.5)
    assert cell.run("P")[:2] == ("ended", 0)
    cell.bench.run(0.3)
    return cell


def pressed(cell: ProgramCell, *keys: str) -> list[str]:
    """What stands on the pendant after these keys."""
    panel = Rho3Panel(cell.control, cell.bench.dispatcher)
    for key in keys:
        panel.answer({"key": key}, 1, cell.bench.now)
        cell.bench.run(0.1)
    cell.bench.run(0.3)
    return [line.rstrip() for line in cell.control.functions.display.screen()]


DEFINE = ("MODE", "0", ".", "4", ".", "1", "ENTER")


@pytest.mark.requirement("RHO-PHG-16", by="gateway.pure.languages.baps2.special:Specials._select")
@pytest.mark.parametrize(
    ("file", "point", "code"),
    [("TEST.PKT", "STARTPOS", 0), ("TEST.PKT", " ", 0), ("NONE.PKT", "STARTPOS", 3), ("TEST.DAT", "STARTPOS", 2), ("1.PKT", "X", 1)]
    + [("EMPTY.PKT", " ", 5), ("TEST.PKT", "NOWHERE", 12), ("TEST.PKT", "ROW[2]", 13), ("TEST.PKT", "ROW[1]", 0), ("TEST.PKT", "1X", 11)],
)
def test_special_function_16_says_what_is_wrong_with_a_selection(file: str, point: str, code: int) -> None:
    cell = selecting(file, point)
    assert cell.control.value("rho3.integer.output.401") == code
    assert (cell.control.memory.selected is not None) == (code == 0)


@pytest.mark.requirement("RHO-PHG-16", by="gateway.pure.controllers.rho3.pendant.user_memory:UserMemory.enter")
def test_mode_4_1_opens_the_selected_file_at_its_point_and_the_selection_is_used_up() -> None:
    cell = selecting("TEST.PKT", "STARTPOS")
    assert pressed(cell, *DEFINE)[:3] == ["4.1 TEST.PKT", "STARTPOS.1", "10"]
    assert pressed(cell, "DOWN")[1:3] == ["STARTPOS.2", "20.5"]
    assert pressed(cell, "LEFT", *DEFINE)[:3] == ["4.1 Define", "EMPTY.PKT", "TEST.PKT"], "it was for one selection"
    assert pressed(cell, "DOWN", "ENTER")[:3] == ["4.1 TEST.PKT", "HOME.1", "0"], "opened by the operator"


def test_an_empty_name_selects_the_first_point_and_a_mode_without_points_leaves_the_selection_alone() -> None:
    cell = selecting("TEST.PKT", " ")
    assert pressed(cell, "MODE", "0", ".", "7", ".", "1", "ENTER")[0].startswith("7.1")
    assert pressed(cell, *DEFINE)[:2] == ["4.1 TEST.PKT", "HOME.1"]
