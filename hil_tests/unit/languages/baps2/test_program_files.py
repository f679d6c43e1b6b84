"""axisgate program put, get, compile: what is written, what is refused whole."""

import json
import pathlib
import shutil

import pytest

import configs
from gateway.commands.program import main
from gateway.files.program_memory import baps2_words, folder_memory
from gateway.pure.languages.baps2.dry_run import DryRun
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import decoded
from gateway.pure.languages.base.store import MemoryStore
from gateway.runtime.exit_codes import Exit
from hil_tests.unit.languages.baps2.words import WORDS

CELLS = pathlib.Path(configs.__file__).parent / "cells"
GOOD = "PROGRAM PICK\nOUTPUT : 1 = O\nBEGIN\nO = 1\nPROGRAM_END\n"
BAD = "PROGRAM BAD\nBEGIN\nX = 1\nPROGRAM_END\n"
GIVES = "PROGRAM GIVES\nPUBLIC INTEGER : N\nBEGIN\nN = 1\nPROGRAM_END\n"
TAKES = "PROGRAM TAKES\nEXTERNAL GIVES : N\nINTEGER : M\nBEGIN\nM = N\nPROGRAM_END\n"


@pytest.fixture
def cell(tmp_path: pathlib.Path) -> str:
    shutil.copytree(CELLS / "palletiser", tmp_path / "palletiser")
    shutil.copy(CELLS / "palletiser.toml", tmp_path)
    (tmp_path / "new").mkdir()
    (tmp_path / "new/pick.qll").write_text(GOOD)
    (tmp_path / "new/BAD.QLL").write_text(BAD)
    return str(tmp_path / "palletiser.toml")


