"""Programs that TRAFO_6D makes in a cell are programs of the memory: they are on the disk, with their values (L3271, L3115-3119)."""

import pathlib
from collections.abc import Callable
from dataclasses import replace

import pytest

from gateway.assembly.robotstar import RobotstarPrograms
from gateway.assembly.run import RunPlan
from gateway.files import robotstar, safe_file
from gateway.files.robotstar_directory import copy, rename
from gateway.pure.languages.robotstar.kept import restore, written
from gateway.pure.languages.robotstar.operands import Number
from gateway.runtime import unwritten
from hil_tests.lab.virtual.baps2_bench import VirtualPort
from hil_tests.lab.virtual.reis_bench import CELL

REFERENCE = 'MPR "REF"\nVAR RARR[7]\nTOOL T\nPOSITION #N, X:0, Y:0, Z:0, A:0, B:0, C:0, A7:0\nEND\n'
SOURCE = """SPR "SRC"
VAR IGLOBAL
LOC_VAR ILOCAL
C two points; a comment line
ADD 1, ILOCAL
\\WAIT 3
POSITION #P, X:1.25, Y:0, Z:300.000001, A:0, B:0, C:180, Frame:0, A7:90
LABEL "A"
POSITION #N, X:-1234.567891, Y:2, Z:3, A:0, B:90, C:0, A7:-12.5
END
"""
MAIN = """MPR "P"
VAR ICTRL
LOC_VAR I
COPY 10, RARR[1]
COPY 20.5, RARR[2]
COPY 0, I
LABEL "N"
ADD 1, I
COPY 0, RARR[I]
TEST #VARIABLE, I, #<, 7, "N"
COPY 10.001, RARR[1]
COPY 1, ICTRL
TRAFO_6D "REF", "REF", "SRC", "{0}", ICTRL
STOP
END
"""


class Kept:
    """The memory of a cell in a folder, as its interpreter process has it; time passes for values that are written rarely."""

    def __init__(self, folder: pathlib.Path) -> None:
        assert CELL.controller is not None
        cell = replace(CELL, file=str(folder / "cell.toml"), controller=replace(CELL.controller, memory="memory"))
        self.folder = folder / "memory"
        self.programs = RobotstarPrograms(RunPlan("made", cell, True, folder, 4, {}, {}, {}, ()), VirtualPort(1))
        self.faults = self.programs.read(lambda: None)
        self.memory = self.programs.language.memory

    def run(self, name: str = "P") -> list[str]:
        """Up to the end of the program; faults of writing."""
        language = self.programs.language
        assert self.programs.refresh(lambda: None) is None
        language.start_run(name, 1, 0)
        for turn in range(1000):
            language.turn(turn * 10_000_000)
            if not language.runs:
                break
        assert language.rows()[0].state == "stopped" and not language.robot.fault, language.robot.fault
        return self.programs.write_back()

    def control(self) -> int:
        return int(written({"ICTRL": self.memory.globals["ICTRL"]}).split()[-1]) >> 16

    def names(self) -> list[str]:
        rows = self.programs.seen(0)["programs"]
        assert isinstance(rows, list)
        return [row["name"] for row in rows]


def memory(folder: pathlib.Path, destination: str = "DST", **files: str) -> Kept:
    (folder / "memory" / "Cells").mkdir(parents=True)
    for name, text in {"P.MPR": MAIN.format(destination), "REF.MPR": REFERENCE, "SRC.SPR": SOURCE, **files}.items():
        (folder / "memory" / name).write_text(text)
    return Kept(folder)


def test_a_program_made_by_trafo_6d_is_there_after_a_restart_with_its_values(tmp_path: pathlib.Path) -> None:
    kept = memory(tmp_path)
    assert restore("ILOCAL = 7", kept.memory.locals["SRC"]) == []
    assert "DST" not in kept.names()
    assert kept.run() == [] and kept.control() == 0 and "DST" in kept.names()
    made = kept.memory.find("DST")
    again = Kept(tmp_path)
    found = again.memory.find("DST")
    assert again.faults == [] and made is not None and found is not None and found.kind == "SPR"
    assert [(s.word, s.valid, dict(s.slots)) for s in found.steps if s.valid] == [
        (s.word, s.valid, dict(s.slots)) for s in made.steps if s.valid
    ]
    assert [s.text for s in found.steps] == [s.text for s in made.steps]
    assert [s.number for s in found.steps if not s.valid] == [2, 6], "the global definition and the step that was invalid before"
    assert written(again.memory.locals["DST"]) == "ILOCAL = 7\n"
    assert again.memory.owners["IGLOBAL"].name == "SRC"


def test_a_program_that_transforms_itself_is_written_and_goes_on(tmp_path: pathlib.Path) -> None:
    kept = memory(tmp_path, "SRC")
    (tmp_path / "memory" / ".protection").write_text("SRC.SPR = U\n")
    kept.programs.refresh(lambda: None)
    kept.memory = kept.programs.language.memory
    assert kept.run() == []
    assert kept.programs.refresh(lambda: None) is None, "its own writing is not a new file that lets a stopped program begin anew"
    again = Kept(tmp_path).memory.find("SRC")
    assert again is not None and again.locked == "U"
    assert [step.slots["X"] for step in again.steps if step.word == "POSITION"] == [Number(11.251), Number(-1224.566891)]


