"""P numbers of [rho3] that act on nothing: each is named with its meaning, in both languages; those that act are not."""

import re

import pytest

from gateway.cell_file.load import load_cell
from gateway.cell_file.rho3_parameters import LEGAL, USED
from gateway.files.find import PACKAGED, find_config, read_text
from gateway.files.texts import read_texts
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.faults import CellFaults
from gateway.pure.cell.rho3 import CONTROLLED, DOWNLOADED, JOGGED
from gateway.pure.reports.sentences import in_language

NOTHING = LEGAL - USED - DOWNLOADED - CONTROLLED - JOGGED
BARE = 'format = 1\n[cell]\nname = "bare"\n[rho3]\n'


def warned(cell: Cell, language: str = "en") -> dict[str, str]:
    return {notice.where: in_language(notice.text, language) for notice in cell.warnings if notice.where.startswith("rho3.P")}


def test_each_of_the_28_is_warned_of_by_number_and_meaning() -> None:
    cell = load_cell("bare.toml", BARE + "".join(f"{number} = [1]\n" for number in sorted(NOTHING)))
    english, german = warned(cell), warned(cell, "de")
    assert len(NOTHING) == 28 and set(english) == {f"rho3.{number}" for number in NOTHING}
    assert english["rho3.P402"] == "has no effect: referencing on or off; here: home.by of the axis"
    assert german["rho3.P402"] == "wirkungslos: Referenzieren ein oder aus; hier: home.by der Achse"


def test_a_parameter_that_acts_is_warned_of_only_where_it_cannot() -> None:
    given = "P5 = 8\nP3 = 16\nP213 = [20.0]\nP602 = [1.0]\n"
    assert list(warned(load_cell("bare.toml", BARE + given))) == ["rho3.P3", "rho3.P213", "rho3.P602"]
    shipped = read_text(find_config("rho3-servodyn", "cells"))
    assert warned(load_cell("own.toml", shipped)) == {}
    text = shipped.replace("P2   = 3 ", "P3 = 16\nP213 = [20.0]\nP602 = [1, 1, 1, 1, 1, 1]\nP2   = 3 ")
    said = warned(load_cell("own.toml", text))
    assert "P601 = false" in said["rho3.P602"] and {"rho3.P3" in said, "rho3.P213" in said} == {"[controller]" not in shipped}
    assert warned(load_cell("own.toml", text + '\n[controller]\nkind = "rho3"\n' * ("[controller]" not in shipped))).keys() == {"rho3.P602"}


GIVEN = {  # of a cell that has nothing they are about, and what the sentence says is missing
    "P2": ("3", "[controller]"), "P9": ("50", "[controller]"), "P20": ("15", "[controller]"), "P21": ("[0, 44, 0, 44]", "[controller]"),
    "P24": ("16", "[controller]"), "P30": ("[{ inputs = 0 }]", "[[bus]]"), "P103": ("[1.0]", "an axis"), "P104": ("[1.0]", "an axis"),
    "P108": ("[1.0]", "an axis"), "P109": ("[1.0]", "an axis"), "P204": ("[1.0]", "an axis"), "P205": ("[1.0]", "an axis"),
    "P207": ("[1.0]", "an axis"), "P208": ("[1.0]", "an axis"), "P303": ("[0]", "an axis"), "P306": ("[{ monitoring = 1 }]", "[[robot]]"),
    "P311": ("[360.0]", "endless"), "P313": ("[[1, 2, 3, 4, 5, 6]]", "[[robot]]"), "P601": ("true", "SERVODYN"),
    "P113": ("[1.0]", "an axis"), "P114": ("[1.0]", "P601"), "P128": ("[1.0]", "P113"),
}  # fmt: skip


@pytest.mark.parametrize("number", sorted(GIVEN))
def test_one_that_has_a_key_or_a_table_is_warned_of_where_the_cell_lacks_what_it_is_about(number: str) -> None:
    value, missing = GIVEN[number]
    found = warned(load_cell("bare.toml", f"{BARE}{number} = {value}\n"))
    assert list(found) == [f"rho3.{number}"] and "has no effect" in found[f"rho3.{number}"] and missing in found[f"rho3.{number}"]


def test_those_of_the_manuals_list_act_are_judged_or_are_warned_of() -> None:
    """P5 and P15 are judged in every cell; P31 and P32 are refused without the bus that has them, P401 brings its own axes."""
    assert {*NOTHING, *GIVEN, *DOWNLOADED, *CONTROLLED, "P5", "P15", "P31", "P32", "P401"} == LEGAL


def test_ranges_of_a_bit_coupling_that_is_not_configured_are_warned_of() -> None:
    shipped = read_text(find_config("rho3-servodyn", "cells"))
    assert warned(load_cell("own.toml", shipped)) == {}
    assert "unless P20 is" in warned(load_cell("own.toml", shipped.replace("P20  = 15", "P20  = 7")))["rho3.P21"]


@pytest.mark.parametrize("number", sorted(NOTHING))
def test_nothing_in_the_tree_reads_a_parameter_that_is_said_to_act_on_nothing(number: str) -> None:
    readers = [
        path
        for folder in ("gateway", "drivers")
        for path in (PACKAGED.parent / folder).rglob("*.py")
        if re.search(rf'["\']{number}["\']|\.{number}\b', path.read_text())
    ]
    assert readers == []


def test_every_parameter_beside_the_tables_own_has_its_meaning_in_both_languages() -> None:
    texts = read_texts("rho3-parameters")
    assert texts.ids() == LEGAL
    assert all(str(texts.said(number)) != texts.said(number).german for number in texts.ids())


def test_a_file_of_zeros_that_nothing_reads_is_warned_of() -> None:
    shipped = read_text(find_config("rho3-servodyn", "cells"))
    cell = load_cell("own.toml", shipped.replace('name       = "ROB1"', 'name       = "ROB1"\nzero = "zero/2026-11-12.toml"'))
    said = {notice.where: notice.text for notice in cell.warnings if notice.where == "robot.ROB1.zero"}
    assert in_language(said["robot.ROB1.zero"], "en").startswith("not read: axisgate axis zero writes the zeros into the state folder")
    assert in_language(said["robot.ROB1.zero"], "de").startswith("wird nicht gelesen:")


def test_addresses_on_a_modbus_line_count_from_0() -> None:
    shipped = read_text(find_config("rho3-servodyn", "cells"))
    with pytest.raises(CellFaults) as caught:
        load_cell("own.toml", shipped.replace("first_address = 0", "first_address = 1"))
    assert [(fault.key, fault.line, "axisgate map shows both counts" in fault.hint) for fault in caught.value.faults] == [
        ("modbus.plc.first_address", 1 + shipped[: shipped.index("first_address")].count("\n"), True)
    ]
