"""Alarms over time: what came, who acknowledged it, when it went; over restarts and with foreign lines in the file (AX-642)."""

import json

import pytest

from gateway.pure.image.alarms import Alarms, Record, alarm_rows
from gateway.services.alarm_file import as_csv
from gateway.web.alarms import fits

FAULT = (16, "drive fault: A2 following error 1.2 mm")


def book() -> tuple[Alarms, list[Record]]:
    return Alarms([["A1", "A2", "A22"], ["plc1"], ["drives"]]), []


def kept(records: list[Record], wall: str, new: list[Record]) -> None:
    records += [{"wall": wall, **record} for record in new]


def test_an_alarm_comes_is_acknowledged_and_goes_with_its_times_and_its_source() -> None:
    alarms, file = book()
    kept(file, "2026-11-23T08:00:00", alarms.look([FAULT]))
    kept(file, "2026-11-23T08:00:01", alarms.look([(16, "drive fault: A2 following error 3.4 mm")]))
    kept(file, "2026-11-23T08:00:02", alarms.acknowledge("plc1"))
    kept(file, "2026-11-23T08:00:03", alarms.look([]))
    assert alarm_rows(file) == [
        {
            "number": 1, "code": 16, "text": FAULT[1], "source": "A2", "came": "2026-11-23T08:00:00",
            "acknowledged": "2026-11-23T08:00:02", "by": "plc1", "gone": "2026-11-23T08:00:03",
        }
    ]  # fmt: skip


def test_one_that_went_unseen_is_acknowledged_later_and_comes_again_as_another() -> None:
    alarms, file = book()
    for wall, errors in (("1", [FAULT]), ("2", []), ("3", [FAULT]), ("4", [])):
        kept(file, wall, alarms.look(errors))
    kept(file, "5", alarms.acknowledge("page"))
    rows = alarm_rows(file)
    assert [(row["number"], row["came"], row["gone"]) for row in rows] == [(2, "3", "4"), (1, "1", "2")]
    assert rows[0]["acknowledged"] == "5" and alarms.acknowledge("page") == []


def test_numbers_count_on_over_a_restart_and_what_was_active_is_reported() -> None:
    alarms, file = book()
    kept(file, "1", alarms.look([FAULT, (8, "emergency stop is latched")]))
    kept(file, "2", alarms.look([FAULT]))
    again = Alarms([["A2"]], file)
    assert again.left_over == [1]
    assert again.look([FAULT])[0]["number"] == 3


def test_sources_are_whole_names() -> None:
    alarms, _ = book()
    assert [alarms.source(text) for text in ("A22 lost", "line plc1 is silent", "A221", "nothing")] == ["A22", "plc1", "cell", "cell"]
    assert alarms.source("drives stopped: A2") == "A2", "a bus that is called drives"


def test_foreign_records_are_left_out() -> None:
    foreign: list[Record] = [{"number": "1", "what": "came", "wall": "1"}, {"number": 2, "what": "gone", "wall": "1"}, {"what": "came"}]
    assert alarm_rows(foreign) == [] and Alarms([], foreign).look([FAULT])[0]["number"] in (1, 3)


def test_rows_are_found_by_words_state_source_and_time() -> None:
    row: dict[str, object] = {
        "number": 1, "code": 16, "text": FAULT[1], "source": "A2", "came": "2026-11-23T08:00:00+01:00", "acknowledged": "",
        "by": "", "gone": "",
    }  # fmt: skip
    for query in ({"q": "A2 FAULT"}, {"q": "16"}, {"state": "active"}, {"state": "open"}, {"source": "A2"}, {"from": "2026-11-23"},
                  {"from": "2026-11-22", "to": "2026-11-23"}):  # fmt: skip
        assert fits(row, query), query
    for query in ({"q": "A1"}, {"state": "gone"}, {"source": "A1"}, {"from": "2026-11-24"}, {"to": "2026-11-22"}):
        assert not fits(row, query), query
    with pytest.raises(ValueError, match="state: active, open, gone"):
        fits(row, {"state": "lost"})
    assert as_csv([row]).splitlines()[1] == f"1;2026-11-23T08:00:00+01:00;;;;16;A2;{FAULT[1]}"
    assert json.dumps(row)
