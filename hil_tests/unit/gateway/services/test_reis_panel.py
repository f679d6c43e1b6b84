"""The pendant of a Reis in the services, built alone on a cell in virtual time: what its keys do there.  Source: robotstar 8.2; AX-1660."""

import pathlib
import time

import pytest

from gateway.pure.controllers.reis.access import Codes
from gateway.pure.controllers.reis.pendant.unit import COLUMNS, LINES
from gateway.services.reis_memory import answered, directories
from gateway.services.reis_panel import HELD_NS, ReisPanel
from hil_tests.lab.virtual.reis_bench import AUTO, SOURCE, ReisCell, at, main

OTHER = 2  # a command source without control
PATIENCE_S = 10.0
BODY = (
    "VAR I_N, 0\nTOOL T\n" + "\n".join(f"COPY {number}, I_N" for number in (11, 22, 33)) + f"\nMOVE_MODE #LINEAR\n{at(884, 100, 500)}\nSTOP"
)


class Operator:
    """A cell, its memory on disk and the pendant."""

    def __init__(self, folder: pathlib.Path, language: str = "en", body: str = BODY) -> None:
        files = {"P.MPR": f'MPR "P"\n{body}\nEND\n'} | main("STOP", "SUB/Q")
        for name, text in files.items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text(text)
        self.cell = ReisCell(files)
        self.panel = ReisPanel(self.cell.control, self.cell.bench.dispatcher, Codes(), language, (1.0,) * 6, folder)
        self.cell.bench.permit(AUTO, value=False)

    def asks(self, source: int = SOURCE, **request: object) -> list[str]:
        answer = self.panel.answer(dict(request), source, self.cell.bench.now)
        self.cycles(2)
        screen = answer["screen"]
        assert isinstance(screen, list)
        return screen

    def keys(self, words: str) -> str:
        for key in words.split():
            self.asks(key=key)
        return self.shows()

    def shows(self, words: str = "") -> str:
        """The display, once it has these words."""
        end = time.monotonic() + PATIENCE_S
        while words not in (text := "\n".join(self.asks())):
            assert time.monotonic() < end, f"{words!r} never: {text}"
        return text

    def cycles(self, count: int) -> None:
        for _ in range(count):
            self.panel.look(self.cell.bench.now)
            self.cell.bench.cycle()

    def value(self) -> object:
        return self.cell.value("I_N")


def test_a_program_is_opened_and_its_steps_are_started_from_the_cursor(tmp_path: pathlib.Path) -> None:
    """L1082-1086, L1206-1209, L1354-1358: directory, EDIT, Test 1 in single steps, a variable."""
    operator = Operator(tmp_path)
    assert "S:/" in operator.shows("P            MPR")
    operator.keys("DOWN ENTER")
    operator.shows('>  1 MPR "P"')
    operator.keys("RUN F1 STEP 5 ENTER START")
    operator.shows("TEST 1")
    operator.cell.until(lambda: operator.value() == "22")
    assert operator.cell.step() == 6, "one step, from the cursor on"
    assert ">  6 COPY 33, I_N" in operator.shows("P 6 stopped")
    operator.cycles(60)
    operator.panel.answer({"hold": "START"}, SOURCE, operator.cell.bench.now)
    operator.asks(release="START")  # a click shorter than a step of the control counts
    operator.cell.until(lambda: operator.value() == "33")
    assert not operator.panel._held
    operator.keys("INFO F4 I _ N ENTER")
    operator.shows("dec 33")
    operator.keys("F4 I _ X ENTER")
    operator.shows("Definition not found!")


def test_a_movement_key_moves_for_as_long_as_it_is_held_by_who_has_control(tmp_path: pathlib.Path) -> None:
    """L175, L1308-1326."""
    operator = Operator(tmp_path)
    hand = operator.cell.control.robot.keys.hand
    operator.keys("COORD F2")
    assert hand.coord == 1
    operator.keys("F1")
    before = operator.cell.joints[-1]
    assert "need control" in "\n".join(operator.asks(OTHER, hold="2+")) and hand.ways[1] == 0
    assert "hold the movement key" in "\n".join(operator.asks(key="2+")).replace("\n", " ") and hand.ways[1] == 0
    for _ in range(12):
        operator.asks(hold="2+")
        operator.cycles(8)
    assert operator.cell.joints[-1][1] > before[1] + 0.1 and operator.cell.joints[-1][0] == pytest.approx(before[0])
    operator.asks(release="2+")
    assert hand.ways[1] == 0
    panel, now = operator.panel, operator.cell.bench.now
    panel.answer({"hold": "3-"}, SOURCE, now)
    panel.look(now + HELD_NS - 1)
    assert hand.ways[2] == -1
    panel.look(now + HELD_NS)
    assert hand.ways[2] == 0, "who falls silent has let go"
    panel.answer({"hold": "3-"}, SOURCE, now)
    panel.answer({"hold": "3-"}, OTHER, now)
    assert hand.ways[2] == 0, "control is gone, and the movement with it"
    operator.keys("COORD F6")
    for _ in range(12):
        operator.asks(hold="1+")
        operator.cycles(4)
    assert "cannot be moved by hand: this robot has 6 axes" in " ".join(operator.asks(hold="1+")).replace("  ", " ")


