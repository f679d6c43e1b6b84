"""The PHG of a ROBOTstar V: display, menus, entries, access.  Source: ROBOTstar V operating manual L1019-1558; AX-1660."""

import dataclasses

import pytest

from gateway.pure.controllers.reis.access import Codes, Level
from gateway.pure.controllers.reis.pendant.menus import MENUS
from gateway.pure.controllers.reis.pendant.phg import Phg
from gateway.pure.controllers.reis.pendant.unit import COLUMNS, LINES, MODE_KEYS, UNIT
from gateway.pure.controllers.reis.pendant.view import Order, View
from gateway.pure.controllers.reis.pendant.words import GERMAN

CODES, OPEN, STILL = Codes("1111", "2222", "9999"), Codes(), View()
FOLDERS = {
    "": [("PICK", "PICK         <DIR>"), ("MAIN.MPR", "MAIN         MPR      120 01.02.2003 04:05 -/A/E/S/U Var")],
    "PICK": [("GRIP.SPR", "GRIP SPR")],
}
STEPS = ["MPR MAIN", "TOOL T", "POSITION #N", "\\WAIT 2.0", "END"]


def pendant(codes: Codes = OPEN, view: View = STILL, language: str = "en") -> Phg:
    made = Phg(codes, language)
    made.listed(FOLDERS)
    made.see(view)
    made.orders.clear()
    return made


def keys(phg: Phg, words: str) -> list[Order]:
    """Presses them; the orders that come out."""
    for key in words.split():
        phg.press(key)
    found, phg.orders = phg.orders, []
    return found


def text(phg: Phg) -> str:
    return "\n".join(line.rstrip() for line in phg.lines())


def opened(codes: Codes = OPEN, view: View = STILL) -> Phg:
    made = pendant(codes, view)
    made.opened("MAIN.MPR", STEPS)
    return made


@pytest.mark.parametrize("mode", MODE_KEYS)
def test_every_mode_has_20_lines_with_override_place_and_menu(mode: str) -> None:
    """L1027-1035: the override as number and beam, step and place, menus for the function keys."""
    phg = pendant(view=View(54.0, "test2"))
    keys(phg, mode)
    lines = phg.lines()
    assert len(lines) == LINES and {len(line) for line in lines} == {COLUMNS}
    assert lines[0].startswith(" 54.00 % ") and lines[0].count("█") == 13
    assert lines[1].startswith("   1 S:/") and lines[1].endswith("TEST 2")
    phg.see(View(100.0))
    assert phg.lines()[0].count("█") == 24


def test_the_directory_is_walked_and_a_program_opened() -> None:
    """L1037-1056, L1082-1086."""
    phg = pendant()
    shown = phg.lines()
    assert shown[2].startswith(">  1 DIR /") and shown[3].startswith("   2 PICK         <DIR>") and shown[5].startswith("   4 END")
    keys(phg, "SHIFT RIGHT RIGHT")
    assert " 120 01.02.2003 04:05 -/A/E/S/U Var" in text(phg), "displaced by 20 characters and one (L1058-1061)"
    keys(phg, "ALT LEFT")
    assert keys(phg, "DOWN ENTER") == [] and "S:/PICK" in phg.lines()[1]
    assert phg.lines()[3].startswith("   2 ..  <DIR>")
    assert keys(phg, "DOWN DOWN ENTER") == [Order("open", "PICK/GRIP.SPR")]
    assert keys(phg, "UP ENTER") == [] and phg.directory.path == ""
    assert keys(phg, "F5 M A I N ENTER") == [Order("open", "MAIN")], "Prog sel"
    keys(phg, "F5 / P I C K ENTER")
    assert phg.directory.path == "PICK"
    keys(phg, "F5 / ENTER")
    assert phg.directory.path == "", "the slash alone is the master directory (L1141)"


def test_the_cursor_jumps_and_the_text_is_displaced() -> None:
    """L1058-1062, L1088-1096, L1466-1478."""
    phg = opened()
    phg.opened("LONG.MPR", [f"STEP {number} {'X' * 60}Y" for number in range(1, 41)])
    places = []
    for key in ("DOWN", "SHIFT DOWN", "ALT DOWN", "SHIFT UP", "ALT UP", "STEP 3 0 ENTER", "STEP 4 1 ENTER"):
        keys(phg, key)
        places.append(phg.listing.cursor)
    assert places == [2, 17, 40, 25, 1, 30, 30] and "no such step" in text(phg)
    columns = []
    for key in ("RIGHT", "SHIFT RIGHT", "LEFT", "ALT LEFT"):
        keys(phg, key)
        columns.append(phg.listing.column)
    assert columns == [1, 21, 20, 0]
    keys(phg, "ALT RIGHT")
    line = next(line for line in phg.lines() if line.startswith(">"))
    assert line[-1] == "Y", "the last character of the line at the right edge (L1474)"


