"""Mode 7.8.2 of the pendant in a cell: parameters that a password protects (rho 3 releases L5036-5067)."""

from dataclasses import replace

import pytest

from gateway.pure.cell.rho3 import Rho3
from gateway.services.rho3_panel import Rho3Panel
from hil_tests.lab.virtual.baps2_bench import CELL, ProgramCell, one

MODE = ("MODE", "0", ".", "7", ".", "8", ".", "2", "ENTER")


def cell_with(password: str) -> ProgramCell:
    assert CELL.controller is not None
    cell = replace(CELL, rho3=Rho3(others={"P9": 200, "P2": 5, "P14": (100, 12)}), controller=replace(CELL.controller, password=password))
    return ProgramCell(one("HALT"), cell)


def pressed(cell: ProgramCell, *keys: str) -> list[str]:
    panel = Rho3Panel(cell.control, cell.bench.dispatcher)
    for key in keys:
        panel.answer({"key": key}, 1, cell.bench.now)
        cell.bench.run(0.05)
    return [line.rstrip() for line in cell.control.functions.display.screen()][1:]


@pytest.mark.requirement("RHO-PHG-14", by="gateway.pure.controllers.rho3.signals.panel_view:PanelView.locked")
def test_a_protected_parameter_wants_the_password() -> None:
    cell = cell_with("4711")
    assert pressed(cell, *MODE) == ["P2", "P9", ""]
    assert pressed(cell, "ENTER") == ["P2", "Enter password!", ""]
    assert pressed(cell, "DOWN") == ["P2", "P9", "Password"], "any key goes on"
    assert pressed(cell, "4", "7") == ["P2", "P9", "Password **"]
    assert pressed(cell, "1", "2", "ENTER") == ["P2", "Enter password!", ""]
    assert pressed(cell, "ENTER", "ENTER") == ["P2", "P9", "Password"]


@pytest.mark.requirement("RHO-PHG-14", by="gateway.pure.controllers.rho3.signals.panel_view:PanelView.unlock")
def test_the_right_password_opens_until_the_mode_is_left() -> None:
    cell = cell_with("4711")
    assert pressed(cell, *MODE, "ENTER", "ENTER", "4", "7", "1", "1", "ENTER") == ["P2", "P9", ""]
    assert pressed(cell, "DOWN", "DOWN", "ENTER") == ["P14", "100 12", ""]
    assert pressed(cell, *MODE, "ENTER") == ["P2", "Enter password!", ""]


def test_without_a_password_none_is_protected() -> None:
    assert pressed(cell_with(""), *MODE, "ENTER") == ["P2", "5", ""]
