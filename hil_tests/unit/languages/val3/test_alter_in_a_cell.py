"""alter of an application in a cell of emulated drives, in virtual time: from a synchronous task to the set values (AX-1062)."""

from dataclasses import replace

import pytest

from gateway.cell_file.load import load_cell
from gateway.files.find import find_config, read_text
from gateway.pure.cell.faults import CellFaults
from gateway.pure.image.records.cell import Motion
from hil_tests.lab.virtual.val3_cell_bench import Val3Cell
from hil_tests.unit.languages.val3.apps import App, datum, value
from motion.geometry.units import to_si

DATA = (
    datum("jA", "joint", "1", value(j1=5, j2=30, j3=90, j5=60))
    + datum("mFast", "mdesc", "1", value(vel=50, accel=50, decel=50, blend="off"))
    + datum("mSlow", "mdesc", "1", value(vel=15, accel=40, decel=40, blend="off"))
    + datum("mA", "mdesc", "1", value(vel=100, accel=100, decel=100, tmax=400, rmax=400, blend="off"))
    + datum("p", "point", "3", value("0", fatherId="world[0]"))
    + datum("tr", "trsf")
    + datum("f", "frame", "1", value(fatherId="world[0]"))
    + datum("diPart", "dio", "1", value(link="UserIO\\part"))
    + datum("bLate", "bool")
    + datum("n", "num", "16")
    + datum("nTop", "num", "1", value(value=30))
    + datum("nDone", "num")
)
START = (410.151, 55.960, 401.147)  # mm, where the altered path begins
HOME = """enablePower()
wait(isPowered())
movej(jA,flange,mFast)
waitEndMove()
p[0]=here(flange,world)
p[1]=appro(p[0],{0,0,-60,0,0,0})
"""
SENSOR = "while true\nn[0]=alter(tr)\nif n[0]==1\ntr.y=min(tr.y+0.1,nTop)\nendIf\ndelay(0)\nendWhile"


def cell_of(code: str, **programs: str) -> Val3Cell:
    return Val3Cell(App(data=DATA, programs={"start": HOME + code, **programs}).files(), "demo")


def tip(cell: Val3Cell, at: int = -1) -> tuple[float, ...]:
    """Flange, mm, as the cycle has set it."""
    machine = cell.setup.machine
    return tuple(1e3 * each for each in machine.forward([to_si(value, "deg") for value in cell.places[at]]).position)


def numbers(cell: Val3Cell) -> list[float]:
    assert cell.language.own is not None
    found = cell.language.own.data["n"]
    assert isinstance(found, list)
    return [float(str(each)) for each in found]


def done(cell: Val3Cell, count: float = 1.0) -> None:
    cell.until(lambda: cell.language.own is not None and cell.value("nDone") == count)


PATH = """alterMovel(p[1],flange,mSlow)
taskCreateSync "s",0.004,bLate,s()
delay(0.02)
n[3]=alterBegin(f,mA)
n[4]=alterBegin(f,mA)
waitEndMove()
nDone=1
delay(1)
nDone=2
delay(0.02)
taskKill("s")
"""


@pytest.mark.requirement("VAL-ALT-01", by="gateway.pure.languages.val3.cell_alter:CellAlter.alter")
@pytest.mark.requirement("VAL-ALT-03", by="gateway.pure.languages.val3.cell_mover:StreamMover.resting")
def test_a_synchronous_task_alters_the_path_and_the_standard_move_goes_on_from_there() -> None:
    code = "n[1]=alter(tr)\nn[2]=alterEnd()\n" + PATH
    code += "n[5]=alterEnd()\nn[6]=alter(tr)\nmovel(p[0],flange,mSlow)\nwaitEndMove()\nn[7]=alterStopTime()\nnDone=3\nwait(diPart)"
    cell = cell_of(code, s=SENSOR)
    cell.start()
    cell.until(lambda: cell.language.own is not None and numbers(cell)[1] == -1)
    since = len(cell.places)
    done(cell)
    assert tip(cell)[1] < START[1] + 28, "waitEndMove: the end of the theoretical path"
    done(cell, 2.0)
    assert tip(cell) == pytest.approx((START[0], START[1] + 30, START[2] + 60), abs=0.01), "it is altered on behind its end"
    steps = [abs(tip(cell, at)[1] - tip(cell, at - 1)[1]) for at in range(since, len(cell.places))]
    assert max(steps) < 0.15, "no jump where it begins"
    done(cell, 3.0)
    cell.bench.run(0.1)
    assert tip(cell) == pytest.approx(START, abs=0.01)
    assert numbers(cell)[:8] == [1, -1, -1, 0, 0, 1, -1, 0], "0 while it waits for its path (L6389)"


