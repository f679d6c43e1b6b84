"""[[line.program]]: what `check` says, and what the cell makes of it (AX-1021)."""

import pathlib
import shutil

import pytest

from gateway.assembly.program_lines import serial_setup
from gateway.assembly.run import plan_run
from gateway.cell_file.load import load_cell
from gateway.checks.playable import not_playable
from gateway.files.find import PACKAGED
from gateway.pure.cell.faults import CellFaults
from gateway.pure.controllers.rho3.serial.setup import Function, Procedure

CELLS = PACKAGED / "cells"
LINE = '\n[[line]]\nname = "host"\nport = "sim"\nlayer = "program"\n'
UNIT = '[[line.program]]\ndevice = "V24_1"\n'


def cell_with(folder: pathlib.Path, text: str, shipped: str = "palletiser") -> str:
    if not (folder / shipped).exists() and (CELLS / shipped).is_dir():
        shutil.copytree(CELLS / shipped, folder / shipped)
    path = folder / "cell.toml"
    owned = shipped == "owned"
    source = (CELLS / f"{'palletiser' if owned else shipped}.toml").read_text() + text
    path.write_text(source.replace('"rack"', '"host"').replace('name     = "host"', 'name     = "rack"') if owned else source)
    return str(path)


def test_units_are_assigned_as_in_mode_9_1(tmp_path: pathlib.Path) -> None:
    more = 'procedure = "echo"\nformat = "4800 7E1"\noutput_timeout_ms = 0\ninput_timeout_ms = 250\n'
    cell = load_cell(cell_with(tmp_path, LINE + UNIT + UNIT.replace("V24_1", "V24_3") + more))
    setup = serial_setup(cell)
    assert setup is not None and setup.lines == ("host",)
    link, echo = setup.by_function[Function.V24_1], setup.by_function[Function.V24_3]
    assert (link.protocol, link.format, link.output_timeout_ms, link.input_timeout_ms) == (Procedure.LINK_3964R, "9600 8E1", -1, None)
    assert (echo.protocol, echo.format, echo.output_timeout_ms, echo.input_timeout_ms) == (Procedure.ECHO, "4800 7E1", 0, 250)
    high = load_cell(cell_with(tmp_path, LINE + 'priority = "high"\n' + UNIT))
    setup = serial_setup(high)
    assert setup is not None and setup.by_function[Function.V24_1].output_timeout_ms == 0
    assert serial_setup(load_cell("palletiser")) is None


def test_a_line_of_programs_is_played_and_is_no_command_source(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AXISGATE_RUNTIME", str(tmp_path / "runtime"))
    cell = load_cell(cell_with(tmp_path, LINE + UNIT))
    plan = plan_run(cell, simulated=True, slug="units")
    assert not_playable(cell) == [] and "host" not in [source.name for source in plan.sources]
    assert plan.lines["host"].startswith("pty:") and "line-host" in [child.name for child in plan.children]


@pytest.mark.parametrize(
    "text, shipped, key, hint",
    [
        (LINE, "palletiser", "line.host.layer", "the line has no unit"),
        (LINE.replace("program", "telegrams") + UNIT, "palletiser", "line.host.program", 'units of programs need layer = "program"'),
        (LINE + UNIT, "demo", "line.host.layer", "units belong to BAPS2 programs"),
        (LINE + UNIT + UNIT, "palletiser", "line.host.program", "the unit is on line host already"),
        (LINE + UNIT, "owned", "rc_inputs.owner", "no such"),
        (LINE + UNIT.replace("V24_1", "V24_5"), "palletiser", "line.host.program", "V24_4"),
    ],
)
def test_what_check_refuses(tmp_path: pathlib.Path, text: str, shipped: str, key: str, hint: str) -> None:
    with pytest.raises(CellFaults) as found:
        load_cell(cell_with(tmp_path, text, shipped))
    assert any(key in str(fault) and hint in str(fault) for fault in found.value.faults), found.value.faults
