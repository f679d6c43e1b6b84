"""The start program of the integrated PLC is what a robot program has written into _SPLC_PATH and _SSTARTPLC: L2371-2396, L2865-2877."""

import pathlib
from dataclasses import replace

import pytest

from gateway.assembly.integrated_plc import SYSTEM_VALUES, start_program
from gateway.pure.cell.cell import Cell
from gateway.pure.cell.controller import ControllerPlc
from gateway.pure.languages.robotstar.cell_run import SYSTEM
from hil_tests.lab.virtual.reis_bench import SHIPPED, ReisCell, main

ASSEMBLY = "gateway.assembly.integrated_plc:start_program"


def cell_in(folder: pathlib.Path) -> Cell:
    (folder / "memory").mkdir()
    assert SHIPPED.controller is not None
    plc = ControllerPlc("MAIN", "memory/PLC")
    return replace(SHIPPED, file=str(folder / "cell.toml"), controller=replace(SHIPPED.controller, memory="memory", plc=plc))


@pytest.mark.requirement("RSV-PLC-02", by=ASSEMBLY)
@pytest.mark.parametrize(
    ("body", "start"),
    [
        ("WAIT 0.0", "MAIN"),
        ('COPY "OTHER", _SSTARTPLC', "OTHER"),
        ('COPY "PROJEKT1/MAIN   ", _SSTARTPLC', "PROJEKT1/MAIN"),
        ('COPY "S:/PLC/PROJEKT1", _SPLC_PATH\nCOPY "HAUPT und mehr", _SSTARTPLC', "PROJEKT1/HAUPT"),
        ('COPY "/plc", _SPLC_PATH\nCOPY "main", _SSTARTPLC', "MAIN"),
        ('COPY "                ", _SSTARTPLC', ""),
    ],
)
def test_a_robot_program_names_the_start_program(tmp_path: pathlib.Path, body: str, start: str) -> None:
    cell = cell_in(tmp_path)
    robot = ReisCell(main(f"{body}\nSTOP"))
    robot.language.restore(SYSTEM, '_SSTARTPLC = "MAIN"')
    assert robot.run()[0] == "ended", robot.told
    (tmp_path / "memory" / SYSTEM_VALUES).write_text(robot.language.values()[SYSTEM], encoding="utf-8")
    assert start_program(cell) == start


def test_without_kept_values_it_is_that_of_the_table(tmp_path: pathlib.Path) -> None:
    assert start_program(cell_in(tmp_path)) == "MAIN"


def test_a_path_that_is_not_the_folder_of_the_plc_is_named(tmp_path: pathlib.Path) -> None:
    cell = cell_in(tmp_path)
    (tmp_path / "memory" / SYSTEM_VALUES).write_text('_SPLC_PATH = "S:/OTHER"\n')
    with pytest.raises(ValueError, match="S:/OTHER/MAIN: the programs of this PLC are in S:/PLC"):
        start_program(cell)
