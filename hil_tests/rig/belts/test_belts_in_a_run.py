"""A whole simulated run with belts: a PLC orders programs, a portal works on a belt whose encoder is on the drive bus.

The bus log is the witness of set values and counts.  Everything else about belts is proved in virtual time:
hil_tests/unit/gateway/pure/cycle/belts.
"""

import contextlib
import os
import pathlib
import signal
import sqlite3
import struct
import time
from collections.abc import Iterator
from math import nan

import numpy as np
import pytest

from gateway.assembly.axis_scaling import scaling_of
from gateway.pure.image.reasons import Reason
from gateway.pure.image.records.cell import CellState, Motion
from gateway.recording.file import read
from gateway.recording.replay import recorded_cell, replay
from hil_tests.lab.judges.bus_log import Logged
from hil_tests.lab.partners.plc2 import ABORTED, DONE, REFUSED
from hil_tests.lab.running.belt_run import FIRST_ID, INCREMENT, SPEED, BeltRun, belt_run
from hil_tests.lab.running.program_run import PROGRAM
from motion.sync.belts import SET_COUNTER
from motion.sync.cam import cam
from protocols.servodyn.plan import SYNC_ID, set_id

HEAD = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\n"
PROGRAMS = {
    1: HEAD + "ptp joints 100 100 50 0\n",
    2: HEAD + "synchron B1 at=60mm\nlinear pose 150 150 50 0 0 0 belt=60mm\nlinear pose 150 150 90 0 0 0 belt=60mm path=60\nsynchron_end\n"
    "linear pose 100 100 50 0 0 0\n",
    3: HEAD + "synchron B2 at=4000mm\nlinear pose 200 150 50 0 0 0 belt=4100mm\n",
    5: HEAD + "set_beltcnt 1 -40\nbelt_type 1 3\nsync B1 >= 130mm\nsynchron B1 at=20mm\n"
    "linear pose 200 100 50 0 0 0 belt=120mm camin=30mm camout=50mm\nsynchron_end\nset_beltcnt 1 0\nbelt_type 1 1\n",
    6: HEAD + "set_beltcnt 4 0\n",
    4: HEAD + "set path=20\nsynchron B1\n" + "linear pose 100 110 50 0 0 0\nlinear pose 100 100 50 0 0 0\n" * 20,
}


@pytest.fixture(scope="module")
def portal(tmp_path_factory: pytest.TempPathFactory) -> Iterator[BeltRun]:
    with belt_run(tmp_path_factory.mktemp("cell"), PROGRAMS) as run:
        yield run


@pytest.fixture
def home(portal: BeltRun) -> BeltRun:
    """Drives on, the axes where programs begin, every belt at rest."""
    for kind in (1, 2, 3):
        portal.drive(kind, 0.0)
    portal.programs.ready()
    assert portal.programs.command(PROGRAM, 1).state == DONE, portal.programs.run.words()
    return portal


def started(home: BeltRun, number: int, kind: int) -> None:
    """The belt at its speed, its counter from 0, the program ordered."""
    home.drive(kind, SPEED)
    home.programs.watch("the belt runs", lambda s: kind != 1 or s.belt_speed > 0.99 * SPEED)
    home.zero(kind)
    home.programs.plc.send(PROGRAM, number)


def burst_rows(home: BeltRun) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """(SYNCs, 4): set values of X, Y, Z as the burst of a SYNC carries them, and what the belt's encoder says after the next; m."""
    scalings = [scaling_of(axis) for axis in home.programs.cell.axis[:3]]
    rows: list[list[float]] = []
    for frame in home.programs.run.bus():
        if not isinstance(frame, Logged):
            continue
        if frame.identifier == SYNC_ID:
            rows.append([np.nan] * 4)
        elif rows and frame.identifier == FIRST_ID + 1 and len(rows) > 1:
            rows[-2][3] = int.from_bytes(frame.data, "little") * INCREMENT
        for n, scaling in enumerate(scalings):
            if rows and frame.identifier == set_id(n + 1):
                rows[-1][n] = scaling.to_si(struct.unpack_from("<i", frame.data, 2)[0])
    return np.array(rows)


def test_set_values_on_the_bus_go_with_the_belts_encoder_and_the_program_goes_on_beside_it(home: BeltRun) -> None:
    started(home, 2, 1)
    states = home.snapshots()
    assert home.programs.plc.wait(lambda s: s.state in (DONE, ABORTED), 10).state == DONE, home.programs.run.words()
    assert states[-1].axes[0].set == pytest.approx(0.1, abs=1e-9) and states[-1].axes[1].set == pytest.approx(0.1, abs=1e-9)
    rows = burst_rows(home)
    on = rows[(np.abs(rows[:, 1] - 0.15) < 1e-5) & (rows[:, 2] > 0.054) & (rows[:, 2] < 0.088) & ~np.isnan(rows[:, 3])]
    assert len(on) > 20
    off = on[:, 0] - on[:, 3]
    middle = float(np.median(off))
    assert float(np.median(np.abs(off - middle))) < 2e-4, "a set value is made for the SYNC that activates it"


