"""A whole simulated run with the planner process: a PLC orders programs by their number, a SCARA plays them on emulated drives.

Every way out of a program ends at rest on its path: stop, a silent owner, drives off, the planner killed or held; and nothing goes on
without a fresh command.
"""

import json
import os
import pathlib
import signal
import time
from collections.abc import Iterator

import numpy as np
import pytest

from gateway.commands import motion_run, motion_stream
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import AxisFlag, Motion
from hil_tests.lab.partners.plc2 import ABANDON, ABORTED, ACCEPTED, DISABLE, DONE, ENABLE, OVERRIDE, REFUSED, RELEASE, RESUME, RUNNING, STOP
from hil_tests.lab.running.cell_running import P5_MS
from hil_tests.lab.running.program_run import ON_PATH, PROBE, PROGRAM, ProgramRun, along, away, program_run
from motion.files import bnr

HEAD = "robot sr60-like\nangles rho3\naxes deg deg mm deg\nstart 0 90 -200 0\n"
PROGRAMS = {
    1: HEAD + "ptp joints 0 90 -200 0\n",
    2: HEAD
    + """set path=400
ptp pose 350 -50 105 180 0 0
set radius=12.5
linear pose 350 50 105 180 0 0
linear pose 350 50 80 180 0 0 blend=off out=400:1@10,401:1,400:0
""",
    3: HEAD + "ptp joints 20 80 -180 10\n# too far\nptp joints 20 80 -180 3000\n",
    4: HEAD + "set speed=10\n" + "".join(f"ptp joints {10 * (n % 2)} 90 -200 {10 * n}\n" for n in range(1, 21)),
    6: HEAD + "ptp joints 60 90 -200 0 speed=10 until=ch610 error=NONE\nptp mpos\nlabel NONE\n",
    7: HEAD
    + """iol -2 1 1 0 0 0
ptp pose 350 -50 105 180 0 0
iol 2 1 2 0 1 0
ppo 3 1 2 50 1000 0
linear pose 350 50 105 180 0 0 path=50
""",
    8: HEAD + "ptp joints 20 90 -200 0\n",
    21: HEAD + "read_begin curve.bnr 80\nmove_file curve.bnr modulo=0,0,0,0\n",
    22: HEAD + "read_begin curve.bnr 84\nmove_file curve.bnr modulo=0,0,0,0\n",
    5: HEAD + f"ptp joints 60 90 -200 0 speed=10 until={PROBE}\nptp joints 0 90 -200 0\n",
}
MEASURING = f"\n[[measuring]]\nchannel = 610\ninput = {PROBE}\n"
FUNCTIONS = "".join(
    f'\n[[path_output]]\nkind = "{kind}"\nfunction = {n}\noutput = {out}\n' for kind, n, out in (("iol", 2, 416), ("ppo", 3, 432))
)


@pytest.fixture(scope="module")
def scara(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ProgramRun]:
    folder = tmp_path_factory.mktemp("cell")
    (folder / "curve.bnr").write_bytes(bnr.encode(bnr.Header(time_base_us=1000 * P5_MS, axes=4), POINTS.tolist()))
    with program_run(folder, "scara", PROGRAMS, change=lambda text: text + MEASURING + FUNCTIONS) as run:
        run.ready()
        yield run


@pytest.fixture
def home(scara: ProgramRun) -> ProgramRun:
    """All axes at the place the programs begin at, whatever happened before."""
    scara.ready()
    if scara.state().motion is Motion.STOPPED:
        assert scara.command(ABANDON).state == DONE
    assert scara.command(PROGRAM, 1).state == DONE, scara.run.words()
    return scara


def test_a_program_ordered_by_a_plc_keeps_its_path_at_any_override_through_stop_and_resume(home: ProgramRun) -> None:
    path = home.path(2, home.sets())
    home.moving(2)
    assert home.plc.wait(lambda s: s.state == RUNNING, 5).reason == 0
    rows = [home.watch("some way", lambda s: along(s, path) > 0.4)]
    assert home.command(OVERRIDE, 0, 0.6).state == DONE
    assert home.command(STOP).state == DONE
    rows.append(home.watch("stopped on the path", lambda s: s.motion is Motion.STOPPED))
    assert home.still()
    rows.append(np.array([home.sets()]))
    assert home.command(OVERRIDE, 0, 1.0).state == DONE
    assert not home.output(400) and not home.output(401)
    assert home.command(RESUME).state == DONE
    rows.append(home.watch("at rest", lambda s: s.motion is Motion.IDLE))
    assert home.output(401) and not home.output(400)
    every = np.concatenate(rows)
    assert away(every, path) < ON_PATH
    assert every[-1] == pytest.approx(path[-1], abs=1e-9)
    place = home.machine.kinematics.forward(tuple(axis.actual for axis in home.state().axes[:4])).position
    assert place == pytest.approx((0.35, 0.05, 0.08), abs=5e-4), "the drives have followed"


