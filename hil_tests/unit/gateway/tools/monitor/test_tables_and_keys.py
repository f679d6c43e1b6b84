"""Tables of the monitor as plain text, and keys of the pendant."""

import json

import pytest

from gateway.observer.names import Entry
from gateway.pure.controllers.reis.pendant import unit as phg
from gateway.pure.controllers.rho3.pendant import unit as rho3
from gateway.tools.monitor.keypad import Unit, key_of, keys_of
from gateway.tools.monitor.shown import shown, signals_table
from gateway.tools.monitor.tables import Table, as_json, number, plain

RHO3, PHG = Unit.of(rho3.UNIT.facts()), Unit.of(phg.UNIT.facts())
TABLE = Table("Axes", ("axis", "actual"), (("A1", "10.000"), ("A22", "-3.5")))


def entry(kind: str, name: str = "X", id_: str = "db:10:2") -> Entry:
    return Entry(id_, "DB 10", name, ("DB10.DW2",), "word", kind, "0.1 mm", "a place", "ein Ort")


def test_columns_are_as_wide_as_their_widest_word() -> None:
    assert plain(TABLE) == "Axes\n  axis  actual\n  A1    10.000\n  A22   -3.5"
    assert plain(TABLE, 8) == "Axes\n  axis  \n  A1    \n  A22   "
    assert plain(Table("Errors", ("code",), empty="no error pending")) == "Errors\n  no error pending"


def test_json_has_a_record_for_each_row() -> None:
    told = json.loads(as_json({"axes": TABLE}, {"run": "demo"}))
    assert told == {"head": {"run": "demo"}, "axes": [{"axis": "A1", "actual": "10.000"}, {"axis": "A22", "actual": "-3.5"}]}


def test_numbers() -> None:
    assert [number(1.23456), number(1.23456, 1), number(None), number(7)] == ["1.235", "1.2", "", "7"]


@pytest.mark.parametrize(
    ("kind", "data", "words", "id_"),
    [
        ("KF", "ffff0000", "-1", "db:10:2"),
        ("KG", "0b4b0800", "1200.500", "db:10:2"),
        ("REAL", "44961000", "1200.500", "db:10:2"),
        ("KH", "12ab0000", "4779", "db:10:2"),
        ("KH", "12ab0000", "171", "db:10:2DR"),
        ("KH", "12ab0000", "18", "db:10:2DL"),
        ("BCD", "00fa0000", "00fa0000", "db:10:2"),
        ("KF", None, "-", "db:10:2"),
    ],
)
def test_words_of_a_block_are_shown_by_their_type(kind: str, data: str | None, words: str, id_: str) -> None:
    assert shown(entry(kind, id_=id_), data) == words


def test_signals_pass_the_filter_and_old_ones_say_so() -> None:
    entries = [Entry(name, "DB 10", name, ("DB10.D0.1",), "bit") for name in ("ON", "OFF", "FORCED", "OLD")]
    values = {"ON": [1, 2, 5, False], "OFF": [0, 2, 5, False], "FORCED": [0, 2, 5, True], "OLD": [1, 1, 900, False]}

    def names(chosen: str) -> list[str]:
        return [row[0] for row in signals_table(entries, values, chosen, 4, "en").rows]

    assert names("all") == ["ON", "OFF", "FORCED", "OLD"]
    assert (names("on"), names("forced"), names("old")) == (["ON", "OLD"], ["FORCED"], ["OLD"])
    table = signals_table(entries, values, "all", 4, "en")
    assert [row[3] for row in table.rows] == ["good", "good", "FORCED", "old"] and table.marks == ("", "", "warn", "old")
    assert "the first 200 are shown" in signals_table(entries, values, "all", 201, "en").title


def test_keys_by_name_and_by_character() -> None:
    assert keys_of("mode 7.3.2 enter", RHO3) == ["MODE", "7", ".", "3", ".", "2", "ENTER"]
    assert keys_of("INFO DOWN a", RHO3) == ["INFO", "DOWN", "A"]
    with pytest.raises(ValueError, match="'\\+' in '7\\+' is not a key"):
        keys_of("7+", RHO3)
    typed: list[tuple[str, str | None]] = [
        ("m", "m"),
        ("M", "M"),
        ("i", "i"),
        ("7", "7"),
        ("full_stop", "."),
        ("enter", "\r"),
        ("backspace", "\x7f"),
        ("up", None),
        ("x", "x"),
    ]
    assert [key_of(name, said, RHO3) for name, said in typed] == ["MODE", "M", "INFO", "7", ".", "ENTER", "DELETE", "UP", "X"]
    assert [key_of(name, said, RHO3) for name, said in (("f5", None), ("tab", "\t"), ("plus", "+"))] == [None, None, None]


def test_keys_of_a_larger_pendant_come_with_it() -> None:
    assert keys_of("run f2 step 12 enter 1+", PHG) == ["RUN", "F2", "STEP", "1", "2", "ENTER", "1+"]
    assert [key_of("escape", None, PHG), key_of("pagedown", None, PHG), key_of("m", "m", PHG)] == ["QUIT", "MENU+", "M"]
    assert (PHG.columns, PHG.lines, PHG.across, "1+" in PHG.held) == (40, 20, 8, True)
    with pytest.raises(ValueError, match="is not a key"):
        keys_of("MODE!", PHG)
