"""Values of a cell are found by every name and address they have, and tell where they are used."""

import pytest

from gateway.cell_file.load import load_cell
from gateway.observer.names import MOST, Names


@pytest.fixture(scope="module")
def names() -> Names:
    return Names(load_cell("demo"))


@pytest.mark.parametrize(
    "words, found",
    [
        ("DB10.DW2", "db:10:2"),
        ("db10.dw 2", "db:10:2"),
        ("O3.0", "in:24"),
        ("RCI 24", "in:24"),
        ("00025", "in:24"),
        ("10065", "out:64"),
        ("axis.A1.actual", "axis.A1.actual"),
        ("EMSTOP_OK_RCI", "in:24"),
        ("DB10.D0.8", "db:10:0.8"),
    ],
)
def test_every_address_leads_to_its_value_first(names: Names, words: str, found: str) -> None:
    total, rows = names.search(words)
    assert total >= 1
    assert rows[0].id == found


def test_a_register_leads_to_its_sixteen_bits(names: Names) -> None:
    total, rows = names.search("40002")
    assert [row.id for row in rows] == [f"in:{n}" for n in range(16, 32)]
    assert total == 16
    assert [row.id for row in names.search("30005")[1]][:1] == ["out:64"]


@pytest.mark.parametrize(
    "words, first, bits",
    [
        ("AW 90", "inw:90:2", [f"in:{n}" for n in range(720, 736)]),
        ("aw90", "inw:90:2", [f"in:{n}" for n in range(720, 736)]),
        ("QB 5", "inw:5:1", [f"in:{n}" for n in range(40, 48)]),
        ("EB 8", "outw:8:1", [f"out:{n}" for n in range(64, 72)]),
        ("ID 8", "outw:8:4", [f"out:{n}" for n in range(64, 96)]),
    ],
)
def test_bytes_and_words_of_the_image_are_found_with_their_bits(names: Names, words: str, first: str, bits: list[str]) -> None:
    total, rows = names.search(words)
    assert [row.id for row in rows[: 1 + len(bits)]] == [first, *bits]
    assert total >= 1 + len(bits) and rows[0].kind == "word"
    assert names.entry(first) == rows[0]


def test_an_id_beyond_the_image_is_no_value(names: Names) -> None:
    for id_ in ("inw:127:2", "inw:0:3", "outw:-1:2", "inw:x:2", "nothing"):
        with pytest.raises(KeyError):
            names.entry(id_)
    assert names.search("AW 127")[1] == []


def test_a_contact_is_found_by_its_name() -> None:
    found = Names(load_cell("s5-rk512")).search("io.safety_ok")[1]
    assert [(entry.id, entry.group, entry.kind) for entry in found] == [("io:safety_ok", "contacts", "bit")]
    assert "canopen-401 can0 20 input 0" in found[0].addresses


def test_all_words_must_occur_and_the_answer_is_limited(names: Names) -> None:
    total, rows = names.search("axis actual")
    assert {row.id for row in rows if row.id.startswith("axis.")} == {f"axis.A{n}.actual" for n in range(1, 7)}
    assert total == len(rows)
    total, rows = names.search("")
    assert (total, len(rows)) == (len(names.all), MOST)
    assert names.search("no such thing at all") == (0, [])


def test_a_branch_of_the_tree_holds_what_it_counts(names: Names) -> None:
    counted = {str(branch["group"]): branch["count"] for branch in names.tree()}
    assert counted["DB 10"] == len(load_cell("demo").db[0].entries)
    assert names.search("", "DB 10")[0] == counted["DB 10"]
    assert names.search("", "axes")[0] == sum(int(str(count)) for group, count in counted.items() if group.startswith("axes / "))
    assert sum(int(str(count)) for count in counted.values()) == len(names.all)


def test_where_used_names_block_coil_and_cycle(names: Names) -> None:
    assert "DB 11 DW 2 (KF), line plc1" in names.by_id["axis.A1.actual"].used
    assert {"modbus plc2: coil 26", "cycle: enabling input feed"} <= set(names.by_id["in:26"].used)
    assert names.by_id["in:26"].source == "axisgate"
    assert names.by_id["in:26"].writer == "plc2"
    assert not names.by_id["out:64"].forcible
