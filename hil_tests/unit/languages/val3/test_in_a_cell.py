"""A VAL 3 application in a cell of emulated drives, in virtual time: moves, signals, stops, power, errors, deaths (AX-930, AX-931)."""

from dataclasses import replace

import pytest

from gateway.pure.arbitration.command_block import Code
from gateway.pure.controllers.val3.io.system import Board, Point
from gateway.pure.image.records.cell import Motion
from gateway.pure.languages.val3.cell_io import CellIo
from hil_tests.lab.virtual.val3_cell_bench import DONE, FOLDER, PART, TOOL, VALVE, Val3Cell
from hil_tests.unit.languages.val3.apps import App, datum, machine, run, value

DATA = (
    datum("jA", "joint", "1", value(j1=5, j2=30, j3=90, j5=60))
    + datum("jB", "joint", "1", value(j1=15, j2=30, j3=90, j5=60))
    + datum("jC", "joint", "1", value(j1=15, j2=35, j3=90, j5=60))
    + datum("jFar", "joint", "1", value(j1=500, j2=30, j3=90, j5=60))
    + datum("jNow", "joint")
    + datum("tHand", "tool", "1", value(z=50, fatherId="flange[0]", ioLink="valve1"))
    + datum("mBlend", "mdesc", "1", value(vel=50, accel=50, decel=50, blend="joint", leave=30, reach=30))
    + datum("mStop", "mdesc", "1", value(vel=50, accel=50, decel=50, blend="off"))
    + datum("mSlow", "mdesc", "1", value(vel=5, accel=20, decel=20, blend="off"))
    + datum("diPart", "dio", "1", value(link="UserIO\\part"))
    + datum("doDone", "dio", "1", value(link="done"))
    + datum("doNowhere", "dio", "1", value(link="elsewhere"))
    + "".join(datum(f"n{name}", "num") for name in ("One", "Two", "Id"))
)
POWER = "enablePower()\nwait(isPowered())\n"


def cell_of(code: str, stop: str = "", **programs: str) -> Val3Cell:
    app = App(data=DATA, programs={"start": POWER + code, "stop": stop, **programs})
    return Val3Cell(app.files(), "demo")


def joint(cell: Val3Cell, number: int) -> float:
    return cell.at()[number - 1]


@pytest.mark.requirement("VAL-MOV-01", by="gateway.pure.languages.val3.cell_mover:StreamMover._hand_on")
def test_the_shipped_application_carries_a_part() -> None:
    files = {path.relative_to(FOLDER).as_posix(): path.read_bytes() for path in FOLDER.rglob("*") if path.is_file()}
    files["cycle/cycle.dtx"] = files["cycle/cycle.dtx"].replace(b'value="2"', b'value="1"')
    cell = Val3Cell(files)
    run = cell.start()
    cell.until(lambda: any(row["program"] == "start" and row["line"] == 11 for row in cell.hosted.rows))
    cell.put(PART)
    assert cell.ends(run, 60.0) == ("ended", 0, "", "cycle")
    assert [(bit, on) for _, bit, on in cell.outputs if bit == VALVE] == [(VALVE, True), (VALVE, False), (VALVE, True)]
    assert [(bit, on) for _, bit, on in cell.outputs if bit == DONE] == [(DONE, True), (DONE, False)]
    for corner in ((30, 40, 90, 0, 50, 0), (-40, 40, 90, 0, 50, 0)):
        assert any(place == pytest.approx(corner, abs=0.01) for place in cell.places)
    assert cell.at() == pytest.approx((0, 20, 100, 0, 60, 0), abs=0.01)
    cell.until(lambda: cell.bench.dispatcher.owner == 0, 2.0)


def test_power_waits_for_drives_that_start_later_than_the_application() -> None:
    cell = cell_of("nOne=1\nwait(diPart)")
    cell.bench.silent.add(1)
    cell.start()
    cell.bench.run(3.0)
    assert cell.language.own is not None and cell.value("nOne") == 0.0
    cell.bench.silent.clear()
    cell.until(lambda: cell.value("nOne") == 1.0, 3.0)