def test_a_recorded_run_with_belts_plays_without_a_difference(home: BeltRun, tmp_path: pathlib.Path) -> None:
    """Encoders are inputs of the run; the program goes onto its belt in the recording."""
    with home.recorded(tmp_path / "belts.axrec") as file:
        started(home, 2, 1)
        assert home.programs.plc.wait(lambda s: s.state in (DONE, ABORTED), 10).state == DONE, home.programs.run.words()
    found = read(file)
    with recorded_cell(found) as cell:
        verdict = replay(found, cell, cell)
    assert verdict.first is None and verdict.cycles == found.cycles > 100, verdict


def test_a_belt_that_turns_round_opens_ready_and_says_928(home: BeltRun) -> None:
    run = home.programs
    started(home, 3, 2)
    run.watch("the robot waits for its belt", lambda s: s.job > 0 and s.belt > 0.02)
    assert run.output(64)
    home.drive(2, -SPEED)
    run.watch("the drives are off", lambda s: s.motion is Motion.IDLE and s.failed_reason == Reason.BELT_FAULT)
    status = run.plc.wait(lambda s: s.state in (DONE, ABORTED), 10)
    assert (status.state, status.reason) == (ABORTED, Reason.BELT_FAULT)
    assert not run.output(64) and run.output(67), "READY is open"
    said = [entry["text"] for entry in run.run.journal("command")][-1]
    assert "block 1, kinematic 1: wrong belt direction (rho 3 928)" in said


def test_statements_of_belts_run_where_the_program_is(home: BeltRun) -> None:
    """SF 28, SF 21, SYNC, and a part by the type that was set: B1 is of type 1 in its cell."""
    run = home.programs
    started(home, 5, 1)
    states = home.snapshots()
    assert run.plc.wait(lambda s: s.state in (DONE, ABORTED), 10).state == DONE, run.run.words()
    belts = np.array([[state.belt, state.axes[0].set] for state in states])
    jump = int(np.argmin(np.diff(belts[:, 0])))
    assert belts[jump, 0] > 0.1 and belts[jump + 1, 0] < 0.0, "SYNC B1 >= 130 mm: the counter is -40 mm again"
    assert np.ptp(belts[: jump + 1, 1]) < 1e-9, "and nothing has moved before"
    inside = belts[jump + 1 :][(belts[jump + 1 :, 0] > 0.022) & (belts[jump + 1 :, 0] < 0.118)]
    curve = cam(0.1, 0.03, 0.05)
    off = [place - 0.1 - 0.1 * curve.at(belt - 0.020)[0] for belt, place in inside]
    assert len(inside) > 5 and max(map(abs, off)) < 1e-8, "the cam"
    assert run.command(PROGRAM, 6).state == REFUSED
    said = [entry["text"] for entry in run.run.journal("command")][-1]
    assert "belt 4: Inadmiss. Belt-No, P501 = 3 (rho 3 93)" in said


def test_a_planner_killed_on_a_belt_leaves_the_robot_at_rest_beside_it(home: BeltRun) -> None:
    run = home.programs
    started(home, 4, 1)
    run.watch("on the belt", lambda s: s.parts > 0 and s.axes[1].set > 0.104 and abs(s.axes[0].speed) > 0.1)
    pid = run.run.pid("planner")
    os.kill(pid, signal.SIGKILL)
    run.watch("at rest", lambda s: s.motion is Motion.IDLE and s.job == 0)
    status = run.plc.wait(lambda s: s.state in (DONE, ABORTED), 10)
    assert (status.state, status.reason) == (ABORTED, Reason.PLANNER_LOST)
    assert run.still() and run.state().belt_speed > 0.1, "though the belt runs on"
    run.run.back("planner", pid)
    run.run.forgive("planner")


def test_a_belts_counter_is_kept_on_disk_and_comes_back_with_a_new_cycle(portal: BeltRun) -> None:
    """AX-480; the emulated encoder counts on meanwhile."""
    run, path = portal.programs, pathlib.Path(portal.programs.run.status()["folder"]) / "retain.sqlite"
    begin, first = run.state().belt, kept_offset(path)
    portal.drive(1, SPEED)
    run.watch("a part of a turn", lambda s: s.belt > begin + 0.2)
    run.coil(SET_COUNTER, True)
    run.watch("set to 0", lambda s: s.belt < begin + 0.2)
    run.coil(SET_COUNTER, False)
    run.watch("somewhere else", lambda s: s.belt > 0.05)
    portal.drive(1, 0.0)
    places = [nan] * 100

    def stands(state: CellState) -> bool:
        places[:] = [*places[1:], state.belt]
        return len(set(places)) == 1

    run.watch("it stands", stands)
    before, until = run.state().belt, time.monotonic() + 20
    while (found := kept_offset(path)) is None or (first is not None and abs(found - first) < 0.1):
        assert time.monotonic() < until, f"{found} is kept, {first} before the counter was set"
        time.sleep(0.05)
    pid = run.run.pid("cycle")
    os.kill(pid, signal.SIGKILL)
    run.run.back("cycle", pid)
    run.watch("the counter is back", lambda s: abs(s.belt - before) < 2 * INCREMENT and s.cycle > 10)
    run.run.forgive("cycle")


def kept_offset(path: pathlib.Path) -> float | None:
    """Of the first belt, m; None: not there yet."""
    with contextlib.suppress(sqlite3.Error), contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as connection:
        row = connection.execute("SELECT data FROM value WHERE name = 'belt.B1.offset'").fetchone()
        return None if row is None else float(row[0])
    return None
