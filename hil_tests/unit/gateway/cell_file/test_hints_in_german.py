"""Hints of faults between keys, in German: every one that the checks write, whole."""

import ast
import pathlib
import re
from collections.abc import Iterator

import pytest

import gateway
from gateway.cell_file.load import load_cell
from gateway.commands.check import fault_lines
from gateway.files.find import find_config, read_text
from gateway.files.texts import spoken
from gateway.pure.cell.faults import CellFaults

CHECKS = pathlib.Path(gateway.__file__).parent / "checks"
VALUE = "7"
ENGLISH = re.compile(r"\b(the|is|are|has|have|of|and|no|this|needs?|with|it|its|by|only|already|another|which|what|from here|to the)\b")
CODE = re.compile(r'"[^"]*"|`[^`]*`|\[\[?[a-z_.]+\]\]?|\b[a-z_]+ = \S+|\([^)]*\)')  # keys and values stay as they are in the file


def hints() -> Iterator[tuple[str, str]]:
    """(file, hint) of each fault whose hint is written where the fault is; what is filled in becomes 7."""
    for path in sorted(CHECKS.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "fault"):
                continue
            named = [keyword.value for keyword in node.keywords if keyword.arg == "hint"]
            for hint in [*node.args[2:3], *named]:
                if words := shown(hint):
                    yield path.name, words


def shown(text: ast.expr) -> str:
    if isinstance(text, ast.Constant):
        return str(text.value)
    if isinstance(text, ast.JoinedStr):
        return "".join(str(part.value) if isinstance(part, ast.Constant) else VALUE for part in text.values)
    return ""


HINTS = sorted(set(hints()))


def test_every_hint_of_a_check_is_german_from_its_first_word_to_its_last() -> None:
    assert len(HINTS) > 200
    left = {words: german for _, words in HINTS if ENGLISH.search(CODE.sub("", german := spoken("check-notices").german(words)))}
    assert left == {}


@pytest.mark.parametrize(
    "old, fresh, expected",
    [
        ("module = 2", "module = 1", "Achse A1 hat module 1 am Bus drives schon"),
        ("min = -5.0", "min = 5000.0", "muss unter max = "),
    ],
)
def test_a_cell_with_such_a_fault(old: str, fresh: str, expected: str, tmp_path: pathlib.Path) -> None:
    demo = read_text(find_config("demo", "cells"))
    assert old in demo
    file = tmp_path / "cell.toml"
    file.write_text(demo.replace(old, fresh, 1))
    with pytest.raises(CellFaults) as found:
        load_cell(str(file))
    rows = fault_lines(str(file), found.value.faults, "de")
    assert any(expected in row for row in rows), rows