def test_a_program_repeats_alter_begin_until_its_path_begins() -> None:
    code = """alterMovel(p[1],flange,mSlow)
while alterBegin(f,mA)!=1
n[0]=n[0]+1
delay(0)
endWhile
n[1]=alter(tr)
n[2]=alterBegin(f,mA)
n[3]=alterEnd()
waitEndMove()
nDone=1
wait(diPart)"""
    cell = cell_of(code)
    cell.start()
    done(cell)
    assert numbers(cell)[0] > 0 and numbers(cell)[1:4] == [1, -1, 1], "0 while it waits, then 1, then -1 (L6388-6390)"


@pytest.mark.requirement("VAL-ALT-02", by="gateway.pure.languages.val3.cell_alter:CellAlter.begin")
def test_alter_begin_behind_a_queued_standard_move_is_for_the_next_path() -> None:
    code = """n[0]=alterBegin(f,mA)
alterMovel(p[1],flange,mSlow)
delay(0.2)
tr.y=0.5
n[1]=alter(tr)
n[2]=alterEnd()
n[3]=alterBegin(f,mA)
movel(p[0],flange,mSlow)
n[4]=alterBegin(f,mA)
alterMovel(p[1],flange,mSlow)
n[5]=alter(tr)
waitEndMove()
tr.y=-0.5
n[6]=alter(tr)
delay(0.1)
nDone=1
n[7]=alterEnd()
delay(0.1)
n[8]=alterBegin(f,mA)
movel(p[0],flange,mSlow)
waitEndMove()
n[9]=alterBegin(f,mA)
nDone=2
wait(diPart)"""
    cell = cell_of(code)
    cell.start()
    done(cell)
    assert tip(cell) == pytest.approx((START[0], START[1] - 0.5, START[2] + 60), abs=0.01)
    done(cell, 2.0)
    assert tip(cell) == pytest.approx(START, abs=0.01)
    assert numbers(cell)[:10] == [0, 1, 1, -1, 0, -1, 1, 1, -1, 0], "one alterBegin a path (L6294); a standard move allows the next"


@pytest.mark.requirement("VAL-ALT-01", by="gateway.pure.languages.val3.cell_alter:CellAlter.correct")
def test_a_value_is_in_force_in_the_next_4_ms() -> None:
    code = "alterBegin(f,mA)\nalterMovel(p[1],flange,mSlow)\ndelay(0.3)\ntr.x=0.5\nn[1]=alter(tr)\nnDone=1\nwait(diPart)"
    cell = cell_of(code)
    cell.start()
    done(cell)
    before = tip(cell)[0]
    cell.bench.run(0.012)
    ways = [tip(cell, at)[0] - before for at in (-3, -2, -1)]
    assert ways[1] == pytest.approx(0.5, abs=0.01), ways


