"""DAT files from real folders."""

import pathlib

from gateway.files.dat import MOST_BYTES, DatTables, read_tables


def test_both_names_in_any_case_the_interface_language_decides(tmp_path: pathlib.Path) -> None:
    (tmp_path / "Texte.dat").write_bytes("01='Stra\u00dfe \u00fcber'\r\n".encode("cp437"))
    (tmp_path / "TEXT.DAT").write_bytes(b"01='over the road'\r\n\x1a")
    (tmp_path / "mza.dat").write_bytes(b"1='x'\r\n08='lang'\r\n")
    german, english = read_tables(tmp_path, "de"), read_tables(tmp_path, "en")
    assert german.texts and german.texts.entries == {1: "Stra\u00dfe \u00fcber"} and german.texts.file == "Texte.dat"
    assert english.texts and english.texts.entries == {1: "over the road"}
    assert english.msd and english.msd.entries == {8: "lang"}, "the other language's file is better than none"
    assert [str(fault) for fault in english.faults] == ["mza.dat:1: '1': two decimal digits 01 to 99 expected"]
    assert english.programs is None and english.modes is None


def test_missing_folder_unreadable_and_endless_files(tmp_path: pathlib.Path) -> None:
    assert read_tables(tmp_path / "none") == DatTables()
    (tmp_path / "EXPROG.DAT").mkdir()
    (tmp_path / "MSD.DAT").write_bytes(b";" * (MOST_BYTES + 1))
    tables = read_tables(tmp_path)
    assert tables.programs is None
    assert [fault.text("de") for fault in tables.faults] == [f"MSD.DAT:0: Datei hat mehr als {MOST_BYTES} Bytes"]
