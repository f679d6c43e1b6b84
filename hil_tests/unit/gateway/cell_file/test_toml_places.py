"""Lines of keys, and syntax errors told so that they can be cured (users.md 3.5 (c), (d), 3.6)."""

import tomllib
from typing import Any

import pytest

from gateway.cell_file.keys import line_of, written
from gateway.cell_file.load import CellFaults, load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.reports.toml_lines import Path, lines_of, nearest


def paths(value: Any, path: Path = ()) -> list[Path]:
    """Every key and element of a parsed file."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(each for key, below in inner for each in paths(below, (*path, key)))]


@pytest.mark.parametrize("name", ["demo", "s5-rk512", "rho3-servodyn"])
def test_every_key_is_found_in_a_line_that_holds_it(name: str) -> None:
    text = read_text(find_config(name, "cells"))
    lines, places = text.splitlines(), lines_of(text)
    for path in paths(tomllib.loads(text)):
        if path and isinstance(path[-1], str) and path[0] != "defaults":
            line = nearest(places, path)
            assert line is not None and str(path[-1]) in lines[line - 1], path


def test_elements_of_a_list_over_several_lines() -> None:
    text = 'a = [ { b = 1 },\n  # { b = 9 }\n  { b = "]", c = [1,\n 2] },\n]\n[[t.u]]\nx = 1\n[[t.u]]\n"y z" = 2\n'
    places = lines_of(text)
    assert [places[path] for path in (("a", 0), ("a", 1), ("a", 1, "c", 1), ("t", "u", 1), ("t", "u", 1, "y z"))] == [1, 3, 4, 8, 9]


def test_written_keys_are_found_by_name_number_and_place() -> None:
    raw = tomllib.loads('[[db]]\nnumber = 10\nentries = [\n { at = "D 0.8", to = "x" },\n]\n[[axis]]\nname = "X"\nlimits = { min = 1 }\n')
    places = lines_of('[[db]]\nnumber = 10\nentries = [\n { at = "D 0.8", to = "x" },\n]\n[[axis]]\nname = "X"\nlimits = { min = 1 }\n')
    assert line_of(raw, places, "db.10[D 0.8]") == 4
    assert line_of(raw, places, "axis.X.limits.min") == 8
    assert line_of(raw, places, "axis.X.home.speed") == 6  # not written: the table around it
    assert written(raw, "axis.X.limits.min") and not written(raw, "axis.X.limits.max")


@pytest.mark.parametrize(
    ("text", "line", "hint"),
    [
        ('[device]\nname = "Checkweigher CW-4"; serial = "..."\n', 2, "TOML has no semicolons"),
        ('format = 1\ndrive = { type = "servodyn",\n  bus = "b" }\n', 2, "stays on one line"),
        ('[[db]]\nentries = [\n  { at = "DW 1",\n    type = "KF" },\n]\n', 3, "stays on one line"),
        ('[line.supervision]\nmax_silence_ms = 5\n[[line]]\nname = "a"\n', 3, "belongs to the last [[line]] above it"),
        ("[[line]]\n[line.supervision]\na = 1\n[line.supervision]\nb = 1\n", 4, "once for each of them"),
        ("speed = 1,5\n", 1, "decimal point"),
        ("drive = servodyn\n", 1, 'texts in "quotes"'),
        ("format: 1\n", 1, "key = value"),
        ("a = 1\na = 2\n", 2, "is already in the file"),
        ("a = [ 1,\n2\n", 2, ""),
    ],
)
def test_syntax_errors_have_a_line_and_a_cure(text: str, line: int, hint: str) -> None:
    with pytest.raises(CellFaults) as found:
        load_cell("device.toml", text)
    (fault,) = found.value.faults
    assert fault.kind == "syntax" and fault.file == "device.toml"
    assert hint in fault.hint
    assert fault.line is not None and abs(fault.line - line) <= (1 if "one line" in hint else 0), fault