@pytest.mark.requirement(
    "RSV-UI-01", by=("gateway.pure.controllers.reis.pendant.phg:Phg._denied", "gateway.pure.controllers.reis.pendant.phg:Phg._entered")
)
def test_without_a_code_word_only_start_and_stop_act() -> None:
    """L1544-1558: code word 1 opens the selection of program and step."""
    phg = opened(CODES, View(selected="MAIN", program="MAIN", step=1, state="stopped"))
    assert keys(phg, "START STOP") == [Order("start"), Order("stop")]
    assert keys(phg, "DOWN START") == [] and "needs code word 1" in text(phg)
    assert keys(phg, "RUN F2") == [] and "needs code word 1" in text(phg), "Test 2"
    assert keys(phg, "COORD F2") == [] and not phg.moves("1+")
    phg.opened("MAIN.MPR", STEPS)
    keys(phg, "MENU+ MENU+ F2 1 1 1")
    assert "***_" in text(phg) and "111" not in text(phg), "a code word is not shown"
    keys(phg, "1 ENTER")
    assert phg.access.level is Level.SETTER and "access level 2" in text(phg)
    assert keys(phg, "DOWN START") == [Order("start", "MAIN", 2)]
    assert keys(phg, "RUN F2") == [Order("test", "2")] and phg.moves("1+")
    phg.opened("MAIN.MPR", STEPS)
    keys(phg, "MENU+ MENU+ F2 0 ENTER")
    assert "unknown code word" in text(phg) and phg.access.level is Level.SETTER
    keys(phg, "F2 9 9 9 9 ENTER")
    assert "access level 4" in text(phg)
    keys(phg, "F2 ENTER")
    assert "access level 1" in text(phg), "an empty entry goes back"


def test_a_cell_without_code_words_has_nothing_locked() -> None:
    phg = opened()
    assert keys(phg, "DOWN START") == [Order("start", "MAIN", 2)]
    keys(phg, "MENU+ MENU+ F2")
    assert "this cell has no code words" in text(phg)


def test_start_begins_at_the_cursor_and_goes_on_where_nobody_moved_it() -> None:
    """L1206-1209, L1260-1266: the cursor follows; a step that is selected ends what was interrupted."""
    phg = opened(view=View(selected="MAIN", program="MAIN", step=2, state="stopped"))
    assert phg.listing.cursor == 2 and keys(phg, "START") == [Order("start")]
    phg.see(View(selected="MAIN", program="MAIN", step=4, state="running"))
    assert phg.listing.cursor == 4
    phg.see(View(selected="MAIN", program="GRIP", step=2, state="stopped"))
    assert phg.listing.cursor == 4 and keys(phg, "START") == [Order("start")], "it goes on in the sub-program"
    assert keys(phg, "UP START") == [Order("start", "MAIN", 3)]
    phg.opened("PICK/GRIP.SPR", ["SPR GRIP", "END"])
    assert keys(phg, "START START") == [Order("start", "PICK/GRIP", 1), Order("start")]


def test_run_and_coor_choose_modes() -> None:
    """L1215-1264, L1306-1337."""
    phg = pendant()
    assert keys(phg, "RUN F1 F5 MENU+ F4 F2") == [Order("test", "1"), Order("test", "5"), Order("test", "6"), Order("plc")]
    assert keys(phg, "MENU- F6") == [] and "AUTO is RC input 23" in text(phg)
    phg.see(View(mode="auto"))
    assert keys(phg, "F1") == [] and "RC input 23 ends it" in text(phg) and "AUTO" in phg.lines()[1]
    phg.see(View(axes=(("A1", 12.5, "deg"),), pose=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)))
    assert keys(phg, "COORD F2") == [Order("coor", number=1)] and "X              1.000 mm" in text(phg)
    assert keys(phg, "F1 F3 F6 F4 F5") == [
        Order("coor", number=0), Order("coor", number=2), Order("coor", number=3), Order("mouse", "t"), Order("mouse", "r"),
    ]  # fmt: skip
    assert "A1            12.500 deg" in text(phg)
    assert keys(phg, "MENU+ F1 F6") == [Order("macro", "AKTI_KAL1"), Order("macro", "MOUSE_PHG")]


def test_position_control_turns_the_override_into_millimetres() -> None:
    """L187-193."""
    phg = pendant(view=View(54.0))
    assert keys(phg, "OV+ OV-") == [Order("override", number=1), Order("override", number=-1)]
    assert keys(phg, "PC-I") == [] and "Position Control needs tXYZ or tUVW" in text(phg)
    phg.see(View(54.0, coor=1))
    assert keys(phg, "PC-I") == [Order("position", number=54.0)]
    phg.see(View(54.0, coor=1, position=54.0))
    assert phg.lines()[0].startswith(" 54.00 mm") and keys(phg, "OV- PC-O") == [Order("wheel", number=-1), Order("position")]