def test_what_it_overwrites_is_gone_with_its_values_and_its_locks(tmp_path: pathlib.Path) -> None:
    kept = memory(tmp_path, **{"DST.MPR": 'MPR "DST"\nVAR IOLD\nEND\n', "DST.MPR.VAL": "IOLD = 5\n", ".protection": "DST.MPR = EU\n"})
    assert kept.run() == []
    there = sorted(path.name for path in kept.folder.iterdir() if path.is_file() and path.name.startswith(("DST", ".")))
    assert there == [".protection", "DST.SPR"] and (kept.folder / ".protection").read_text() == ""


@pytest.mark.parametrize(
    ("name", "file"), [("S:/CELLS/dst", "Cells/DST.SPR"), ("\\CELLS\\DST", "Cells/DST.SPR"), ("S:/NEW/DST", "NEW/DST.SPR")]
)
def test_a_destination_with_a_path_is_a_file_there(tmp_path: pathlib.Path, name: str, file: str) -> None:
    kept = memory(tmp_path, name, **{"Cells/X.SPR": 'SPR "X"\nEND\n'})
    assert kept.run() == [] and kept.control() == 0
    assert (kept.folder / file).is_file() and Kept(tmp_path).memory.find("CELLS/DST" if "CELLS" in name else "NEW/DST")


@pytest.mark.parametrize("name", ["../DST", "S:/../../DST", "A/B/C/D/E/F/G/DST", "D" * 129, "A:/DST", "", ".DST"])
def test_a_name_that_no_file_of_the_memory_has_is_error_302(tmp_path: pathlib.Path, name: str) -> None:
    kept = memory(tmp_path, name)
    before = sorted(path for path in tmp_path.rglob("*"))
    assert kept.run() == [] and kept.control() == 302
    assert sorted(path for path in tmp_path.rglob("*") if path.suffix != ".VAL") == before


def test_a_program_of_this_name_in_another_directory_stays(tmp_path: pathlib.Path) -> None:
    kept = memory(tmp_path, **{"Cells/DST.SPR": 'SPR "DST"\nEND\n'})
    assert kept.run() == [] and kept.control() == 0
    assert (kept.folder / "Cells" / "DST.SPR").is_file() and (kept.folder / "DST.SPR").is_file()


def test_a_full_disk_leaves_the_old_file_and_is_reported_once(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old = 'SPR "DST"\nC old\nEND\n'
    kept = memory(tmp_path, **{"DST.SPR": old})

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(safe_file, "put_in_place", full)
    faults = kept.run()
    assert [fault for fault in faults if "DST.SPR: No space left on device; a program made by TRAFO_6D" in fault]
    assert (kept.folder / "DST.SPR").read_text() == old
    assert kept.programs.write_back() == []
    monkeypatch.undo()
    monkeypatch.setattr(unwritten, "AGAIN_S", 0.0)
    kept.programs._unwritten._due = 0.0  # a second later
    assert kept.programs.write_back() == []
    assert (kept.folder / "DST.SPR").read_text() != old, "it is tried again until there is space"
    assert (kept.folder / "P.MPR.VAL").read_text() == "I = 7\nICTRL = 1\n"
    assert kept.programs.refresh(lambda: None) is None, "its own writing is not a new file"


COUNTER = 'SPR "CNT"\nLOC_VAR ICOUNT, value:0\nADD 1, ICOUNT\nEND\n'
CALLER = 'MPR "Q"\nCALL "{0}"\nSTOP\nEND\n'


@pytest.mark.parametrize("change", [rename, copy])
def test_a_program_that_was_renamed_or_copied_goes_on_with_its_values(tmp_path: pathlib.Path, change: Callable[..., object]) -> None:
    kept = memory(tmp_path, **{"CNT.SPR": COUNTER, "Q.MPR": CALLER.format("CNT")})
    assert kept.run("Q") == [] and (kept.folder / "CNT.SPR.VAL").read_text() == "ICOUNT = 1\n"
    change(kept.folder, "CNT", "NEW")
    assert kept.programs.refresh(lambda: None) is not None
    assert kept.programs.language.values()["NEW.SPR"] == "ICOUNT = 1\n"


def test_a_program_that_is_put_into_the_memory_brings_its_values(tmp_path: pathlib.Path) -> None:
    kept = memory(tmp_path)
    for name, text in {"CNT.SPR.VAL": "ICOUNT = 7\n", "CNT.SPR": COUNTER, "Q.MPR": CALLER.format("CNT")}.items():
        (kept.folder / name).write_text(text)
    assert kept.programs.refresh(lambda: None) == []
    assert kept.run("Q") == [] and (kept.folder / "CNT.SPR.VAL").read_text() == "ICOUNT = 8\n"


def test_a_big_file_that_is_no_program_is_not_read(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robotstar, "MOST_BYTES", 1000)
    assert ["MANUAL.PDF is not a program" in fault for fault in memory(tmp_path, **{"MANUAL.PDF": "x" * 1001}).faults] == [True]
    with pytest.raises(OSError, match="not a letter"):
        memory(tmp_path / "damaged", **{".protection": "nothing\n"})
