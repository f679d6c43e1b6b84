"""`check` warns of SERVODYN axes that claim to be absolute over more than the motor turn that their resolver knows (AX-085)."""

import pathlib

import pytest

from gateway.cell_file.load import load_cell
from gateway.checks import notices
from gateway.files.find import find_config
from gateway.pure.cell.cell import Notice

CELL = find_config("palletiser", "cells").read_text()
REAL = CELL.replace('port     = "sim"                     # the broker', 'port     = "socketcan:can0"  # the broker')
TURN = 20.0  # mm of X


def warned(folder: pathlib.Path, text: str) -> list[Notice]:
    (folder / "palletiser").mkdir()
    (folder / "cell.toml").write_text(text)
    return [each for each in notices(load_cell(str(folder / "cell.toml"))) if "whole turns" in each.text]


def test_each_axis_on_a_real_bus_is_named_with_its_turn(tmp_path: pathlib.Path) -> None:
    found = warned(tmp_path, REAL)
    assert (found[0].level, found[0].where) == ("warning", "axis.X.home")
    assert f"{TURN:.4g} mm" in found[0].text and 'home = { by = "gateway"' in found[0].text


@pytest.mark.parametrize("text", [CELL, REAL.replace("min = -5.0, max = 1500.0", "min = 0.0, max = 19.5")])
def test_an_emulated_axis_and_one_that_moves_within_a_turn_are_not(tmp_path: pathlib.Path, text: str) -> None:
    assert "axis.X.home" not in [each.where for each in warned(tmp_path, text)]