def test_a_move_at_rest_is_in_the_fourth_cycle_behind_its_input() -> None:
    """The turn that runs movej hands it on, and the planner makes its law in the turn that takes it."""
    cell = cell_of("movej(jA,tHand,mStop)\nwaitEndMove()\nnOne=1\nwait(diPart)\nmovej(jB,tHand,mStop)\nwaitEndMove()")
    cell.start()
    cell.until(lambda: cell.language.own is not None and cell.value("nOne") == 1.0)
    cell.bench.run(0.05)
    rest, before = cell.places[-1], len(cell.places)
    cell.put(PART)
    cell.until(lambda: cell.places[-1] != rest, 1.0)
    assert len(cell.places) - before <= 4


def test_with_blending_the_arm_waits_at_leave_for_the_next_move() -> None:
    code = "movej(jA,tHand,mBlend)\ndelay(1.5)\njNow=herej()\nnOne=jNow.j1\nmovej(jC,tHand,mBlend)\nwaitEndMove()\nnTwo=1"
    cell = cell_of(code + "\nwait(diPart)")
    cell.start()
    cell.until(lambda: cell.language.own is not None and cell.value("nTwo") == 1.0)
    rest = float(str(cell.value("nOne")))
    assert 1.0 < rest < 4.9, "it rests where the blending would begin, short of 5 deg"
    assert cell.at() == pytest.approx((15, 35, 90, 0, 60, 0), abs=0.01), "waitEndMove runs the last move to its end"


def test_wait_end_move_waits_for_every_block_behind_a_rest() -> None:
    """Blocks that follow a rest together with the end of the path are not over before they have begun."""
    code = "movej(jA,tHand,mStop)\nwaitEndMove()\ndelay(0.3)\nmovej(jB,tHand,mBlend)\nmovej(jC,tHand,mStop)\nwaitEndMove()\njNow=herej()"
    cell = cell_of(code + "\nnOne=1\nwait(diPart)")
    cell.start()
    cell.until(lambda: cell.language.own is not None and cell.value("nOne") == 1.0)
    assert cell.at() == pytest.approx((15, 35, 90, 0, 60, 0), abs=0.01)


def test_stop_move_holds_on_the_path_and_restart_move_goes_on() -> None:
    code = "movej(jA,tHand,mStop)\nwaitEndMove()\nmovej(jB,tHand,mSlow)\ndelay(0.8)\nstopMove()\nnOne=1\n"
    code += "wait(diPart)\nrestartMove()\nwaitEndMove()"
    cell = cell_of(code)
    run = cell.start()
    cell.until(lambda: cell.language.own is not None and cell.value("nOne") == 1.0 and cell.bench.core.state.motion is Motion.STOPPED)
    held = cell.at()
    assert 5.0 < held[0] < 15.0
    cell.bench.run(0.5)
    assert cell.at() == held
    cell.put(PART)
    assert cell.ends(run)[0] == "ended"
    assert cell.at()[0] == pytest.approx(15, abs=0.01)


def test_reset_motion_drops_what_is_queued_and_the_next_move_begins_there() -> None:
    code = "movej(jB,tHand,mSlow)\nmovej(jC,tHand,mSlow)\ndelay(0.8)\nresetMotion()\nnOne=1\n"
    code += "movej(jA,tHand,mStop)\nwaitEndMove()\nnId=getMoveId()"
    cell = cell_of(code + "\nwait(diPart)")
    cell.start()
    cell.until(lambda: cell.language.own is not None and cell.value("nId") != 0.0)
    assert cell.value("nId") == 1.0, "ids count from 0 again"
    assert cell.at() == pytest.approx((5, 30, 90, 0, 60, 0), abs=0.01)
    assert max(place[0] for place in cell.places) < 14.0, "jB was never reached"


