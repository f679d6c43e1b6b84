"""An arm and a SCARA in one cell with eight belts, as real processes: a PLC orders the SCARA's program, whose axes lie behind the arm's.

Judged by the emulator's own record of set values and what the bus log says of the belt's encoder; the recorded run is played again.
"""

import contextlib
import pathlib
from dataclasses import replace

import numpy as np

from drivers.emulator.servo.record import Record
from gateway.recording.file import read
from gateway.recording.replay import recorded_cell, replay
from hil_tests.lab.cells.arm_and_scara import MACHINES, OWN, both
from hil_tests.lab.cells.two_on_belts import FIRST_ID, HEADS, with_belts
from hil_tests.lab.judges.bus_log import Logged
from hil_tests.lab.partners.plc2 import ABORTED, DONE
from hil_tests.lab.running.belt_run import INCREMENT, SPEED, BeltRun
from hil_tests.lab.running.cell_running import P5_MS
from hil_tests.lab.running.program_run import PROGRAM, program_run
from hil_tests.lab.virtual.planned_bench import Driven

BELT = 5
PICK = (
    "linear pose 350 -100 100 180 0 0\nsynchron B5 at=300mm\nlinear pose 350 -50 100 180 0 0 belt=300mm\n"
    "linear pose 350 -50 60 180 0 0 belt=300mm path=60\nsynchron_end\nptp joints 0 90 -200 0\n"
)
PROGRAMS = {1: HEADS["arm"] + "ptp joints 0 30 90 0 60 0\n", 2: HEADS["scara"] + PICK}
STANDS = 4e-6  # m, rad: an increment


def judge(run: BeltRun, record: Record) -> None:
    """Down to the part the flange is where the belt is, and the arm stands."""
    made = Driven(run.programs.cell, record, P5_MS / 1e3)
    assert float(np.ptp(made.sets[:, OWN[0]], axis=0).max()) <= STANDS
    heard = [frame for frame in run.programs.run.bus() if isinstance(frame, Logged) and frame.identifier == FIRST_ID + BELT]
    stamps = np.array([row.stamp_ns for row in record.rows])
    counts = np.interp(stamps, [frame.stamp_ns for frame in heard], [int.from_bytes(frame.data, "little") * INCREMENT for frame in heard])
    places = np.array([MACHINES[1].forward(tuple(float(v) for v in row[OWN[1]])).position for row in made.sets])
    low = int(np.argmin(places[:, 2]))
    on = (np.arange(len(places)) < low) & (places[:, 2] > 0.064) & (places[:, 2] < 0.096) & (np.abs(places[:, 0] - 0.35) < 1e-4)
    assert np.count_nonzero(on) > 20
    off = places[on, 1] - counts[on]
    assert float(np.ptp(places[on, 1])) > 0.03, "along the belt"
    assert float(np.median(np.abs(off - np.median(off)))) < 2e-4, "a set value is made for the SYNC that activates it"


def test_the_robot_behind_the_first_one_picks_from_its_belt_and_the_recorded_run_plays(tmp_path: pathlib.Path) -> None:
    with (
        program_run(tmp_path, "arm6", PROGRAMS, "robots-belts", change=lambda text: with_belts(both(text))) as programs,
        contextlib.closing(BeltRun(programs)) as run,
    ):
        programs.ready()
        with run.recorded(tmp_path / "robots.axrec") as file:
            run.drive(BELT, SPEED)
            run.zero(BELT)
            since = programs.run.record().rows[-1].stamp_ns
            programs.plc.send(PROGRAM, 2)
            assert programs.plc.wait(lambda s: s.state in (DONE, ABORTED), 20).state == DONE, programs.run.words()
        record = programs.run.record()
        judge(run, replace(record, rows=tuple(row for row in record.rows if row.stamp_ns >= since)))
    found = read(file)
    with recorded_cell(found) as cell:
        verdict = replay(found, cell, cell)
    assert verdict.first is None and verdict.cycles == found.cycles > 100, verdict
