"""What exists is a row of gateway.registry: rows can be reached, load nothing by themselves, and nobody compares their names."""

import ast
import dataclasses
import json
import pathlib
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator

import pytest

import gateway
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.cell.cell import CellTables
from gateway.pure.cell.faults import CellFaults
from gateway.registry import BUS_PROTOCOLS, CELL_CHECKS, DRIVE_FAMILIES, LINE_LAYERS, MODBUS_VIEWS, NAMES, lines
from gateway.services.sources.base import BaseSource

ROOT = pathlib.Path(gateway.__file__).parents[1]
KINDS = {name for table in NAMES.values() for name in table if name != "program"} | {"3964R", "3964"}
OWN = (  # folders of a kind: inside it is itself
    "gateway/registry",
    "gateway/pure/controllers",
    "gateway/pure/languages",
    "gateway/tools/new_cell",  # questions and their answers, not kinds of a cell
)
COMPARED = {  # comparisons that are left, file by file; may only fall
    "gateway/cell_file/explain_operands.py": 3,
    "gateway/cell_file/load.py": 2,
    "gateway/conformance/serial/partners.py": 1,
    "gateway/conformance/serial/run.py": 3,
    "gateway/pure/cell/cell.py": 1,
    "gateway/pure/lines/line_profiles.py": 1,
    "gateway/pure/reports/transfer_times.py": 1,
    "gateway/shadow/plan.py": 1,
    "gateway/shadow/source.py": 1,
}


def compared(path: pathlib.Path) -> Iterator[int]:
    """Lines that compare something with the name of a kind: ==, in, match."""
    text = path.read_text(encoding="utf-8")
    if not any(f'"{kind}"' in text for kind in KINDS):
        return
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
        elif isinstance(node, ast.MatchValue):
            sides = [node.value]
        else:
            continue
        words = [each for side in sides for each in (side.elts if isinstance(side, ast.Tuple | ast.List | ast.Set) else [side])]
        if any(isinstance(word, ast.Constant) and word.value in KINDS for word in words if isinstance(word, ast.Constant)):
            yield sides[0].lineno


def test_names_of_kinds_are_compared_less_and_less() -> None:
    files = (path for path in sorted((ROOT / "gateway").rglob("*.py")) if not str(path.relative_to(ROOT)).startswith(OWN))
    found = Counter({str(path.relative_to(ROOT)): len(list(compared(path))) for path in files})
    assert {path: count for path, count in found.items() if count > COMPARED.get(path, 0)} == {}
    assert {path: found[path] for path in COMPARED} == COMPARED, "fewer: lower the number here"


def test_reading_the_registry_loads_nothing() -> None:
    ours = "[name for name in sys.modules if name.startswith(('gateway.', 'drivers', 'protocols'))]"
    script = f"import json, sys; import gateway.registry; print(json.dumps({ours}))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60)
    assert json.loads(done.stdout) and all(name.startswith("gateway.registry") for name in json.loads(done.stdout))


def test_every_row_can_be_reached() -> None:
    sources = [layer.source() for layer in LINE_LAYERS.values()]
    assert all(isinstance(source, type) and issubclass(source, BaseSource) for source in sources), sources
    assert {family.protocol for family in DRIVE_FAMILIES.values()} <= set(BUS_PROTOCOLS)
    assert {family.sentence(0x7FFF, "en") != "" for family in DRIVE_FAMILIES.values()} == {True}
    assert {name: len(view.registers(None)) for name, view in MODBUS_VIEWS.items()} == {"rho3": 64, "registers": 0, "reis": 1044, "val3": 0}
    assert all(hasattr(row.module(), "CHECKS") or row.notes for row in CELL_CHECKS.values())


def test_every_table_of_the_cell_file_has_its_checks() -> None:
    checked = [table for row in CELL_CHECKS.values() for table in row.tables]
    assert len(checked) == len(set(checked))
    assert {field.name for field in dataclasses.fields(CellTables)} - set(checked) == {"format"}
    modules = {path.stem for path in (ROOT / "gateway/checks").glob("*.py")} - {"__init__", "context", "playable"}
    assert modules == {row.name for row in CELL_CHECKS.values()}, "a module of checks without a row is never run"


@pytest.mark.parametrize(
    ("cell", "old", "new", "allowed"),
    [
        ("s5-rk512", 'layer    = "rk512"', 'layer    = "rk513"', " | ".join(LINE_LAYERS)),
        ("demo", 'protocol = "servodyn"', 'protocol = "sercos"', "servodyn | canopen | rho3-io"),
    ],
)
def test_a_file_may_name_what_has_a_row(cell: str, old: str, new: str, allowed: str) -> None:
    text = read_text(find_config(cell, "cells"))
    assert old in text
    with pytest.raises(CellFaults) as found:
        load_cell("cell.toml", text.replace(old, new, 1))
    assert found.value.faults[0].range == allowed


def test_a_kind_without_its_row_is_no_kind(monkeypatch: pytest.MonkeyPatch) -> None:
    """Taking BUEP64 away takes one row: nothing else asks for it by name."""
    rows = {name: row for name, row in LINE_LAYERS.items() if name != "buep64"}
    monkeypatch.setattr(lines, "LINE_LAYERS", rows)
    line = dataclasses.replace(load_cell("s5-rk512").line[0], profile="bosch-buep64")
    assert lines.layer_spoken(line).name == "rk512"
    assert list(spoken_of("buep64")) == []


def spoken_of(kind: str) -> Iterator[str]:
    """Modules outside of its own folders and the registry that say the name of a kind in code."""
    own = ("gateway/registry", "gateway/pure/lines/buep64.py", "protocols/buep64", "protocols/p3964r/profiles.py")
    for folder in ("gateway", "drivers", "protocols", "motion"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            if str(path.relative_to(ROOT)).startswith(own):
                continue
            text = path.read_text(encoding="utf-8")
            if kind not in text:
                continue
            tree = ast.parse(text)
            said = any(isinstance(node, ast.Constant) and node.value in (kind, f"bosch-{kind}") for node in ast.walk(tree))
            imported = any(isinstance(node, ast.ImportFrom) and f".{kind}" in (node.module or "") for node in ast.walk(tree))
            if said or imported:
                yield str(path.relative_to(ROOT))
