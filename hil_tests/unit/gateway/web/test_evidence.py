"""How far things were proved is data: one file for the page, README and docs."""

from gateway.cell_file.load import load_cell
from gateway.files.find import read_evidence
from gateway.pure.cell.cell import Cell
from gateway.web.cell_view import plain, proved

LEVELS = {"specified", "emulator", "bench", "plant"}


def test_every_row_has_a_level_that_its_words_bear_out() -> None:
    rows = read_evidence()
    assert len(rows) > 25
    for row in rows:
        assert row["level"] in LEVELS
        assert str(row["level"]) in str(row["evidence"]), row["what"]
        assert row["by"]


def test_what_cells_are_made_of_has_a_row() -> None:
    cells: list[Cell] = [load_cell(name) for name in ("demo", "demo-402", "s5-rk512", "host-telegrams")]
    parts = {f"drive:{axis.drive.type}" for cell in cells for axis in cell.axis}
    parts |= {f"line:{word}" for cell in cells for line in cell.line for word in (line.protocol, line.layer)}
    assert {part for part in parts if not proved(part)} == set()


def test_no_level_of_a_drive_bus_is_higher_than_its_data() -> None:
    assert [row["level"] for row in proved("layout:servodyn")] == ["emulator"]
    assert proved("drive:none") == []


def test_texts_for_people_carry_no_marks() -> None:
    assert plain("a **b** ([c](d.md)) `e`") == "a b e"
    for row in read_evidence():
        assert not set("*`") & set(plain(f"{row['what']}: {row['by']}"))
        assert "](" not in plain(f"{row['what']}: {row['by']}")