def test_start_is_held_in_single_step_and_its_release_stops_the_robot(tmp_path: pathlib.Path) -> None:
    """L1203-1205: a position is approached directly, for as long as START is pressed; the tool stays in force."""
    operator = Operator(tmp_path)
    operator.shows("P            MPR")
    operator.keys("DOWN ENTER")
    operator.shows('MPR "P"')
    operator.keys("RUN F3 STEP 3 ENTER START")
    operator.shows("P 4 stopped")
    operator.cycles(60)
    operator.keys("STEP 8 ENTER")
    operator.asks(hold="START")
    operator.cycles(20)
    for _ in range(5):
        operator.asks(hold="START")
    assert operator.cell.hosted.run, (operator.cell.told, operator.shows())
    operator.asks(release="START")
    operator.cycles(5)
    assert operator.cell.hosted.run == 0


def test_a_step_that_does_not_move_goes_on_after_the_release_of_start(tmp_path: pathlib.Path) -> None:
    """L1204, L1218: dead man operation is of positions; an input is simulated with a hand that no longer presses START."""
    operator = Operator(tmp_path, body='VAR I_N, 0\nVAR V_S\nTESTE_BIT #EINGANG, #=1, 2, 0, "L"\nWAIT 0.5\nCOPY 7, I_N\nLABEL "L"\nSTOP')
    operator.shows("P            MPR")
    operator.keys("DOWN ENTER")
    operator.shows('MPR "P"')
    operator.keys("RUN F1 STEP 4 ENTER")
    for more, step in (("F1", 5), ("", 6), ("", 7)):
        operator.asks(hold="START")
        operator.asks(release="START")
        if more:
            operator.shows("Level Level")
            operator.keys(more)
        operator.cell.until(lambda: operator.cell.hosted.run == 0)
        operator.shows(f"P {step} stopped")
    assert operator.value() == "7"
    operator.keys("INFO F4 V _ S ENTER")
    operator.shows("Variable not initialized!")


def test_a_start_that_is_refused_says_why_on_the_display(tmp_path: pathlib.Path) -> None:
    operator = Operator(tmp_path)
    operator.shows("P            MPR")
    operator.keys("DOWN ENTER")
    operator.shows('MPR "P"')
    operator.keys("START")
    assert "START is refused: operating mode HAND" in " ".join(operator.shows().split())
    assert "START" not in operator.keys("DOWN"), "until the next key"


def test_in_a_german_cell_the_display_is_german(tmp_path: pathlib.Path) -> None:
    operator = Operator(tmp_path, "de")
    operator.shows("P            MPR")
    operator.keys("DOWN ENTER")
    operator.shows('MPR "P"')
    operator.keys("START")
    assert "START abgelehnt: Betriebsart HAND: AUTO" in " ".join(operator.shows().split())
    operator.keys("DIR")
    memory = operator.panel.memory
    assert memory is not None and memory.ask("open", "X")
    assert "es gibt kein Programm X" in operator.shows("es gibt kein Programm X")


def test_override_modes_and_messages_go_the_way_of_everybody(tmp_path: pathlib.Path) -> None:
    operator = Operator(tmp_path)
    operator.asks(OTHER, key="OV-")
    operator.cycles(5)
    assert operator.cell.bench.core.state.override == 1.0, "the regulator needs control"
    operator.keys("OV- OV-")
    operator.cycles(5)
    assert operator.cell.bench.core.state.override == pytest.approx(0.9)
    operator.keys("COORD F2 PC-I")
    hand = operator.cell.control.robot.keys.hand
    assert hand.position == pytest.approx(90.0) and operator.shows().startswith(" 90.00 mm")
    operator.keys("OV+ OV+ PC-O")
    assert hand.wheel == pytest.approx(0.2) and hand.position == 0
    operator.cell.control.message(4017, "Operating error 4017", operator.cell.bench.now)
    assert "Operating error 4017" in operator.shows()
    operator.keys("INFO F5")
    assert "4017" not in operator.shows(), "Err Enab"
    operator.cell.control.robot.show_again(operator.cell.bench.now)
    assert "4017" in operator.shows() and "4017" not in operator.keys("DIR QUIT")
    assert "no integrated PLC" in operator.keys("RUN MENU+ F2")
    assert "no such program" in operator.keys("F1").replace("\n", " ") or "HAND" in operator.keys("COORD MENU+ F4")


def test_an_unknown_key_is_an_error_and_the_answer_names_size_and_keys(tmp_path: pathlib.Path) -> None:
    operator = Operator(tmp_path)
    assert "not a key" in str(operator.panel.answer({"key": "MODE"}, SOURCE, 0)["error"])
    unit = operator.panel.answer({}, SOURCE, 0)["unit"]
    assert isinstance(unit, dict) and (unit["columns"], unit["lines"]) == (COLUMNS, LINES) and "1+" in unit["held"]


