"""A cell file may hold anything: it becomes a cell or a list of faults, never an exception of another kind."""

import copy
import tomllib
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from gateway.cell_file.load import CellFaults, load_tables
from gateway.files.find import find_config, read_text

CELLS = [tomllib.loads(read_text(find_config(name, "cells"))) for name in ("demo", "s5-rk512", "rho3-servodyn")]
SCALARS = st.one_of(
    st.booleans(),
    st.integers(-(2**40), 2**40),
    st.floats(),
    st.sampled_from(
        ["", "x", "DW 2", "DB10.D0.8", "5:1", "1..6", "0 mm", "-", "A1", "drives", "DW 999", "a.b", "[", "D 0.0", "sim", "axis.*.actual"]
    ),
)
JUNK = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["name", "at", "x", "1"]), inner, max_size=3)
)


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [*([path] if path else []), *(each for key, below in inner for each in places(below, (*path, key)))]


def put(tables: Any, path: tuple[Any, ...], junk: Any, how: str) -> None:
    for part in path[:-1]:
        tables = tables[part]
    if how == "drop":
        del tables[path[-1]]
    elif how == "twice" and isinstance(tables, list):
        tables.append(copy.deepcopy(tables[path[-1]]))
    else:
        tables[path[-1]] = junk


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_any_value_anywhere_is_a_cell_or_faults(data: st.DataObject) -> None:
    tables = copy.deepcopy(CELLS[data.draw(st.integers(0, len(CELLS) - 1))])
    for _ in range(data.draw(st.integers(1, 3))):
        path = places(tables)[data.draw(st.integers(0, len(places(tables)) - 1))]
        put(tables, path, data.draw(JUNK), data.draw(st.sampled_from(["put", "drop", "twice"])))
    assert told(tables)


def told(tables: dict[str, Any]) -> bool:
    """A cell whose notices are all warnings or notes, or at least one fault with key and words."""
    try:
        cell = load_tables("cell.toml", tables)
    except CellFaults as found:
        return bool(found.faults) and all(fault.key and str(fault) for fault in found.faults)
    return len(cell.warnings) + len(cell.notes) == len(cell.notices)