@pytest.mark.requirement("VAL-ALT-01", by="gateway.pure.languages.val3.cell_alter:CellAlter.over")
def test_too_fast_an_alteration_locks_until_reset_motion_and_the_next_move_is_150() -> None:
    code = """alterMovel(p[1],flange,mSlow)
n[0]=alterBegin(f,mA)
delay(0.3)
tr.y=50
n[1]=alter(tr)
delay(0.2)
n[2]=alter(tr)
taskCreate "m",10,more()
delay(0.1)
n[3]=taskStatus("m")
taskKill("m")
n[4]=alterBegin(f,mA)
nDone=1
delay(0.1)
resetMotion()
n[5]=alter(tr)
movel(p[0],flange,mSlow)
waitEndMove()
nDone=2
wait(diPart)"""
    cell = cell_of(code, more="movel(p[0],flange,mSlow)")
    cell.start()
    done(cell)
    halted = tip(cell)
    assert halted[1] < START[1] + 1, "it halts at its last valid position"
    done(cell, 2.0)
    assert numbers(cell)[:6] == [0, 1, -3, 150, -3, -1] and tip(cell) == pytest.approx(START, abs=0.01)


@pytest.mark.requirement("VAL-ALT-02", by="gateway.pure.languages.val3.cell_alter:CellAlter.stop_time")
def test_alter_of_a_tool_is_locked_after_the_stop_time_and_its_end_before_the_path_freezes_it() -> None:
    code = """alterBegin(flange,mA)
alterMovel(p[1],flange,mSlow)
delay(0.2)
n[0]=alterStopTime()
tr.x=0.5
n[1]=alter(tr)
delay(0.02)
stopMove()
delay(0.05)
n[2]=alterStopTime()
n[3]=alter(tr)
delay(0.6)
n[4]=alterStopTime()
n[5]=alter(tr)
restartMove()
delay(0.1)
n[6]=alter(tr)
n[7]=alterEnd()
n[8]=alterBegin(f,mA)
waitEndMove()
nDone=1
movel(p[0],flange,mSlow)
waitEndMove()
nDone=2
wait(diPart)"""
    cell = cell_of(code)
    cell.start()
    done(cell)
    found = numbers(cell)
    assert found[0] == -1 and 0 < found[2] < 0.5
    assert (found[1], found[3], found[4:9]) == (1, 1, [0, 0, 1, 1, -1])
    done(cell, 2.0)
    assert tip(cell) == pytest.approx(START, abs=0.01)


def test_the_interpreter_dies_under_an_altered_path_and_the_arm_stops() -> None:
    cell = cell_of(PATH, s=SENSOR)
    run = cell.start()
    cell.until(lambda: cell.language.own is not None and numbers(cell)[0] == 1)
    cell.bench.run(0.2)
    cell.dies()
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE, 5.0)
    assert cell.hosted.results[run][0] == "lost" and tip(cell)[2] < START[2] + 59
    rest = cell.at()
    cell.born(2)
    cell.bench.run(0.5)
    assert cell.at() == rest


def test_without_the_option_alter_begin_is_minus_2_and_the_path_is_run_as_it_is() -> None:
    code = "n[0]=alterBegin(f,mA)\nn[1]=alter(tr)\nalterMovel(p[1],flange,mSlow)\nwaitEndMove()\nnDone=1\nwait(diPart)"
    cell = cell_of(code)
    cell.setup = replace(cell.setup, alter=None)
    cell.born(1)
    cell.start()
    done(cell)
    assert numbers(cell)[:2] == [-2, -2] and tip(cell) == pytest.approx((START[0], START[1], START[2] + 60), abs=0.01)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('type   = "REAL"', 'type   = "INT"', "an application corrects with six REAL"),
        ("status = 256", "", "an application needs the two answer words"),
        ("input  = 256", "input  = 704", "25 bytes of RC inputs are needed"),
        ("input  = 256", "input  = 256\nlife = 512", "an application has no life byte"),
    ],
)
def test_an_alter_table_that_no_application_can_use(old: str, new: str, words: str) -> None:
    text = read_text(find_config("cs8", "cells"))
    assert old in text
    with pytest.raises(CellFaults, match=words):
        load_cell(str(find_config("cs8", "cells")), text.replace(old, new))