def test_files_of_the_memory_are_deleted_copied_renamed_and_protected(tmp_path: pathlib.Path) -> None:
    """L1039-1080, L1118-1183, L1404-1423."""
    (tmp_path / "P.MPR").write_text('MPR "P"\n\\WAIT 1.0\nEND\n')
    (tmp_path / "SUB").mkdir()
    assert [line[:18].strip() for _, line in directories(tmp_path)[""]] == ["P            MPR", "SUB          <DIR>"]
    assert answered(tmp_path, "copy", "P.MPR", "R").words == "done" and (tmp_path / "R.MPR").exists()
    assert answered(tmp_path, "rename", "R", "S").words == "done" and not (tmp_path / "R.MPR").exists()
    assert answered(tmp_path, "protect", "S", "L").words == "done"
    assert "protected against deletion" in answered(tmp_path, "delete", "S", "").words and (tmp_path / "S.MPR").exists()
    assert "-/A/E/S/U" in dict(directories(tmp_path)[""])["S.MPR"]
    assert answered(tmp_path, "delete", "P", "").words == "done" and not (tmp_path / "P.MPR").exists()
    found = answered(tmp_path, "open", "s", "")
    assert (found.path, found.rows) == ("S.MPR", ('MPR "S"', "\\WAIT 1.0", "END"))
    assert answered(tmp_path, "open", "NONE", "").words == "there is no program NONE"


def test_a_step_is_edited_deleted_and_made_invalid_at_the_cursor(tmp_path: pathlib.Path) -> None:
    """L1480-1482, L1496-1510: the file has it at once, START the same step; what is wrong is refused and changes nothing."""
    operator = Operator(tmp_path)
    file = tmp_path / "P.MPR"
    operator.shows("P            MPR")
    operator.keys("DOWN ENTER")
    operator.shows('MPR "P"')
    operator.keys("STEP 4 ENTER F1")
    assert "COPY 11, I_N_" in operator.shows("step edit:")
    operator.keys("ALT LEFT RIGHT RIGHT RIGHT RIGHT RIGHT RIGHT DELETE 7 ENTER")
    operator.shows(">  4 COPY 71, I_N")
    assert file.read_text().splitlines()[3] == "COPY 71, I_N"
    operator.keys("F1 DELETE DELETE DELETE DELETE DELETE ENTER")
    operator.shows("COPY: destination missing")
    assert file.read_text().splitlines()[3] == "COPY 71, I_N"
    operator.keys("F1 ALT LEFT RIGHT DELETE ENTER")
    operator.shows("the command word of a step is not edited")
    operator.keys("F4")
    operator.shows(">  4 \\COPY 71, I_N")
    operator.keys("STEP 5 ENTER F3")
    operator.shows(">  4 \\COPY 71, I_N")
    assert file.read_text().splitlines()[3:5] == ["\\COPY 71, I_N", "COPY 33, I_N"]
    operator.keys("F4")
    operator.shows(">  4 COPY 71, I_N")
    operator.keys(f"STEP 6 ENTER F1 {'DELETE ' * 8}SPACE # P T P ENTER")
    operator.shows(">  6 MOVE_MODE #PTP")
    for step in ("1", "9"):
        operator.keys(f"STEP {step} ENTER F3")
        assert "the first and the last step of a program stay" in " ".join(operator.shows("the first and the last").split())
    answered(tmp_path, "protect", "P.MPR", "E")
    operator.keys("STEP 4 ENTER F1 DELETE ENTER")
    operator.shows("P.MPR is protected against editing")


def test_numbers_of_steps_follow_a_deletion(tmp_path: pathlib.Path) -> None:
    (tmp_path / "Q.MPR").write_text('1 MPR "Q"\n2 VAR I\n\n3 WAIT 1\n4 WAIT 2\n5 END\n')
    assert answered(tmp_path, "change", "Q.MPR", "delete 3").step == 2
    assert (tmp_path / "Q.MPR").read_text() == '1 MPR "Q"\n2 VAR I\n\n3 WAIT 2\n4 END\n'
    (tmp_path / "M.PLC").write_text("PLC M\nU E0.0\n= A0.0\nEND\n")
    assert answered(tmp_path, "change", "M.PLC", "edit 2 U E9.9").words == "bit 9: outside 0..7"
    assert answered(tmp_path, "change", "M.PLC", "edit 2 U E9.7").rows[1] == "U E9.7"
    assert answered(tmp_path, "change", "M.PLC", "edit 9 U E9.7").words == "M.PLC has no step 9"


def test_the_step_executed_last_is_marked_while_the_program_is_stopped(tmp_path: pathlib.Path) -> None:
    """L1484-1486."""
    operator = Operator(tmp_path)
    operator.shows("P            MPR")
    operator.keys("DOWN ENTER")
    operator.shows('MPR "P"')
    operator.keys("RUN F1 STEP 5 ENTER START")
    operator.cell.until(lambda: operator.value() == "22")
    operator.shows("P 6 stopped")
    assert "-  5 COPY 22, I_N" in operator.shows(">  6 COPY 33, I_N")
