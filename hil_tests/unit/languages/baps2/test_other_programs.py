"""What a program needs of other files: programs it starts or calls, files it includes (rho 3 releases part 2, L2476-2494, 5841-5873)."""

import json
import pathlib

import pytest

from gateway.commands.program import main
from gateway.pure.languages.baps2.dry_run import DryRun
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from hil_tests.lab.virtual.baps2_bench import HEAD, ProgramCell
from hil_tests.unit.languages.baps2.running import body, faults_of
from hil_tests.unit.languages.baps2.words import WORDS

SUBROUTINE = "SUBROUTINE SUBX (VALUE INTEGER : K)\nBEGIN\nSUB_END\n"


def test_a_program_that_is_not_there_is_a_warning_where_it_is_named_first() -> None:
    text = body("START GONE\nGONE(1, 2)\nPARALLEL\nSTART OTHER\nALSO\nSTART P\nSTOP LOST\nPARALLEL_END", "EXTERNAL : GONE, HERE")
    assert faults_of(text, HERE=body("HALT")) == [("program-missing", 2), ("program-missing", 7)]


def test_start_of_an_external_subroutine_is_a_warning() -> None:
    assert faults_of(body("START SUBX\nSUBX(1)", "EXTERNAL : SUBX"), SUBX=SUBROUTINE) == [("subroutine-started", 4)]


def test_what_a_program_was_checked_with_is_read_again_when_it_changes() -> None:
    memory = Memory({"P.QLL": body("B\nSTART LATER\nX = 1", "EXTERNAL E : X\n;;INCLUDE INC").encode(), "INC.QLL": b"INTEGER : N\n"})
    library = Library(WORDS, memory)

    def faults(name: str, text: str) -> list[str]:
        memory.files[f"{name}.QLL"] = text.encode()
        library.forget(name)
        return [fault.id for fault in library.unit("P")[1]]

    assert [fault.id for fault in library.unit("P")[1]] == ["import-missing", "name-unknown", "program-missing"]
    assert faults("E", body("HALT", "PUBLIC INTEGER : X")) == ["name-unknown", "program-missing"]
    assert faults("LATER", body("HALT")) == ["name-unknown"]
    assert faults("INC", "INTEGER : N\nEXTERNAL : B\n") == ["program-missing"]
    assert faults("B", "PROGRAM B\n;;INCLUDE BODY\nPROGRAM_END\n") == []
    assert faults("E", body("HALT", "PUBLIC BINARY : X")) == []
    assert faults("BODY", "BEGIN\nHALT\n") == []
    assert faults("E", body("HALT", "PUBLIC TEXT : X")) == ["type"]


def test_check_names_the_included_file_with_its_path(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "main.qll").write_text(body("X = 1", ";;INCLUDE HEAD"))
    (tmp_path / "head.qll").write_text("INTEGER : X\nEXTERNAL : GONE\nREAL : X\n")
    assert main(["check", str(tmp_path / "main.qll"), "--json"]) == 1
    rows = json.loads(capsys.readouterr().out)
    head = str(tmp_path / "head.qll")
    assert [(row["file"], row["line"], row["severity"], row["id"]) for row in rows] == [
        (head, 2, "warning", "program-missing"),
        (head, 3, "error", "declared-twice"),
    ]
    main(["check", str(tmp_path / "main.qll")])
    assert f"{head}:2:12: warning: program GONE does not exist" in capsys.readouterr().out


def test_an_error_is_in_the_file_of_its_line() -> None:
    """Of an external program, and of an included file; variables 34314 to 34318 of the PHG 2000."""
    files = {
        "P.QLL": f"{HEAD}PROGRAM P\nEXTERNAL : S1\nINTEGER : I\nBEGIN\nWAIT 0.1\nS1(I)\nPROGRAM_END\n",
        "S1.QLL": "SUBROUTINE S1(INTEGER : A)\nBEGIN\nWAIT 0.2\nA = 1 / A\nSUB_END\n",
        "Q.QLL": f"{HEAD}PROGRAM Q\nINTEGER : I\nBEGIN\nI = 5\n;;INCLUDE BODY\nI = 1\nPROGRAM_END\n",
        "BODY.QLL": "I = 0\n;;INCLUDE SLOW\nI = 1 / I\n",
        "SLOW.QLL": "\n\nWAIT 0.1\n",
        "T.QLL": f"{HEAD}PROGRAM T\nINTEGER : I\nBEGIN\n;;INCLUDE FAR\nMOVE TO (210, 60, 40, 12)\nWAIT 1\nPROGRAM_END\n",
        "FAR.QLL": "MOVE TO (200, 60, 40, 12)\n\nMOVE LINEAR TO (99999, 60, 40, 12)\n",
    }
    cell = ProgramCell(files)
    run = cell.start("P")
    cell.bench.run(0.2)
    process = cell.control.processes.processes[0]
    assert (process.external, process.level, process.line) == ("S1", 1, 3)
    assert cell.ends(run)[1:] == (209, "division by zero", "S1.QLL line 4")
    run = cell.start("Q")
    cell.bench.run(0.05)
    included = cell.control.processes.named("Q")
    assert included is not None
    assert (included.external, included.line, included.include_line) == ("", 9, 3), "34317: INCLUDE in the program; 34318: line of its file"
    assert cell.ends(run)[3] == "BODY.QLL line 3"
    assert cell.run("T")[3] == "FAR.QLL line 3", "the program is prepared further than the block that failed"


@pytest.mark.parametrize("points, kept", [("DANA.PKT", "DANA.PKT"), ("P.PKT", "P.PKT")], ids=["of the source", "of the program"])
def test_points_are_those_of_the_source_of_a_program(points: str, kept: str) -> None:
    """DANA.PKT belongs to DANA.QLL (L668), whatever its program is called; a file of the program's name is taken where that is missing."""
    text = body("MOVE TO HOME\nLAST = HOME", "DEF POINT : LAST")
    memory = Memory({"DANA.QLL": text.encode(), points: b"HOME = (1, 2, 3, 4)\n"})
    machine = DryRun(Library(WORDS, memory), memory, Feed())
    assert machine.run("DANA") is None
    assert [event["target"] for event in machine.trace if event["event"] == "move"] == [[1, 2, 3, 4]]
    assert memory.text(kept) == "HOME = (1, 2, 3, 4)\nLAST = (1, 2, 3, 4)\n" and len(memory.files) == 2
