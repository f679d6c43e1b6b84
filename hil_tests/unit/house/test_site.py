"""The docs site: every page is in it, and what is made of the program names all of the program."""

import importlib.util
import re
from importlib.metadata import entry_points
from types import ModuleType

import pytest

from gateway.files.find import read_signals
from gateway.pure.cell.axes import PlantAxis
from gateway.pure.cell.belts import Belt
from gateway.pure.cell.cell import Axis, Bus, CellHead, CellTables, Io, IoDevice, Line, TelegramPart
from gateway.pure.cell.columns import columns
from gateway.pure.cell.controller import ControllerPoint
from gateway.pure.cell.modbus import ModbusValue
from gateway.pure.cell.northbound import NorthMqtt
from gateway.pure.cell.rho3 import OutputBlock
from hil_tests.purity import ROOT


@pytest.fixture(scope="module")
def pages() -> ModuleType:
    spec = importlib.util.spec_from_file_location("site_pages", ROOT / "docs" / "site_pages.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_page_is_in_the_navigation_once(pages: ModuleType) -> None:
    written = {
        str(path.relative_to(ROOT / "docs")) for pattern in pages.KEPT for path in (ROOT / "docs").glob(pattern) if path.suffix == ".md"
    }
    listed = re.findall(r"^ +- .*: (\S+\.md)$", pages.settings(), re.MULTILINE)
    assert sorted(listed) == sorted(written | set(pages.GENERATED))


def test_the_reference_of_the_cell_file_has_every_key_of_every_table(pages: ModuleType) -> None:
    text = pages.cell_keys()
    tables = {table for _, table in pages.tables(CellTables, "")}
    assert tables >= {
        Axis,
        Belt,
        Bus,
        CellHead,
        ControllerPoint,
        Io,
        IoDevice,
        Line,
        ModbusValue,
        NorthMqtt,
        OutputBlock,
        PlantAxis,
        TelegramPart,
    }
    assert len(tables) > 60
    keys = {key for table in tables for key, column in columns(table).items() if not column.table and not column.loaded}
    assert {key for key in keys if f"| `{key}` |" not in text} == set()
    assert "| `from` |" in text and "| `from_` |" not in text


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
