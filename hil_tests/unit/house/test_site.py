"""The docs site: every page is in it, and what is made of the program names all of the program."""

import importlib.util
import re
from importlib.metadata import entry_points
from types import ModuleType

import pytest
from pydantic import BaseModel

from gateway.cell_file.models import cell as cellmodels
from gateway.files.find import read_signals
from gateway.files.table_model import Table
from hil_tests.purity import ROOT


@pytest.fixture(scope="module")
def pages() -> ModuleType:
    spec = importlib.util.spec_from_file_location("site_pages", ROOT / "docs" / "site_pages.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_page_stands_in_the_navigation_once(pages: ModuleType) -> None:
    written = {
        str(path.relative_to(ROOT / "docs")) for pattern in pages.KEPT for path in (ROOT / "docs").glob(pattern) if path.suffix == ".md"
    }
    listed = re.findall(r"^ +- .*: (\S+\.md)$", pages.settings(), re.MULTILINE)
    assert sorted(listed) == sorted(written | set(pages.GENERATED))


def test_the_reference_of_the_cell_file_has_every_key_of_every_table(pages: ModuleType) -> None:
    text = pages.cell_keys()
    models = {model for _, model in pages.tables(cellmodels.CellFile, "")}
    assert models >= subtables(Table)
    keys = {field.alias or name for model in models for name, field in model.model_fields.items() if not pages._inner(field)}
    assert {key for key in keys if f"| `{key}` |" not in text} == set()


def subtables(base: type[BaseModel]) -> set[type[BaseModel]]:
    """Tables the file can have: the models of gateway.cell_file.models.cell that a field of another speaks of."""
    known = {each for each in vars(cellmodels).values() if isinstance(each, type) and issubclass(each, base)}
    return known - {base}


def test_the_list_of_signals_is_whole(pages: ModuleType) -> None:
    text = pages.signals()
    assert [row["name"] for row in read_signals() if f"`{row['name']}`" not in text] == []


def test_wiring_sheets_and_questions_are_put_in(pages: ModuleType) -> None:
    text = pages.filled("<!-- wiring: s5-rk512 -->\n\n<!-- questions -->\n")
    assert "| line plc |" in text
    assert "emergency_stop" in text
    assert text.count("\n| ") > 20
    assert "| analog: drives with an analog set value that stay | no |" in text
    assert "<!--" not in text


def test_every_how_to_names_a_shipped_cell_or_none() -> None:
    shipped = {path.stem for path in (ROOT / "configs" / "cells").glob("*.toml")}
    asked = {
        name for path in (ROOT / "docs").rglob("*.md") for name in re.findall(r"^<!-- wiring: (\S+) -->$", path.read_text(), re.MULTILINE)
    }
    assert asked
    assert asked <= shipped


def test_the_page_of_commands_is_made_of_all_of_them(pages: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pages, "_help", lambda entry: f"usage: {entry.value}")
    text = pages.commands()
    assert [entry.name for entry in entry_points(group="axisgate.commands") if f"## {entry.name}\n" not in text] == []


def test_exact_versions_of_the_site_name_no_place() -> None:
    lines = [line for line in (ROOT / "docs" / "requirements.lock").read_text().splitlines() if not line.startswith("#")]
    assert any(line.startswith("mkdocs-material==") for line in lines)
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines)
