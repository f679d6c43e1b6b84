"""A cell made of a flash card, with real processes: its application moves the emulated drives and alters its path (AX-990, AX-1062)."""

import pathlib

import pytest

from gateway.assembly.val3_application import setup_of
from gateway.cell_file.load import load_cell
from gateway.commands.val3 import main
from gateway.tools.client import running
from hil_tests.lab.running.cell_running import COMES_UP_S, running_cell
from hil_tests.rig.programs.test_val3_guide import PATIENCE_S, PLAYS, Disturbed, looks, types, waits
from hil_tests.unit.languages.val3.apps import App, datum, value
from hil_tests.unit.languages.val3.test_import import card
from motion.geometry.units import to_si

DATA = (
    datum("jA", "joint", "1", value(j1=5, j2=30, j3=90, j5=60))
    + datum("mFast", "mdesc", "1", value(vel=60, accel=60, decel=60, blend="off"))
    + datum("mA", "mdesc", "1", value(vel=100, accel=100, decel=100, tmax=400, rmax=400, blend="off"))
    + datum("p", "point", "2", value("0", fatherId="world[0]"))
    + datum("tr", "trsf")
    + datum("f", "frame", "1", value(fatherId="world[0]"))
    + datum("doDone", "dio", "1", value(link="UserIO\\done"))
    + datum("bLate", "bool")
)
START = """enablePower()
wait(isPowered())
movej(jA,flange,mFast)
waitEndMove()
p[0]=here(flange,world)
p[1]=appro(p[0],{0,0,-40,0,0,0})
alterMovel(p[1],flange,mFast)
alterBegin(f,mA)
taskCreateSync "sensor",0.004,bLate,sensor()
wait(tr.y>=6)
waitEndMove()
taskKill("sensor")
alterEnd()
doDone=true
wait(false)"""
SENSOR = "while true\nif alter(tr)==1\ntr.y=min(tr.y+0.05,6)\nendIf\ndelay(0)\nendWhile"
REST = (410.151, 55.960 + 6, 401.147 + 40)  # mm
pytestmark = pytest.mark.timeout(PLAYS * (COMES_UP_S + 2 * PATIENCE_S))


@pytest.mark.requirement("VAL-ALT-01", by="gateway.pure.languages.val3.cell_alter:CellAlter.correct")
def test_a_card_becomes_a_cell_that_moves(tmp_path: pathlib.Path) -> None:
    made = card(tmp_path, App("glue", DATA, {"start": START, "sensor": SENSOR}), sio_cfx="<sio></sio>")
    cell = tmp_path / "glue.toml"
    assert main(["import", str(made), "--out", str(cell)]) == 0
    table = load_cell(str(cell))
    assert table.val3 is not None
    machine = setup_of(table, table.val3).machine
    for play in range(PLAYS):
        with running_cell(str(cell), f"glue-{play}", plc=False, p5_ms=None) as run:
            try:
                types(run, "axisgate program start cs8 glue")
                waits(run, lambda _: looks(run, "axisgate var dio.done --name cs8").strip().endswith("1"), "the path is done")
            except Disturbed:
                continue
            with running(run.name) as client:
                there = [to_si(float(str(row["actual"])), "deg") for row in client.axes()]
            assert [1e3 * each for each in machine.forward(there).position] == pytest.approx(REST, abs=0.1)
            assert "error" not in types(run, "axisgate program status cs8")
            return
    raise AssertionError(f"the machine was late in each of {PLAYS} plays")
