"""System programs of the control: SYVARINI, calibration and activation of the 6D mouse (L1282, L2043-2067, L3034-3111; AX-1766)."""

import math
import pathlib
import re
from dataclasses import replace

import pytest

from gateway.assembly.listings import robotstar_listing
from gateway.assembly.robotstar import RobotstarPrograms
from gateway.assembly.run import RunPlan
from gateway.commands.robotstar import main as command
from gateway.files.robotstar import shipped, with_system, with_system_used
from gateway.pure.languages.base.faults import Faults
from gateway.pure.languages.robotstar.checker import check
from gateway.pure.languages.robotstar.kept import written
from gateway.pure.languages.robotstar.memory import Memory, Source
from gateway.pure.languages.robotstar.path import Defaults
from gateway.pure.languages.robotstar.robot import MODES
from gateway.pure.languages.robotstar.system import DEFAULTS
from gateway.pure.languages.robotstar.values import Array
from gateway.pure.languages.robotstar.virtual import VirtualCell
from gateway.services.reis_memory import program as opened
from hil_tests.lab.virtual.baps2_bench import VirtualPort
from hil_tests.lab.virtual.reis_bench import CELL, ReisCell, at, main
from hil_tests.unit.languages.robotstar.memory import WORDS, checked, run

SYSTEM = {source.path: source.text for source in shipped()}
SYVARINI = "$SYSTEM/$SYSMAK/SYVARINI.MPR"
MOVE = "TOOL T\nPOSITION #N, X:100, Y:0, Z:0, A:0, B:0, C:0\nSTOP"
RAW = (-520, -400, -440, -520, -400, -450)  # readings of a mouse that is held against the movement


def test_they_are_those_of_the_manual_and_without_a_fault() -> None:
    faults = Faults()
    memory = Memory.read(with_system([]), WORDS, faults)
    check(memory, faults, VirtualCell(memory, MODES["auto"]).system.names())
    assert [fault.text for fault in faults] == []
    data = {"MOUSE_KAL1", "MOUSE_KAL2", "MOUSE_PHG", "MOUSE_DAT"}
    assert {each.name for each in memory.all() if each.directory == "$SYSTEM/$DATA"} == data
    macros = {each.name for each in memory.all() if each.directory == "$SYSTEM/$SYSMAK" and each.kind == "MAC"}
    assert macros == {"AKTI_KAL1", "AKTI_KAL2", "AKTI_KPHG"}
    given = [line.split("source: ")[1].split(", destination: ") for line in SYSTEM[SYVARINI].splitlines() if "COPY" in line]
    assert {DEFAULTS[name]: float(value) for value, name in given} == Defaults().values


def test_what_a_memory_has_itself_is_not_added() -> None:
    own = [Source("X/Maus_Kal1.mpr", ""), Source("A.MPR", "MPR A\n1 VAR V_KALPHG[6]\nEND")]
    added = {source.path.rpartition("/")[2] for source in with_system(own)[2:]}
    assert "MOUSE_KAL1.MPR" not in added and "MOUSE_DAT.MPR" not in added and "MOUSE_KAL2.MPR" in added
    assert with_system_used([Source("P.MPR", "MPR P\nEND")], "P") == [Source("P.MPR", "MPR P\nEND")]
    assert len(with_system_used([Source("P.MPR", "MPR P\nAKTI_KAL1\nEND")], "P")) == 1 + len(SYSTEM)
    assert len(with_system_used([], "S:/$SYSTEM/$DATA/MOUSE_PHG")) == len(SYSTEM)


def test_syvarini_gives_values_when_the_control_is_switched_on() -> None:
    body = "COPY 50.0, _RDEF_VEL_CP\nCOPY 1, _IDEF_MOVMOD"
    ran = run({"P.MPR": MOVE, SYVARINI: body})
    target = next(event for event in ran.cell.events if event["what"] == "target")
    assert (target["mode"], ran.state, ran.texts()) == ("LINEAR", "stopped", [])
    assert run({"P.MPR": MOVE, "SYVARINI.SPR": body}).texts() == [], "as the sub-program it is called, too (L1282)"
    changed = f"COPY 0, _IDEF_MOVMOD\n{MOVE}"
    again = run({"P.MPR": changed, SYVARINI: body}, at=("100 POWER", "101 START P"))
    assert [event["mode"] for event in again.cell.events if event["what"] == "target"] == ["LINEAR", "LINEAR"]