def test_information_windows_count_as_the_manual_does() -> None:
    """L1341-1368."""
    markers = bytes([0x78, 0x56, 0x34, 0x12, 1, 0, 0, 0, 0xFF]) + bytes(2039)
    view = View(axes=(("A1", 90.0, "deg"),), increments=(1024,), inputs=bytes([1, 0x80, 3]) + bytes(37), outputs=bytes(40), markers=markers)
    phg = pendant(view=view)
    keys(phg, "INFO F3")
    assert "A1              1024 inc" in text(phg)
    keys(phg, "MENU+ F1")
    assert "  0-1   10000000 00000001" in text(phg) and "  2-3   00000000 00000011" in text(phg), "byte 0 bit 0 on the right"
    keys(phg, "F3")
    assert "_SPS[1]   12345678  00000001" in text(phg) and "_SPS[3]   000000FF" in text(phg)
    keys(phg, "SHIFT DOWN")
    assert "_SPS[31]" in text(phg) and "_SPS[1] " not in text(phg)
    keys(phg, "QUIT")
    assert "_SPS" not in text(phg) and phg.orders == []
    assert keys(phg, "MENU- F4 I _ A [ 2 ] ENTER") == [Order("look", "I_A[2]")]
    phg.see(dataclasses.replace(view, looked=("I_A[2]", -1, "")))
    assert all(words in text(phg) for words in ("dec -1", "hex FFFFFFFFH", f"bin {'1' * 32}B"))
    phg.see(dataclasses.replace(view, looked=("I_B", None, "Definition not found!")))
    assert "Definition not found!" in text(phg)


def test_err_enab_and_the_status_window() -> None:
    """L1252, L1359-1360."""
    phg = pendant(view=View(mode="test5", message="Servoregulator error 667", program="MAIN", step=3, state="running"))
    assert "Servoregulator error 667" in text(phg) and "EXEC    MAIN 3 running" in text(phg)
    assert keys(phg, "INFO F5") == [Order("suppress")]
    keys(phg, "F6")
    assert "Servoregulator" not in text(phg)
    keys(phg, "F6")
    phg.see(View(synchronous=False))
    assert "not synchronous" in text(phg)


def test_f1_and_f2_are_the_levels_of_an_input_that_is_simulated() -> None:
    """L1219."""
    phg = opened(view=View(mode="test1", waits="F1 or F2"))
    assert phg.lines()[-2].split()[1:3] == ["Level", "Level"] and keys(phg, "F1 F2 F3") == [Order("level", "f1"), Order("level", "f2")]


def test_files_are_deleted_copied_renamed_and_protected_by_two_answers() -> None:
    """L1118-1183, L1404-1423."""
    phg = pendant()
    assert keys(phg, "DOWN DOWN F3 ENTER") == [Order("delete", "MAIN.MPR", more="MAIN.MPR")], "the program at the cursor is offered"
    assert keys(phg, "F4 ENTER N E W ENTER") == [Order("copy", "MAIN.MPR", more="NEW")]
    assert keys(phg, "MENU+ F5 ENTER N E W ENTER") == [Order("rename", "MAIN.MPR", more="NEW")]
    assert keys(phg, "FUNCT F3 M A I N ENTER L S ENTER") == [Order("protect", "MAIN", more="LS")]
    assert keys(phg, "DIR F3 QUIT") == [Order("list")], "QUIT leaves an entry"


def test_find_goes_on_behind_the_cursor_and_begins_again() -> None:
    phg = opened()
    found = []
    for words in ("T O", "E N D", "W A I T", "N O N E"):
        keys(phg, f"MENU+ MENU+ F1 {words} ENTER MENU+")
        found.append(phg.listing.cursor)
    assert found == [2, 5, 4, 4] and phg.overlay.notice == ""
    keys(phg, "MENU- F1 X ENTER")
    assert "not found" in text(phg)


@pytest.mark.parametrize("mode", MENUS)
def test_every_key_of_every_menu_acts_or_says_why_not(mode: str) -> None:
    key = {each: name for name, each in MODE_KEYS.items()}.get(mode, "")
    for level, menu in enumerate(MENUS[mode]):
        for number, item in enumerate(menu, 1):
            phg = opened(view=View(50.0))
            before = text(phg)
            orders = keys(phg, f"{key} {'MENU+ ' * level}F{number}")
            orders = [order for order in orders if order != Order("list")]
            assert bool(item.act) != bool(item.absent), item
            assert orders or text(phg) != before, f"{mode} {item.label}: nothing happens"
            assert not item.absent or item.absent in " ".join(text(phg).split()), item


def test_every_sentence_is_said_in_german() -> None:
    for menu in (menu for mode in MENUS.values() for menu in mode):
        assert all(item.absent in GERMAN for item in menu if item.absent), menu
    phg = pendant(CODES, language="de")
    keys(phg, "RUN F1")
    assert "braucht Codewort 1" in text(phg)
    keys(phg, "STEP")
    assert "Schritt:" in text(phg)


def test_any_key_in_any_state_leaves_20_lines() -> None:
    phg = opened(CODES, View(10.0, "test1", message="A" * 200, looked=("X" * 90, "Y" * 400, "")))
    names = sorted(UNIT.names)
    for turn in range(3 * len(names)):
        phg.press(names[turn * 7 % len(names)])
        phg.press(names[turn * 5 % len(names)])
        assert [len(line) for line in phg.lines()] == [COLUMNS] * LINES
