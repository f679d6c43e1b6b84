"""Positions in the frame of a station, in a cell of emulated drives (L366-422, L1122, AX-1052)."""

import math
from dataclasses import replace

import pytest

from gateway.cell_file.load import CellFaults, load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.cell.controller import ControllerStation
from hil_tests.lab.virtual.reis_bench import CELL, ReisCell, main

TABLE = ControllerStation(2, (800.0, 100.0, 500.0, 0.0, 0.0, 90.0))  # its X is Y of the basic system


def cell_with(body: str, *stations: ControllerStation) -> ReisCell:
    assert CELL.controller is not None
    values = main("VAR V1, X:10, Y:0, Z:0, A:0, B:0, C:0\nVAR V2\nVAR P1", "V")
    return ReisCell(main(f"{body}\nSTOP") | values, cell=replace(CELL, controller=replace(CELL.controller, station=stations)))


def position(x: float, y: float, z: float, frame: int = 2) -> str:
    return f"POSITION #N, X:{x:g}, Y:{y:g}, Z:{z:g}, A:180, B:0, C:90, Frame:{frame}"


def test_a_position_of_a_station_is_one_in_its_frame() -> None:
    cell = cell_with(f"{position(20, 0, 91)}\nMOVE_MODE #LINEAR\nPATH_SPEED 200\n{position(120, -50, 91)}\nACT_POS P1", TABLE)
    assert cell.run()[0] == "ended", cell.told
    assert cell.where() == pytest.approx((850, 220, 591), abs=0.05)
    assert [float(str(cell.value(f"P1.{name}"))) for name in ("X", "Y", "Z")] == pytest.approx([850, 220, 591], abs=0.05)
    assert any(math.dist(place[:3], (800, 120, 591)) < 0.1 for place in cell.places)
    speed = max(math.dist(a[:3], b[:3]) for a, b in zip(cell.places[-40:], cell.places[-39:], strict=False)) / 0.004
    assert speed < 205, "the way is measured in one system"


def test_a_position_out_of_reach_is_reported_without_the_number_of_another_control() -> None:
    how, _, text = cell_with(position(5850, 0, 400, frame=0)).run()[:3]
    assert how == "aborted" and text.startswith("point not reachable: ") and "VAL 3" not in text


def test_relative_and_calc_rel_count_in_the_frame_of_the_position() -> None:
    cell = cell_with(f"RELATIVE V1\n{position(20, 0, 91)}\nRELATIVE _VNULL\nCALC_REL V2\n{position(25, 5, 90)}", TABLE)
    assert cell.run()[0] == "ended", cell.told
    assert cell.where() == pytest.approx((800, 130, 591), abs=0.05), "10 mm along X of the table"
    assert [float(str(cell.value(f"V2.{name}"))) for name in ("X", "Y", "Z", "Frame")] == pytest.approx([5, -5, 1, 2], abs=0.05)


def test_a_frame_without_a_station_is_an_error_of_its_step() -> None:
    cell = cell_with(position(20, 0, 91, frame=3), TABLE)
    how, _, text, place = cell.run()
    assert (how, place) == ("aborted", "P step 3")
    assert text == "frame 3: this cell has no such station; [[controller.station]] names 2"


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("number = 2\nat = [0.0, 0.0]", "at"),
        ("number = 0\nat = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]", "number"),
        ("number = 1\nat = [0.0, 0.0, 0.0, 0.0, 0.0, nan]", "a finite number"),
        (
            "number = 1\nat = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]\n[[controller.station]]\nnumber = 1\nat = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]",
            "two stations",
        ),
    ],
)
def test_stations_that_do_not_fit(more: str, words: str) -> None:
    text = read_text(find_config("demo", "cells"))
    with pytest.raises(CellFaults) as found:
        load_cell("cell.toml", f"{text}[controller]\nkind = 'reis'\n[[controller.station]]\n{more}\n")
    assert any("controller.station" in str(fault) and words in str(fault) for fault in found.value.faults), found.value.faults


def test_stations_belong_to_a_reis() -> None:
    text = read_text(find_config("demo", "cells"))
    station = "number = 1\nat = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]"
    with pytest.raises(CellFaults, match=r"controller\.station") as found:
        load_cell("cell.toml", f"{text}[controller]\nkind = 'val3'\n[[controller.station]]\n{station}\n")
    assert 'stations belong to kind = "reis"' in str(found.value.faults[0])
