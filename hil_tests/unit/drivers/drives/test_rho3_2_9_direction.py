"""rho3 2.9 (L3895-3927): both signs reverse an axis, one alone never lets it arrive."""

import math

import pytest

from drivers.drives.scaling import Scaling, ScalingError
from drivers.drives.servodyn import Power
from gateway.cell_file.load import CellFaults, load_cell
from gateway.files.find import find_config, read_text
from hil_tests.lab.virtual.one_axis import OneAxis

WAY = 2.0  # rad of an axis without gear: 5215 increments


def moved(direction: int, output: int) -> tuple[float, float, bool]:
    """(way of the shaft, way of the axis, in control at the end) for a set value that goes WAY up."""
    axis = OneAxis(Scaling(direction=direction, output=output))
    axis.enable()
    axis.zero_here()
    shaft = axis.shaft_rad
    axis.goal, axis.speed = WAY, 4.0
    axis.run(2.0)
    return axis.shaft_rad - shaft, axis.position, axis.drive.power is Power.ENABLED


@pytest.mark.requirement("RHO-CAN-19", by=("drivers.drives.scaling:Scaling.to_inc", "drivers.drives.scaling:Scaling.to_si"))
def test_both_signs_move_mirrored_and_one_alone_never_reaches_the_position() -> None:
    shaft, axis, stays = moved(1, 1)
    assert stays and (shaft, axis) == pytest.approx((WAY, WAY), abs=0.01)
    shaft, axis, stays = moved(-1, -1)
    assert stays and (shaft, axis) == pytest.approx((-WAY, WAY), abs=0.01)
    for direction, output in ((1, -1), (-1, 1)):
        shaft, axis, _ = moved(direction, output)
        assert math.isfinite(axis) and abs(axis - WAY) > 0.9 * WAY, "one sign alone arrived"


@pytest.mark.requirement("RHO-CAN-19", by="gateway.checks.axes:measuring_systems")
def test_check_refuses_one_sign_alone_in_p401_and_takes_both() -> None:
    text = read_text(find_config("rho3-servodyn", "cells"))

    def told(edited: str) -> list[str]:
        try:
            load_cell("cell.toml", edited)
        except CellFaults as found:
            return [str(fault) for fault in found.faults]
        return []

    assert told(text) == []  # axis 2 has -16384.0 and -2
    (only,) = told(text.replace("output = -2", "output = 2")) or [""]
    assert "rho3.P401.2.output" in only and "never reaches position" in only
    (other,) = told(text.replace("evaluation = -16384.0", "evaluation = 16384.0")) or [""]
    assert "rho3.P401.2.output" in other


def test_an_axis_reversed_by_both_signs_is_the_cells_direction() -> None:
    cell = load_cell("rho3-servodyn")
    assert [axis.mechanics.direction for axis in cell.axis] == ["+", "-", "+", "+", "+", "+"]


def test_a_sign_is_a_sign() -> None:
    with pytest.raises(ScalingError, match="output 2"):
        Scaling(output=2)