@pytest.mark.parametrize(
    ("step", "text"),
    [
        ("COPY 200, _ISPL_TENS", "_ISPL_TENS 200 is outside 0 .. 100"),
        ("WAIT 1", "SYVARINI only assigns values to variables: it neither waits nor moves the robot"),
        ('LABEL "A"\nBRANCH "A"', "SYVARINI only assigns values to variables: it neither waits nor moves the robot"),
        ("COPY 1", "program SYVARINI has faults: step 2: COPY: destination missing"),
    ],
)
def test_a_syvarini_that_is_wrong_is_reported_and_programs_run(step: str, text: str) -> None:
    ran = run({"P.MPR": MOVE, SYVARINI: step})
    assert ran.texts() == [text] and ran.message()["program"] == "$SYSTEM/$SYSMAK/SYVARINI"
    assert ran.targets() and ran.state == "stopped"


def test_in_a_cell_syvarini_of_the_memory_wins_over_values_kept_and_the_plc_of_the_cell_stays(tmp_path: pathlib.Path) -> None:
    folder = tmp_path / "memory"
    folder.mkdir()
    (folder / "P.MPR").write_text('MPR "P"\nEND\n')
    (folder / "$SYSTEM.VAL").write_text("_RDEF_VEL_CP = 33.0\n_IDEF_VELPTP = 44\n")

    def values() -> list[str]:
        assert CELL.controller is not None
        cell = replace(CELL, file=str(tmp_path / "cell.toml"), controller=replace(CELL.controller, memory="memory"))
        programs = RobotstarPrograms(RunPlan("made", cell, True, tmp_path, 4, {}, {}, {}, ()), VirtualPort(1))
        assert programs.read(lambda: None) == [] and programs.language.memory.find("AKTI_KAL1")
        found = robotstar_listing(cell, "$SYSTEM/$DATA/MOUSE_KAL1")
        assert found is not None and found.lines[0] == '1 MPR "MOUSE_KAL1"'
        kept = programs.language.values()["$SYSTEM"].splitlines()
        return [line for line in kept if line.split()[0] in ("_RDEF_VEL_CP", "_IDEF_VELPTP", "_SSTARTPLC")]

    assert values() == ["_IDEF_VELPTP = 44", "_RDEF_VEL_CP = 33.0", '_SSTARTPLC = "MAIN"'], "the one shipped is not run"
    (folder / "SYVARINI.MPR").write_text('MPR "SYVARINI"\nCOPY 50.0, _RDEF_VEL_CP\nCOPY "OTHER", _SSTARTPLC\nEND\n')
    assert values() == ["_IDEF_VELPTP = 44", "_RDEF_VEL_CP = 50.0", '_SSTARTPLC = "MAIN"']


def test_the_pendant_opens_them(tmp_path: pathlib.Path) -> None:
    path, rows = opened(tmp_path, "S:/$SYSTEM/$SYSMAK/AKTI_KPHG".removeprefix("S:"))
    assert path == "$SYSTEM/$SYSMAK/AKTI_KPHG.MAC" and rows[2:4] == ("MAUS_KALIB V_KALPHG", "AND 0FFFFFFFDH, _VERFAHR[3]")


def test_a_run_of_the_command_has_them_where_they_are_named(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "P.MPR").write_text('MPR "P"\nVAR I1\nEND\n')
    assert command(["run", str(tmp_path), "--program", "P", "--virtual", "--mode", "test2", "--json"]) == 0
    assert "V_KAL" not in capsys.readouterr().out
    assert command(["run", str(tmp_path), "--program", "MOUSE_PHG", "--virtual", "--mode", "test2"]) == 1
    assert "Calibration not possible" in capsys.readouterr().out, "nobody moves the mouse"


