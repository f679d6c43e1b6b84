"""Texts of old controllers in any code page."""

import pathlib

import pytest

from gateway.files.old_text import decoded
from gateway.files.plc_programs import read_listing
from gateway.files.robotstar import sources

TEXT = "1 MPR ÜBER\r\n2 VAR I_ZÄHLER\r\n3 C größer, Übergabe öffnen\r\n4 ENDE\r\n"


@pytest.mark.parametrize("page", ["utf-8", "utf-8-sig", "utf-16", "cp850", "cp437", "cp1252", "latin-1"])
def test_umlauts_are_read_as_they_were_written(page: str, tmp_path: pathlib.Path) -> None:
    assert decoded(TEXT.encode(page)) == TEXT
    (tmp_path / "UEBER.MPR").write_bytes(TEXT.encode(page))
    assert sources(str(tmp_path))[0].text == TEXT
    assert read_listing(tmp_path / "UEBER.MPR") == TEXT


def test_the_end_of_file_of_dos_is_no_line() -> None:
    assert decoded(TEXT.encode("cp850") + b"\x1a") == TEXT
    assert decoded(b"END\r\n\x1aEND\r\n") == "END\r\n"
