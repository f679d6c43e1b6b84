"""The page Cell says in both languages what is wired where."""

import pytest

from gateway.cell_file.load import load_cell
from gateway.files.find import PACKAGED
from gateway.pure.cell.cell import Cell
from gateway.web.cell_view import safety, shown_file, wiring

SHIPPED = sorted(path.stem for path in (PACKAGED / "cells").glob("*.toml"))
GERMAN = ("Leitung ", "Bus ", "Achse ", "Kontakt ")


@pytest.mark.parametrize("name", SHIPPED)
def test_every_row_of_the_wiring_table_begins_with_a_german_noun(name: str) -> None:
    rows = wiring(load_cell(name))
    assert rows and [row["from"][1] for row in rows if not row["from"][1].startswith(GERMAN)] == []


def test_the_ends_of_a_bus_and_the_address_of_an_axis_are_german() -> None:
    rows = {row["from"][0]: row for row in wiring(load_cell("demo"))}
    assert rows["bus drives"]["how"][1].endswith(", 120 Ohm an beiden Enden")
    assert (rows["axis A1"]["how"], rows["axis A1"]["to"][1]) == (["address 1", "Adresse 1"], "Bus drives")


def test_what_the_plant_states_of_its_safety_has_german_names(tmp_path_factory: pytest.TempPathFactory) -> None:
    shipped = PACKAGED / "cells" / "demo.toml"
    assert shown_file(str(shipped)) == ["demo (shipped with axisgate)", "demo (mit axisgate ausgeliefert)"]
    path = tmp_path_factory.mktemp("cell") / "demo.toml"
    path.write_text(shipped.read_text() + '\n[safety]\nsto_wired = true\nguard = "fence"\n')
    cell: Cell = load_cell(str(path))
    stated = {name[0]: (name[1], value[1]) for name, value in safety(cell)}
    assert stated["STO wired"] == ("STO verdrahtet", "ja")
    assert stated["guard"] == ("Schutzeinrichtung", "fence")
    assert stated["last stop test"] == ("letzte Prüfung des Stillsetzens", "keine Angabe")
