"""Transparent output of a program to the screen of a PHG 2000 in a cell (rho 3 releases L9474-9886)."""

import pathlib
from dataclasses import replace

import pytest

from gateway.pure.controllers.rho3.pendant import frames
from gateway.pure.controllers.rho3.pendant.screen2000 import Screen2000
from gateway.services.rho3_panel import Rho3Panel
from hil_tests.lab.virtual.baps2_bench import CELL, ProgramCell

SOURCE = (pathlib.Path(__file__).parents[3] / "vectors/baps2/TRANSPAR.QLL").read_text()


def shown_by(source: str = SOURCE) -> dict[str, object]:
    assert CELL.controller is not None
    cell = ProgramCell({"TRANSPAR.QLL": source}, replace(CELL, controller=replace(CELL.controller, phg_unit="V24_4")))
    assert cell.run("TRANSPAR")[:2] == ("ended", 0)
    cell.bench.run(0.1)
    graphic = Rho3Panel(cell.control, cell.bench.dispatcher).answer({}, 1, cell.bench.now)["graphic"]
    assert isinstance(graphic, dict)
    return graphic


def rows_of(screen: Screen2000) -> list[str]:
    rows = screen.shown()["rows"]
    assert isinstance(rows, list)
    return rows


@pytest.mark.requirement(
    "RHO-PHG-07",
    by=("gateway.pure.controllers.rho3.pendant.frames:parse", "gateway.pure.controllers.rho3.pendant.screen2000:Screen2000.take"),
)
@pytest.mark.requirement("RHO-PHG-09", by="gateway.pure.controllers.rho3.pendant.screen2000:Screen2000._text")
def test_the_program_of_the_manual_writes_the_screen() -> None:
    shown = shown_by()
    rows = shown["rows"]
    assert isinstance(rows, list) and shown["fault"] == ""
    assert "".join(rows[5].split()) == "HALLOWORLD", "at pixel 30, 40"
    assert "".join(rows[10].split()) == "123:", "the last place is written over"
    assert (shown["mask"], shown["lines"], shown["cursors"]) == (2, [[0, 0, 255, 127]], {"34821": 3, "34068": 1})


@pytest.mark.requirement("RHO-PHG-08", by="gateway.pure.controllers.rho3.pendant.screen2000:Screen2000.take")
def test_an_output_for_another_mask_is_discarded() -> None:
    screen = Screen2000()
    screen.take(frames.sc_fuer_mask(-1) + frames.sc_neue_mask(2) + frames.sc_ende(), more=False)
    for mask, text in ((3, "three"), (2, "two"), (-1, "all")):
        screen.take(frames.sc_fuer_mask(mask) + frames.sc_text(text) + frames.sc_ende(), more=False)
    assert rows_of(screen)[0] == "twoall" and screen.dropped == 1
    screen.take(b"\x02\x00\x63", more=False)
    assert screen.fault and screen.shown()["mask"] == 2


@pytest.mark.requirement("RHO-PHG-17", by="gateway.pure.controllers.rho3.pendant.operation:operation")
def test_p35_switches_transparent_output_off() -> None:
    screen = Screen2000(p35=1)
    output = frames.sc_fuer_mask(-1) + frames.sc_text("shown") + frames.sc_ende()
    screen.take(output[:4], more=True)
    screen.take(output[4:], more=False)
    assert "P35 = 1" in screen.fault
    screen.p35 = 0
    screen.take(output, more=False)
    assert screen.fault == "" and rows_of(screen)[0] == "shown"
