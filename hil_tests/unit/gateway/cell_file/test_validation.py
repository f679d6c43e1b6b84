"""One class a cell table: its annotations are what a file is judged by, and what messages and pages read."""

import datetime
import pathlib
from typing import Any

import pytest
from pydantic import ValidationError

import gateway
from gateway.cell_file.validation import validated
from gateway.pure.cell import columns as cell_columns
from gateway.pure.cell.axes import Axis, PlantAxis
from gateway.pure.cell.belts import Belt
from gateway.pure.cell.cell import CellTables, Robot
from gateway.pure.cell.columns import columns
from gateway.pure.cell.modbus import Modbus, ModbusLimits
from gateway.pure.cell.routes import Route

HEAD: dict[str, Any] = {"format": 1, "cell": {"name": "press"}}
ROUTE = {"name": "r1", "from": "RC 11.1", "to": "io.lamp"}


def refused(**tables: object) -> list[tuple[tuple[int | str, ...], str]]:
    """Places and kinds of what is wrong with these tables."""
    with pytest.raises(ValidationError) as found:
        validated({**HEAD, **tables})
    return [(detail["loc"], detail["type"]) for detail in found.value.errors()]


def test_tables_of_a_file_become_the_data_of_the_cell() -> None:
    belt = {"name": "in", "increment": 0.01, "robot": "left", "factors_of": {"left": [1, 0.0, 0.0]}}
    safety = {"last_stop_test": datetime.date(2026, 11, 20)}
    tables = validated({**HEAD, "belt": [belt], "route": [ROUTE], "safety": safety, "rc_inputs": {"owner": {"11": "plc"}}})
    assert tables.belt == (Belt("in", 0.01, robot=("left",), factors_of={"left": (1.0, 0.0, 0.0)}),)
    assert tables.route == (Route("r1", "RC 11.1", "io.lamp"),)
    assert tables.rc_inputs.owner == {11: "plc"}
    assert tables.safety is not None and tables.safety.last_stop_test == datetime.date(2026, 11, 20)


def test_nothing_is_converted_and_every_fault_has_its_key() -> None:
    route = {**ROUTE, "pulse_ms": "100", "scale": True, "debounce_ms": 1.0}
    assert refused(route=[route]) == [
        (("route", 0, "scale"), "float_type"),
        (("route", 0, "pulse_ms"), "int_type"),
        (("route", 0, "debounce_ms"), "int_type"),
    ]
    assert refused(safety={"last_stop_test": "2026-11-20"}) == [(("safety", "last_stop_test"), "date_type")]
    assert refused(robot=[{"kinematics": "identity", "too_fast": True}]) == [(("robot", 0, "too_fast"), "literal_error")]
    assert refused(route={"name": "r1"}) == [(("route",), "tuple_type")]
    assert refused(belt=[{"name": "in", "increment": float("inf")}]) == [(("belt", 0, "increment"), "finite_number")]
    assert refused(cell=[]) == [(("cell",), "dataclass_type")]


def test_keys_are_those_of_the_file_and_no_other() -> None:
    spelled = {"name": "r1", "from_": "RC 11.1", "to": "io.lamp"}
    assert refused(route=[spelled]) == [(("route", 0, "from"), "missing"), (("route", 0, "from_"), "unexpected_keyword_argument")]
    assert refused(modbus=[{"name": "m", "limits": {"clientz": 1}}]) == [
        (("modbus", 0, "limits", "clientz"), "unexpected_keyword_argument")
    ]
    assert refused(sources={}) == [(("sources",), "unexpected_keyword_argument")]


def test_ranges_and_forms_are_those_of_the_columns() -> None:
    assert refused(modbus=[{"name": "m", "limits": {"clients": 0, "per_address": 1025}}]) == [
        (("modbus", 0, "limits", "clients"), "greater_than_equal"),
        (("modbus", 0, "limits", "per_address"), "less_than_equal"),
    ]
    assert refused(path_output=[{"kind": "iol", "function": 1, "output": 2, "robot": ["a", "b"]}]) == [
        (("path_output", 0, "robot"), "too_long")
    ]
    assert refused(rc_inputs={"owner": {"1111": "plc"}}) == [(("rc_inputs", "owner", "1111", "[key]"), "int_type")]
    assert refused(signals={"K01": 1024}) == [(("signals", "K01"), "less_than_equal")]


def test_columns_say_key_range_unit_and_default() -> None:
    poll = columns(ModbusLimits)["receive_ms"]
    assert (poll.range, poll.unit, poll.required, poll.default) == ("50..60000", "ms", False, 2000)
    assert columns(Modbus)["port"].name == "port_" and columns(Route)["from"].required
    assert columns(Axis)["modulo"].range == ">= 0" and columns(Axis)["modulo"].unit == "{u}"
    assert columns(Robot)["corrects"].range == "letters of xyzabc in this order"
    assert columns(PlantAxis)["settings"].loaded
    assert columns(CellTables)["axis"].table is Axis and columns(CellTables)["handshake"].table is not None


def test_every_column_of_every_table_is_judged() -> None:
    """No bare float, whole number or text slips through because a mark is unknown to the validator."""
    pending: list[type] = [CellTables]
    seen: set[type] = set()
    while pending:
        table = pending.pop()
        if table in seen:
            continue
        seen.add(table)
        pending += [column.table for column in columns(table).values() if column.table is not None]
    assert len(seen) > 60
    known = ("annotated_types", "gateway.pure.cell.marks")
    assert {type(mark).__module__ for table in seen for column in columns(table).values() for mark in column.marks} <= set(known)


def test_no_second_set_of_models() -> None:
    root = pathlib.Path(gateway.__file__).parent
    assert not (root / "cell_file" / "models").exists()
    users = [path.name for path in (root / "cell_file").rglob("*.py") if "BaseModel" in path.read_text(encoding="utf-8")]
    assert users == [] and cell_columns.key_of("from_") == "from"