@pytest.mark.parametrize(("name", "way", "turn", "hand"), [("MOUSE_KAL1", 15, 5, True), ("MOUSE_PHG", 50, 10, False)])
def test_a_calibration_moves_in_each_direction_and_is_activated(name: str, way: float, turn: float, hand: bool) -> None:
    tool = main("VAR T, X:0, Y:0, Z:80, RX:0, RY:0, RZ:0", "V")
    quick = {path: re.sub(r"BAHN_ZEIT\[s\]: \d", "BAHN_ZEIT[s]: 0.4", text.replace("WAIT 1", "WAIT 0.1")) for path, text in SYSTEM.items()}
    cell = ReisCell(main(f"{at(884, 0, 500)}\nSTOP") | tool | quick)
    assert cell.run()[0] == "ended"
    start, joints, reached = cell.places[-1], cell.joints[-1], [0.0] * 0
    where: list[tuple[float, ...]] = []
    run_ = cell.start(f"$SYSTEM/$DATA/{name}")

    def watch() -> bool:
        """The mouse is pushed while the robot is off its start, more than half the way; then it is let go."""
        number = len(where) + (not reached)
        place, angles = cell.places[-1], zip(cell.joints[-1], joints, strict=True)
        off = math.dist(place[:3], start[:3]) / way if number < 4 else max(abs(a - b) for a, b in angles) / turn
        if off > 0.5:
            if not reached:
                where.append(place)
                cell.control.put(f"reis.mouse.{number}", float(RAW[number - 1]))
            if not reached or off >= max(reached):
                where[-1] = place
            reached.append(off)
        elif reached:
            cell.control.put(f"reis.mouse.{number}", 0.0)
            reached.clear()
        return run_ in cell.hosted.results

    cell.until(watch, 30)
    assert cell.hosted.results[run_][:2] == ("ended", 0) and len(where) == 6, (cell.told, where)
    moved = [[b - a for a, b in zip(start[:3], place[:3], strict=True)] for place in where[:3]]
    assert [math.hypot(*vector) for vector in moved] == pytest.approx([way] * 3, abs=0.1)
    axes = ((-1, 0, 0), (0, 1, 0), (0, 0, -1))  # of the hand, A 180, B 0, C 180
    wanted = [[-way * part for part in axis] for axis in axes] if hand else [[-way * float(n == m) for m in range(3)] for n in range(3)]
    assert moved == [pytest.approx(vector, abs=0.1) for vector in wanted], "along the axes of the hand or of the world"
    machine = cell.language.machine
    assert [list(row) for row in machine.mouse.translation] == [pytest.approx(row) for row in ((-1, 0, 0), (0, -1, 0), (0, 0, -1))]
    field = machine.system["_VERFAHR"]
    assert isinstance(field, Array) and written({"I": field.items[2]}) == f"I = {2 if hand else 0}\n"
    assert cell.where() == pytest.approx((884, 0, 580), abs=0.1)


def test_a_whole_array_is_calibration_data_and_nothing_else_is() -> None:
    faults = {
        step: [fault.text for fault in checked({"P.MPR": f"VAR V_A[6]\nVAR V_B\nMAUS_KALIB {step}"})[1]]
        for step in ("V_A", "V_B", "V_A[1]", "V_C")
    }
    assert faults["V_A"] == [] and [len(found) for found in faults.values()] == [0, 1, 1, 1]


def test_the_tool_without_a_definition_is_copied_as_the_flange() -> None:
    ran = run({"P.MPR": "VAR T1\nVAR T\nCOPY T, T1", "Q.MPR": "VAR T2\nCOPY T, T2\nCOPY 5, T2.X"}, "Q")
    assert ran.texts() == ["Variable not initialized!"], "T is defined by P"
    ran = run({"Q.MPR": "VAR T2\nCOPY T, T2\nADD 5, T2.X"}, "Q")
    assert ran.texts() == [] and ran.value("T2.X") == 5.0
    assert run({"Q.MPR": "COPY 5, T.X"}, "Q").texts() == ["Definition not found!"]


def test_uebercp_of_the_rsiv_is_a_system_variable() -> None:
    ran = run({"P.MPR": "VAR I1\nVAR I2\nUEBER_CP[%]: 50\nCOPY _IV_FLYBY_S, I1\nUEBER_CP 40\nCOPY _IV_FLYBY_S, I2"})
    assert (ran.value("I1"), ran.value("I2")) == (50, 40)