def test_a_move_that_cannot_be_run_stops_its_task_with_154_and_is_an_error_of_the_cell() -> None:
    cell = cell_of("movej(jFar,tHand,mStop)\nwaitEndMove()")
    run = cell.start()
    cell.until(lambda: bool(cell.programs.faults()))
    (fault,) = cell.programs.faults()
    assert "task demo~, start line 4: error 154" in fault and "520" in fault
    row = cell.hosted.rows[0]
    assert (row["task"], row["program"], row["line"], row["state"]) == ("demo~", "start", 4, "error")
    assert cell.bench.core.state.motion is Motion.IDLE
    cell.programs.answer({"do": "stop", "name": "demo"}, 0)
    assert cell.ends(run)[0] == "stopped" and cell.programs.faults() == []


def test_power_lost_on_the_path_is_met_again_by_a_connection_move() -> None:
    code = "autoConnectMove(true)\nmovej(jA,tHand,mStop)\nmovej(jB,tHand,mSlow)\nwaitEndMove()"
    cell = cell_of(code)
    run = cell.start()
    cell.until(lambda: cell.places[-1][0] > 7.0)
    cell.bench.give(Code.DISABLE, source=cell.hosted.source)
    cell.until(lambda: not cell.language._robot.powered)
    cell.bench.run(1.0)
    assert any("the path is left" in line for line in cell.words)
    held = cell.at()[0]
    assert 5.0 < held < 14.0 and cell.hosted.run == run, "the application goes on; its arm waits"
    cell.bench.give(Code.ENABLE, source=cell.hosted.source)
    assert cell.ends(run)[0] == "ended"
    assert cell.at() == pytest.approx((15, 30, 90, 0, 60, 0), abs=0.01)


def test_a_stop_of_another_source_holds_until_the_operator_lets_it_move() -> None:
    cell = cell_of("movej(jA,tHand,mStop)\nmovej(jB,tHand,mSlow)\nwaitEndMove()")
    run = cell.start()
    cell.until(lambda: cell.places[-1][0] > 6.0)
    cell.bench.give(Code.STOP, source=1)
    cell.until(lambda: cell.bench.core.state.motion is Motion.STOPPED)
    held = cell.at()
    cell.bench.run(1.0)
    assert cell.at() == held
    cell.control.put("val3.move", 1.0)
    assert cell.ends(run)[0] == "ended" and cell.at()[0] == pytest.approx(15, abs=0.01)


@pytest.mark.parametrize("before", ["", "stopMove()\ndelay(0.5)\nresetMotion()\nmovej(jB,tHand,mSlow)\n"])
def test_what_released_one_stop_does_not_release_the_next(before: str) -> None:
    cell = cell_of(f"movej(jA,tHand,mStop)\nmovej(jB,tHand,mSlow)\ndelay(0.8)\n{before}doDone=true\nwaitEndMove()")
    run = cell.start()
    cell.until(lambda: bool(cell.outputs) and cell.places[-1][0] > 6.0)
    if not before:
        cell.control.put("val3.move", 1.0)
    cell.bench.run(0.2)
    cell.bench.give(Code.STOP, source=1)
    cell.until(lambda: cell.bench.core.state.motion is Motion.STOPPED)
    held = cell.at()
    cell.bench.run(1.0)
    assert cell.at() == held and held[0] < 14.5
    cell.control.put("val3.move", 1.0)
    assert cell.ends(run)[0] == "ended" and cell.at()[0] == pytest.approx(15, abs=0.01)