def test_refusals_come_before_anything_moves_and_say_why(home: ProgramRun) -> None:
    before = home.sets()
    unknown = home.command(PROGRAM, 77)
    assert (unknown.state, unknown.reason) == (REFUSED, Reason.PROGRAM_UNKNOWN)
    far = home.command(PROGRAM, 3)
    assert (far.state, far.reason) == (REFUSED, Reason.PROGRAM_FAULT)
    said = [entry["text"] for entry in home.run.journal("command") if "cannot be run" in entry["text"]]
    assert "line 7: block 2, axis A4" in said[-1] and "VAL 3 520" in said[-1]
    assert home.sets() == before
    assert home.command(DISABLE, home.all).state == DONE
    off = home.command(PROGRAM, 2)
    assert (off.state, off.reason) == (REFUSED, Reason.DRIVES_OFF)
    assert home.command(ENABLE, home.all).state == DONE
    assert max(abs(a - b) for a, b in zip(home.sets(), before, strict=True)) < 1e-3


def test_a_tool_runs_a_program_when_it_has_control_and_gets_the_reason_else(home: ProgramRun, capsys: pytest.CaptureFixture[str]) -> None:
    cell, name = home.run.cell, home.run.name
    assert motion_run.main([cell, "9", "--name", name]) == 2 and "there is 1 p1" in capsys.readouterr().err
    assert motion_run.main([cell, "2", "--name", "nobody"]) == 3
    assert motion_run.main([cell, "p2", "--name", name]) == 1 and "NOT_OWNER" in capsys.readouterr().err
    assert home.command(RELEASE).state == DONE
    assert motion_run.main([cell, "3", "--name", name]) == 1 and "line 7: block 2, axis A4" in capsys.readouterr().out
    assert motion_run.main([cell, "p2", "--name", name, "--json", "--speed", "90"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["state"], told["program"]) == ("DONE", 2) and told["axes"]["A3"] == pytest.approx(-220.0, abs=0.5)


def test_a_tool_says_a_stream_and_hears_of_each_block(home: ProgramRun, tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell, name, moves = home.run.cell, home.run.name, tmp_path / "moves.txt"
    home.probe(False)
    moves.write_text(
        f"angles rho3\naxes deg deg mm deg\nptp joints 3 90 -200 0\nptp joints 6 90 -200 0 until={PROBE}\n\nptp rel joints 1 0 0 0\n"
    )
    assert motion_stream.main([cell, str(moves), "--name", name]) == 1 and "NOT_OWNER" in capsys.readouterr().err
    assert home.command(RELEASE).state == DONE
    assert motion_stream.main([cell, str(moves), "--name", name, "--robot", "2"]) == 2
    assert motion_stream.main([cell, str(moves), "--name", name]) == 0
    told = capsys.readouterr().out.splitlines()
    assert "block 2: not met" in told and told[-1] == "done"
    assert home.state().axes[0].set == pytest.approx(np.radians(7.0), abs=1e-9)
    moves.write_text("axes deg deg mm deg\nptp joints 5 90 -200 0\nptp joints 9000 90 -200 0\n")
    assert motion_stream.main([cell, str(moves), "--name", name]) == 1
    assert "block 2, axis A1: target 9000 deg" in capsys.readouterr().out
    moves.write_text("axes deg deg mm deg\n!single\nptp joints 5 90 -200 0\nptp joints 6 90 -200 0\n!step\n!step\n!run\n")
    assert motion_stream.main([cell, str(moves), "--name", name]) == 0
    assert home.state().axes[0].set == pytest.approx(np.radians(6.0), abs=1e-9)
    moves.write_text("axes deg deg mm deg\nptp joints 5 90 -200 0\n!cut 7\n")
    assert motion_stream.main([cell, str(moves), "--name", name]) == 1
    assert "cut after block 7; the stream has blocks 1 .. 1" in capsys.readouterr().err


def test_an_input_ends_a_block_on_its_path_and_the_next_one_begins_there(home: ProgramRun) -> None:
    home.probe(False)
    home.plc.send(PROGRAM, 5)
    home.watch("some way", lambda s: s.axes[0].set > 0.1)
    home.probe(True)
    rows = home.watch("done", lambda s: s.motion is Motion.IDLE)
    assert home.plc.wait(lambda s: s.state in (DONE, ABORTED), 5).state == DONE
    assert 0.1 < rows[:, 0].max() < 0.9 and rows[-1][0] == pytest.approx(0.0, abs=1e-9)
    home.probe(True)
    assert home.command(PROGRAM, 5).state == DONE and home.state().axes[0].set == pytest.approx(0.0, abs=1e-9)


def test_a_probe_of_the_plc_stops_a_block_and_mpos_lies_behind_the_axes_where_the_next_block_goes(home: ProgramRun) -> None:
    home.probe(False)
    home.plc.send(PROGRAM, 6)
    home.watch("some way", lambda s: s.axes[0].set > 0.1)
    home.probe(True)
    home.watch("measured", lambda s: s.measured_mask == home.all)
    measured = home.state().axes[0].measured
    rows = home.watch("done", lambda s: s.motion is Motion.IDLE)
    assert home.plc.wait(lambda s: s.state in (DONE, ABORTED), 5).state == DONE
    assert 0.05 < measured < rows[:, 0].max(), "caught at the edge, before the axes had stopped"
    assert rows[-1][0] == pytest.approx(measured, abs=1e-9), "MOVE TO @MPOS"
    assert home.command(PROGRAM, 6).state == DONE
    assert home.state().axes[0].set == pytest.approx(np.pi / 3, abs=1e-9) and not home.state().measured_mask, "no edge: the label"


def test_outputs_led_by_a_coordinate_are_seen_by_the_plc_over_modbus(home: ProgramRun) -> None:
    home.plc.send(PROGRAM, 7)
    home.watch("on the line", lambda s: place(home)[1] > -0.045 and s.piece > 0)
    seen = []
    while home.state().motion is not Motion.IDLE:
        before = place(home)[1]
        seen.append((before, *home.plc_outputs(416, 432), place(home)[1]))
        time.sleep(0.002)  # on the guest's clock nothing moves while nobody sleeps
    assert home.plc.wait(lambda s: s.state in (DONE, ABORTED), 5).state == DONE
    assert home.plc_outputs(416, 432) == (True, 1000)
    for before, on, value, after in seen:
        assert not on or after > -1e-6, "not before the path is at y = 0"
        assert value - 500 <= 10.0 * after * 1e3 + 2, f"it leads with the coordinate, which was at {before}"
    assert {on for _, on, _, _ in seen} == {False, True} and len({value for _, _, value, _ in seen}) > 5


K = np.arange(1, 301) / 300
POINTS = np.outer(10 * K**3 - 15 * K**4 + 6 * K**5, (40.0, -20.0, 30.0, 60.0)) + (0.0, 90.0, -200.0, 0.0)  # mm and deg


def test_the_points_of_a_bnr_file_are_the_set_values_of_the_cycle(home: ProgramRun) -> None:
    points = np.array([(0.0, 90.0, -200.0, 0.0), *POINTS], dtype=np.float32).astype(float) * np.array(
        [np.pi / 180, np.pi / 180, 1e-3, np.pi / 180]
    )
    home.plc.send(PROGRAM, 21)
    rows = home.watch("on its way", lambda s: s.motion is Motion.RUNNING)
    rows = home.watch("at rest", lambda s: s.motion is Motion.IDLE)
    assert home.plc.wait(lambda s: s.state in (DONE, ABORTED), 5).state == DONE
    seen = np.unique(rows[np.abs(rows - home.sets()).max(axis=1) > 1e-3], axis=0)
    nearest = [np.abs(points - row).max(axis=1).min() for row in seen]
    assert len(seen) > 20 and max(nearest) < 1e-9, "what is seen of it are its points"
    assert home.sets() == pytest.approx(points[-1], abs=1e-9)
    wrong = home.command(PROGRAM, 22)
    assert (wrong.state, wrong.reason) == (REFUSED, Reason.PROGRAM_FAULT)
    said = [entry["text"] for entry in home.run.journal("command") if "cannot be run" in entry["text"]]
    assert "line 6: block 1: MF: Format error: curve.bnr" in said[-1] and "(rho 3 100)" in said[-1]


def place(home: ProgramRun) -> tuple[float, float, float]:
    """Of the tool, from set values."""
    return home.machine.kinematics.forward(home.sets()).position


def test_a_silent_owner_stops_it_on_the_path_and_it_does_not_go_on_by_itself(home: ProgramRun) -> None:
    path = home.path(4, home.sets())
    home.moving(4)
    home.plc.polls.clear()
    rows = home.watch("stopped on the path", lambda s: s.motion is Motion.STOPPED)
    home.plc.polls.set()
    home.plc.wait(lambda s: True, 5)
    assert home.still() and away(rows, path) < ON_PATH
    assert home.state().stop_cause == Reason.LINK_LOST
    home.plc.synchronise()
    assert home.command(ABANDON).state == DONE


A3 = 4  # the Z axis: programs 4 and 8 have no use for it


def test_an_axis_that_takes_no_part_is_switched_off_and_the_others_go_on(home: ProgramRun) -> None:
    path = home.path(4, home.sets())
    home.moving(4)
    assert home.command(DISABLE, A3).state == DONE
    before = along(home.state(), path)
    home.watch("some way further", lambda s: along(s, path) > before + 0.1)
    assert not home.state().axes[2].flags & AxisFlag.ENABLED and home.state().motion is Motion.RUNNING
    back = home.command(ENABLE, A3)
    assert (back.state, back.reason) == (ABORTED, Reason.DRIVE_ON_NOT_ALLOWED)
    rows = home.watch("at rest", lambda s: s.motion is Motion.IDLE)
    assert home.still() and away(rows[:, [0, 1, 3]], path[:, [0, 1, 3]]) < ON_PATH, "on the path"
    said = [entry["text"] for entry in home.run.journal("command")]
    assert any("DRIVE ON not allowed: axis A3" in text for text in said)
    assert home.command(PROGRAM, 8).state == DONE and home.state().axes[0].set == pytest.approx(np.radians(20.0), abs=1e-9)
    needs = home.command(PROGRAM, 2)
    assert (needs.state, needs.reason) == (REFUSED, Reason.PROGRAM_FAULT)
    assert "axis A3: DRIVE ON not avail." in [entry["text"] for entry in home.run.journal("command")][-1]
    assert home.command(ENABLE, A3).state == DONE
    assert home.command(PROGRAM, 1).state == DONE


def test_drives_off_end_it(home: ProgramRun) -> None:
    home.moving(4)
    assert home.command(DISABLE, home.all).state == DONE
    home.watch("at rest", lambda s: s.motion is Motion.IDLE)
    assert home.command(ENABLE, home.all).state == DONE
    assert home.still() and home.state().failed_reason == Reason.DRIVES_OFF


def test_a_planner_held_and_then_killed_leaves_the_axes_at_rest_on_the_path(home: ProgramRun) -> None:
    path = home.path(4, home.sets())
    home.moving(4)
    pid = home.run.pid("planner")
    os.kill(pid, signal.SIGSTOP)
    try:
        rows = [home.watch("what was handed on is run", lambda s: s.piece == 0)]
        assert home.still() and along(home.state(), path) < 0.8
        assert home.plc.wait(lambda s: True, 5).state == RUNNING
    finally:
        os.kill(pid, signal.SIGCONT)
    rows.append(home.watch("it goes on where it stands", lambda s: s.piece > 0))
    dead, _ = home.run.kill("planner")
    rows.append(home.watch("at rest", lambda s: s.motion is Motion.IDLE))
    home.run.back("planner", dead)
    assert home.plc.wait(lambda s: s.state == ABORTED, 5).reason == Reason.PLANNER_LOST
    assert home.still() and along(home.state(), path) < 0.95
    assert away(np.concatenate(rows), path) < ON_PATH
    home.run.forgive("planner")


def test_a_planner_held_before_the_first_piece_moves_nothing_and_a_stop_ends_the_order(home: ProgramRun) -> None:
    pid = home.run.pid("planner")
    os.kill(pid, signal.SIGSTOP)
    try:
        home.plc.send(PROGRAM, 2)
        status = home.plc.wait(lambda s: s.state in (ACCEPTED, REFUSED), 5)
        assert status.state == ACCEPTED and home.still()
        assert home.command(STOP).state == DONE
    finally:
        os.kill(pid, signal.SIGCONT)
    assert home.still(0.6), "its pieces come too late"
    assert home.state().failed_reason == Reason.STOPPED_BY_SOURCE