def test_files_go_into_the_memory_of_a_cell_all_or_none(cell: str, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    memory, pick = tmp_path / "palletiser", tmp_path / "new/pick.qll"
    assert main(["put", cell, str(pick), "--json"]) == Exit.OK
    assert json.loads(capsys.readouterr().out) == [str(memory / "PICK.QLL")] and (memory / "PICK.QLL").read_text() == GOOD
    pick.write_text(GOOD.replace("O = 1", "O = 0"))
    other = tmp_path / "new/OTHER.QLL"
    other.write_text(GOOD)
    assert main(["put", cell, str(other), str(pick)]) == Exit.INVALID
    assert "has PICK.QLL already; --force replaces it, nothing was written" in capsys.readouterr().err
    assert not (memory / "OTHER.QLL").exists() and (memory / "PICK.QLL").read_text() == GOOD
    assert main(["put", cell, str(pick), "--force"]) == Exit.OK
    assert (memory / "PICK.QLL").read_text() == pick.read_text()
    assert main(["put", cell, str(tmp_path / "new/BAD.QLL")]) == Exit.FINDING, "it is kept, and cannot run"
    assert (memory / "BAD.QLL").exists() and "name-unknown" in capsys.readouterr().err
    assert main(["put", cell, str(tmp_path / "nowhere.qll")]) == Exit.INVALID


def test_files_come_out_of_the_memory_and_replace_nothing(cell: str, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "saved"
    assert main(["get", cell, "pallet", "--to", str(out)]) == Exit.OK
    assert (out / "PALLET.QLL").read_bytes() == (tmp_path / "palletiser/PALLET.QLL").read_bytes()
    assert {path.stem for path in out.iterdir()} == {"PALLET"}
    assert main(["get", cell, "pallet", "--to", str(out)]) == Exit.INVALID and "already" in capsys.readouterr().err
    assert main(["get", cell, "NOBODY", "--to", str(tmp_path / "else")]) == Exit.INVALID
    assert "has no NOBODY; it has" in capsys.readouterr().err and not (tmp_path / "else").exists()


def test_a_translation_leaves_ird_or_err(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "A.QLL").write_text(GOOD.replace("PICK", "A"))
    (tmp_path / "A.ERR").write_text("old")
    (tmp_path / "BAD.QLL").write_text(BAD)
    (tmp_path / "BAD.IRD").write_text("old")
    assert main(["compile", str(tmp_path), "a", "BAD"]) == Exit.FINDING
    assert sorted(path.name for path in tmp_path.iterdir()) == ["A.IRD", "A.QLL", "BAD.ERR", "BAD.QLL"]
    assert "BAD.QLL:3:1: error" in (tmp_path / "BAD.ERR").read_text()
    assert main(["compile", str(tmp_path), "NOBODY"]) == Exit.INVALID


@pytest.mark.requirement("RHO-BAP-07", by="gateway.pure.languages.baps2.translated:age_of")
def test_an_importer_translated_before_its_exporter_is_warned(tmp_path: pathlib.Path) -> None:
    (tmp_path / "GIVES.QLL").write_text(GIVES)
    (tmp_path / "TAKES.QLL").write_text(TAKES)

    def warnings() -> list[str]:
        memory = folder_memory(tmp_path)
        run = DryRun(Library(baps2_words(), memory), memory, Feed())
        run.run("GIVES")
        run = DryRun(Library(baps2_words(), memory), memory, Feed())
        run.run("TAKES")
        return [str(event["text"]) for event in run.trace if event["event"] == "warning"]

    assert warnings() == []
    assert main(["compile", str(tmp_path), "TAKES", "GIVES"]) == Exit.OK
    assert warnings() == ["TAKES is older than GIVES, whose data it imports"]
    assert main(["compile", str(tmp_path), "TAKES"]) == Exit.OK
    assert warnings() == []
    assert main(["compile", str(tmp_path), "GIVES"]) == Exit.OK and len(warnings()) == 1
    (tmp_path / "GIVES.QLL").write_text(GIVES + "\n")
    assert warnings() == [], "after a change of the source its age is void"


def test_a_translation_without_its_source_is_refused_in_words(tmp_path: pathlib.Path) -> None:
    (tmp_path / "OLD.IRD").write_bytes(b"\x00\x01\x02")
    library = Library(baps2_words(), folder_memory(tmp_path))
    assert list(library.names()) == ["OLD"]
    unit, faults = library.unit("OLD")
    assert unit is None and [each.text for each in faults] == ["OLD.IRD is a translation; axisgate runs sources"]


def test_a_file_that_others_include_is_checked_with_them() -> None:
    files = {"P.QLL": "PROGRAM P\n;;INCLUDE DECL\nBEGIN\nI = 1\nX = 2\nPROGRAM_END\n", "DECL.QLL": "INTEGER : I\nREAL : I\n"}
    library = Library(WORDS, MemoryStore(files))
    _, faults = library.check("some/folder/decl.qll", files["DECL.QLL"])
    assert [(each.id, each.position.file, each.position.line) for each in faults] == [("declared-twice", "DECL.QLL", 2)]
    _, alone = Library(WORDS, MemoryStore({})).check("DECL.QLL", files["DECL.QLL"])
    assert [each.id for each in alone] == ["no-program"]


def test_included_subroutines_are_checked_with_the_program() -> None:
    files = {
        "P.QLL": "PROGRAM P\nOUTPUT : 1 = LAMP\nBEGIN\nBLINK\nPROGRAM_END\n;;INCLUDE SUBS\n",
        "SUBS.QLL": "SR BLINK\nBEGIN\nLAMP = 1\nSR_END\n",
    }
    assert Library(WORDS, MemoryStore(files)).check("SUBS.QLL", files["SUBS.QLL"])[1].rows() == []
    alone = Library(WORDS, MemoryStore({})).check("SUBS.QLL", files["SUBS.QLL"])[1]
    assert [each.id for each in alone] == ["name-unknown"]


def test_a_program_that_includes_itself_is_one_fault() -> None:
    text = "PROGRAM P\n;;INCLUDE P\nBEGIN\nPROGRAM_END\n"
    _, faults = Library(WORDS, MemoryStore({"P.QLL": text})).check("some/folder/P.QLL", text)
    assert [(each.id, each.position.line) for each in faults] == [("include-loop", 2)]


def test_includes_that_grow_without_end_are_one_fault() -> None:
    files = {f"B{n}.QLL": f";;INCLUDE B{n + 1}\n" * 10 for n in range(1, 15)}
    text = "PROGRAM P\n;;INCLUDE B1\nBEGIN\nPROGRAM_END\n"
    _, faults = Library(WORDS, MemoryStore({**files, "P.QLL": text})).check("P.QLL", text)
    assert [each.id for each in faults] == ["include-too-deep", "include-missing"]


@pytest.mark.parametrize("code_page", ["cp437", "cp850", "cp1252", "latin-1", "utf-8", "utf-8-sig", "utf-16"])
def test_umlauts_of_a_source_are_read_in_any_code_page(code_page: str) -> None:
    text = "PROGRAM P\n; Prüfung der Größe, Ä\nBEGIN\nWRITE 'prüfen, äöß'\nPROGRAM_END\n"
    assert decoded(text.encode(code_page)) == text


def test_frames_of_comments_are_no_umlauts() -> None:
    text = "; ╔══▀▄─ ÷╗\n; aΣ\nPROGRAM P\nBEGIN\nWRITE 'prüfen, öde'\nPROGRAM_END\n"
    assert decoded(text.encode("cp437")) == text


def test_nesting_without_end_is_one_fault() -> None:
    for opened, closed, count in (("BEGIN ", "END ", 500), ("IF I = 1 THEN ", "", 500), ("RPT 2 TIMES ", "RPT_END ", 40)):
        text = f"PROGRAM P\nINTEGER : I\nBEGIN\n{opened * count} I = 1 {closed * count}\nPROGRAM_END\n"
        _, faults = Library(WORDS, MemoryStore({})).check("P.QLL", text)
        assert [each.id for each in faults] == ["nesting-too-deep"], opened
