"""Rows of the manual that programs reach: copies, the display of the PHG, names of files in the language of the control."""

import pathlib

import pytest

from gateway.files.dat import read_tables
from hil_tests.lab.virtual.baps2_bench import ProgramCell, one
from hil_tests.unit.languages.baps2.running import body, run, written

COMMAND = "SPC_FCT : 4 = COMMAND (VALUE INTEGER : CMD TEXT : SOURCE, TARGET INTEGER : STATUS)\nTEXT : A, B\nINTEGER : S"
PAIRS = {"QLL": {"QLL", "ERR", "DAT"}, "DAT": {"QLL", "ERR", "DAT"}, "PKT": {"PKT"}, "SYM": {"SYM"}, "IRD": {"IRD"}}
KINDS = ("QLL", "ERR", "DAT", "PKT", "SYM", "IRD", "BNR")


@pytest.mark.requirement("RHO-SYS-05", by="gateway.pure.languages.baps2.special:Specials._copy")
@pytest.mark.parametrize("kind", sorted(PAIRS))
def test_a_file_is_copied_to_its_own_kinds_alone(kind: str) -> None:
    calls = "\n".join(f'A = "GIVEN.{kind}"\nB = "OTHER.{target}"\nCOMMAND(2, A, B, S)\nWRITE PHG, S' for target in KINDS)
    found = written(run(body(calls, COMMAND), **{f"GIVEN.{kind}": "; nothing"}))
    assert found == ["0" if target in PAIRS[kind] else "-2" for target in KINDS]


@pytest.mark.requirement("RHO-BAP-19", by="gateway.pure.controllers.rho3.signals.written_text:WrittenText.write")
def test_cls_clears_the_four_lines_of_the_phg() -> None:
    cell = ProgramCell(
        one("""WRITE PHG, CLS
IF VERSION < 2.31 THEN WRITE PHG, "OLD" ELSE WRITE PHG, "NEW"
DONE = 1
WAIT UNTIL GO = 1
WRITE PHG, CLS
DONE = 0
WAIT UNTIL GO = 0""", "INPUT : 1 = GO\nOUTPUT : 1 = DONE")
    )  # fmt: skip
    cell.start("P")
    cell.until(lambda: (1, True) in [each[1:] for each in cell.outputs])
    assert any(row.startswith("NEW") for row in cell.control.functions.display.screen())
    cell.give(1)
    cell.until(lambda: (1, False) in [each[1:] for each in cell.outputs])
    assert not any("NEW" in row for row in cell.control.functions.display.screen())


NAMES = {"en": ("MSD.DAT", "TEXT.DAT", "PHGCODE.DAT"), "de": ("MZA.DAT", "TEXTE.DAT", "PHGKODE.DAT")}


@pytest.mark.requirement("RHO-BAP-23", by="gateway.files.dat:read_tables")
@pytest.mark.parametrize("language", ["de", "en"])
def test_each_language_has_its_names_of_the_dat_files(tmp_path: pathlib.Path, language: str) -> None:
    for each, names in NAMES.items():
        for name, line in zip(names, (f"01='{each}'", f"01=PHG,'{each}'", "1 = 3.2" if each == "de" else "1 = 7.1"), strict=True):
            (tmp_path / name).write_text(line + "\r\n")
    tables = read_tables(tmp_path, language)
    assert tables.msd is not None and tables.texts is not None and tables.modes is not None
    assert language in str(tables.msd.entries) and language in str(tables.texts.entries)
    assert ("3.2" if language == "de" else "7.1") in str(tables.modes.entries)
