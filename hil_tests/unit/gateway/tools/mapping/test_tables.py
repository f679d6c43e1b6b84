"""AX-405: mapping tables as CSV, Z0.SEQ and TOML; what cannot be read is told by line and column."""

import tomllib

import pytest

from gateway.tools.mapping_tables import (
    COLUMNS,
    MappingFault,
    Row,
    from_cells,
    from_csv,
    from_sequence,
    to_cells,
    to_csv,
    to_sequence,
    to_toml,
)

ROWS = [
    Row("db", "10", at="DW 2", type="KF", to="move.X.target", unit="0.1 mm", comment='Ziel "X"; größer'),
    Row("db", "10", at="DR 1", type="KH", to="cell.override", unit="1 %", min="0", max="100"),
    Row("db", "11", at="DD 4", type="REAL", from_="axis.X.actual"),
    Row("route", name="lift", from_="axis.Z.actual", to="AD 40", to_type="s32", scale="100", offset="-0.5", on_loss="zero"),
    Row("symbol", name="READY_RCO", at="E 8.0", comment="bereit"),
]


def test_csv_has_semicolons_and_decimal_commas_and_comes_back_as_it_was() -> None:
    text = to_csv(ROWS)
    assert text.splitlines()[0] == ";".join(COLUMNS)
    assert "0,1 mm" in text and "-0,5" in text and '"Ziel ""X""; größer"' in text
    assert from_csv("\ufeff" + text) == ROWS
    assert from_cells([COLUMNS, *map(to_cells, ROWS)]) == ROWS


def test_columns_may_be_in_any_order_and_cells_may_be_numbers() -> None:
    rows = from_cells([["AT", "Table", "min", "block", None], ["DW 1", "db", 0.5, 10, None], [None, None, None, None, None]])
    assert rows == [Row("db", "10", at="DW 1", min="0.5")]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("table;wort\r\ndb;1\r\n", "line 1: columns wort"),
        ("name;at\r\n", "without table"),
        ("table;at\r\nword;DW 1\r\n", "line 2, table"),
        ("table;at\r\nblock;DW 1\r\n", "line 2, block: a row of table block has it"),
        ("table;block;words;writer\r\nblock;10;some;plc\r\n", "line 2, words: 'some' is not a whole number"),
        ("table;block\r\ndb;DB 10\r\n", "line 2, block: 'DB 10' is not a whole number"),
        ("table;from\r\nroute;E 8.0\r\n", "line 2, name: a row of table route has it"),
        ("table;min\r\ndb;1,5.3\r\n", "line 2, min: '1,5.3' is not a number"),
    ],
)
def test_a_bad_table_is_reported_by_line_and_column(text: str, words: str) -> None:
    with pytest.raises(MappingFault) as fault:
        from_csv(text)
    assert words in str(fault.value)


def test_the_assignment_list_of_step_5() -> None:
    assert to_sequence(ROWS) == "E 8.0\tREADY_RCO\tbereit\r\n"
    rows = from_sequence(
        "; Anlage 3\r\nE 8.0\tREADY\tbereit\r\n\r\nA   3.2   FEED     Vorschub frei\r\nM 6.4  FLAG\r\n\x1aold editor's rest"
    )
    assert rows[0] == Row("symbol", name="READY", at="E 8.0", comment="bereit")
    assert (rows[2].at, rows[2].name, rows[2].comment) == ("M 6.4", "FLAG", "")
    for bad in ("READY E 8.0\r\n", "E 8.0\r\n"):
        with pytest.raises(MappingFault):
            from_sequence(bad)


def test_tables_become_tables_of_a_cell_file() -> None:
    found = tomllib.loads(to_toml(ROWS))
    ten, eleven = found["db"]
    assert (ten["number"], ten["words"], ten["writer"]) == (10, 3, "plc")
    assert ten["entries"][0] == {"at": "DW 2", "type": "KF", "to": "move.X.target", "unit": "0.1 mm", "comment": 'Ziel "X"; größer'}
    assert ten["entries"][1]["max"] == 100.0
    assert (eleven["words"], eleven["writer"], eleven["entries"][0]["from"]) == (6, "axisgate", "axis.X.actual")
    wanted = {"name": "lift", "from": "axis.Z.actual", "to": "AD 40", "to_type": "s32", "on_loss": "zero", "scale": 100.0, "offset": -0.5}
    assert found["route"] == [wanted]
    assert to_toml(ROWS).startswith("# E 8.0")