def test_the_plc_starts_holds_and_stops_it() -> None:
    cell = cell_of("movej(jA,tHand,mStop)\nmovej(jB,tHand,mSlow)\nwaitEndMove()\nwait(diPart)", stop="doDone=true")
    cell.control.put("val3.run", 1.0)
    cell.until(lambda: cell.places[-1][0] > 6.0)
    assert cell.control.value("val3.run") == 1.0
    cell.control.put("val3.hold", 1.0)
    cell.until(lambda: cell.bench.core.state.motion is Motion.STOPPED)
    held = cell.at()
    cell.bench.run(0.5)
    assert cell.at() == held
    cell.control.put("val3.hold", 0.0)
    cell.until(lambda: cell.places[-1][0] > 14.99)
    run = cell.hosted.run
    cell.control.put("val3.run", 0.0)
    assert cell.ends(run)[0] == "stopped" and (DONE, True) in [(bit, on) for _, bit, on in cell.outputs], "stop() has run"
    cell.bench.run(0.3)
    assert cell.hosted.run == 0 and cell.control.value("val3.run") == 0.0, "nothing starts by itself"


def test_the_interpreter_dies_and_the_arm_stops_on_its_path() -> None:
    cell = cell_of("movej(jA,tHand,mStop)\nmovej(jB,tHand,mSlow)\nwaitEndMove()")
    run = cell.start()
    cell.until(lambda: cell.places[-1][0] > 7.0)
    cell.dies()
    cell.until(lambda: cell.bench.core.state.motion is Motion.IDLE, 5.0)
    assert cell.hosted.results[run][0] == "lost" and joint(cell, 1) < 14.0
    assert "the interpreter ended" in cell.programs.faults()[0]
    rest = cell.at()
    cell.born(2)
    cell.bench.run(1.0)
    assert cell.at() == rest and cell.hosted.run == 0
    assert cell.start("demo") and cell.programs.faults() == []


def test_inputs_and_outputs_are_the_points_of_the_cell() -> None:
    code = "wait(diPart)\ndoDone=true\nnOne=1\nwait(!diPart)\nnTwo=ioStatus(doDone)\nnId=ioStatus(doNowhere)\ndoNowhere=true"
    cell = cell_of(code)
    cell.start()
    cell.bench.run(1.0)
    assert cell.value("nOne") == 0.0
    cell.put(PART)
    cell.until(lambda: cell.value("nOne") == 1.0, 1.0)
    cell.bench.run(0.008)
    assert cell.outputs[-1][1:] == (DONE, True)
    cell.control.put("dio.done.lock", 1.0)
    cell.put(PART, False)
    cell.until(lambda: bool(cell.programs.faults()), 1.0)
    assert (cell.value("nTwo"), cell.value("nId")) == (1.0, -2.0)
    assert "error 123" in cell.programs.faults()[0]


def test_autostart_is_for_the_first_interpreter_of_a_run_alone() -> None:
    app = App(data=DATA, programs={"start": "nOne=1\nwait(diPart)"})
    cell = Val3Cell(app.files(), "demo", autostart=True)
    cell.until(lambda: cell.hosted.run == 1, 1.0)
    cell.dies()
    cell.bench.run(0.1)
    cell.born(2)
    cell.bench.run(1.0)
    assert cell.hosted.run == 0


def test_without_control_it_does_not_move_and_says_who_has_it() -> None:
    cell = cell_of("movej(jA,tHand,mStop)\nwaitEndMove()")
    cell.power()
    cell.bench.settle(cell.bench.give(Code.REQUEST_CONTROL, source=TOOL))
    cell.start()
    cell.bench.run(1.0)
    assert any("command source 90" in line for line in cell.told) and joint(cell, 1) == 0.0
    assert len([line for line in cell.told if "command source 90" in line]) == 1


def test_what_an_application_saves_is_there_for_the_next_start() -> None:
    cell = cell_of("nOne=nOne+1\nnTwo=libSave()\nwait(diPart)")
    for count in (1.0, 2.0):
        run = cell.start()
        cell.until(lambda: any(row["line"] == 6 for row in cell.hosted.rows))
        assert cell.value("nOne") == count
        cell.programs.answer({"do": "stop", "name": "demo"}, 0)
        cell.ends(run)


def test_a_move_from_rest_is_on_the_bus_six_cycles_after_the_input_it_waits_for() -> None:
    """The path begins when its last piece is in the cycle, which takes two pieces in a period here (AX-1460)."""
    cell = cell_of("movej(jA,tHand,mStop)\nwaitEndMove()\nnOne=1\nwait(diPart)\nmovej(jB,tHand,mStop)\nwaitEndMove()")
    cell.start()
    cell.until(lambda: cell.language.own is not None and cell.value("nOne") == 1.0)
    cell.bench.run(0.05)
    rest, first = cell.places[-1], len(cell.places)
    cell.put(PART)
    cell.until(lambda: cell.places[-1] != rest, 1.0)
    assert len(cell.places) - first <= 6


@pytest.mark.requirement("VAL-AIO-01", "VAL-AIO-02", by="gateway.pure.languages.val3.cell_io:CellIo.write")
def test_analog_outputs_of_a_cell_answer_what_they_take_and_have_their_description() -> None:
    """L2493-2504: 12.3 on a whole output is 12; what is out of range answers what the output has.  L2551: the description."""
    board = Board("UserIO")
    whole = Point("speed", board, "out", "%QW0", output=True, byte=60, steps=1, low=-100.0, high=100.0, integer=True, description="belt")
    fine = Point("force", board, "out", "%QW1", output=True, byte=62, steps=10, low=-20.0, high=20.0)
    data = "".join(datum(f"ao{name}", "aio", values=value(link=name)) for name in ("speed", "force"))
    code = "n[0]=aioSet(aospeed,12.3)\nn[1]=aioSet(aospeed,101)\nn[2]=aioSet(aospeed,-100.5)\nn[3]=aioSet(aoforce,-12.3)\n"
    code += "n[4]=aioSet(aoforce,99)\nn[5]=ioStatus(aospeed,s[0],s[1])\nn[6]=aioGet(aoforce)"
    made = machine(app := App(data=data + datum("n", "num", "7") + datum("s", "string", "2"), programs={"start": code}))
    made.io = CellIo(owned=(whole, fine))
    found = run(app, on=made)["globals"]
    assert isinstance(found, dict) and found["n"] == [12, 12, -100, -12.3, -12.3, 0, -12.3]
    assert found["s"] == ["belt", "UserIO\\out\\%QW0"]


@pytest.mark.requirement("VAL-WDG-01", by="gateway.pure.languages.val3.cell_robot:CellRobot.look")
def test_nobody_switches_on_behind_an_expired_watchdog() -> None:
    """The source that started the application has control, and enables; its moves wait for wdgRefresh (L3555)."""
    code = "wdgRefresh()\n" + POWER + "movej(jB,tHand,mSlow)\nwait(diPart)\nwhile true\nwdgRefresh()\ndelay(0.1)\nendWhile"
    cell = Val3Cell(App(data=DATA, programs={"start": code}).files(), "demo")
    cell.language.setup = replace(cell.language.setup, watchdog_ns=300_000_000)
    cell.bench.settle(cell.bench.give(Code.REQUEST_CONTROL, source=TOOL))
    assert "run" in cell.programs.answer({"do": "start", "name": "demo"}, TOOL)

    def powered() -> bool:
        return cell.language._robot.powered

    cell.until(powered, 3.0)
    cell.until(lambda: not powered(), 3.0)
    cell.bench.run(0.5)
    rest, every = joint(cell, 1), (1 << len(cell.cell.axis)) - 1
    assert 0.0 < rest < 14.0
    cell.bench.settle(cell.bench.give(Code.ENABLE, mask=every, source=TOOL))
    for _ in range(250):
        cell.bench.cycle()
        assert not powered() and joint(cell, 1) == pytest.approx(rest, abs=0.01)
    assert any("the watchdog of the application is not active" in line for line in cell.words)
    cell.put(PART)
    cell.bench.run(0.2)
    cell.bench.settle(cell.bench.give(Code.ENABLE, mask=every, source=TOOL))
    cell.until(lambda: joint(cell, 1) == pytest.approx(15.0, abs=0.01), 20.0)
